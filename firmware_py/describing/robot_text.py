"""The text of a robot file, from answers."""

from __future__ import annotations

import math
from collections.abc import Callable
from typing import TYPE_CHECKING

from deltactl.firmware_py.describing.question import UNKNOWN
from deltactl.firmware_py.describing.questions import (
    EFFORT_GAIN,
    GEAR,
    INERTIA,
    LENGTHS,
    MICROSTEPS,
    Answers,
    numbers,
)

if TYPE_CHECKING:
    pass

NOTE = "# Made by deltactl init. All keys: docs/reference/robots.md in the source of deltactl"


def robot_text(kind: str, answers: Answers, wired: bool) -> str:
    """YAML of a machine of this kind. Raises ConfigError for an answer that is no number."""
    makers: dict[str, Callable[[Answers], list[str]]] = {
        "delta": _delta,
        "stepper_axis": _stepper,
        "servo_axis": _servo,
    }
    lines = [NOTE, f"kind: {kind}", f"name: {_text(answers['name'])}"]
    if kind in makers:
        lines += makers[kind](answers)
    if kind == "delta":
        lines += _wiring(answers) if wired else NO_WIRING
    return "\n".join(lines) + "\n"


MOVED, GAIN = INERTIA.key, EFFORT_GAIN.key
"""Keys of an axis whose effort is recorded."""
ZERO = "# absolute: at a command of 30 it reads 30; arbitrary: it may read 217, always as far off"
OF_EFFORT = "# N m (or N) for one unit of the effort; unknown: sizes are in that unit"
NO_WIRING = [
    "",
    "# No pins, limits or homing are said: this file runs simulated, not on hardware.",
    "# 'deltactl init delta FILE --wiring' asks for them.",
]


def _delta(answers: Answers) -> list[str]:
    keys = [length.key for length in LENGTHS]
    metres = {key.removesuffix("_mm"): numbers(answers, key)[0] / 1000.0 for key in keys}
    below = metres["forearm"] + metres["upper_arm"]
    return [
        "",
        "# Origin: middle of the base, height of the motor axes. z points up, so the platform's is",
        "# negative; x points to motor 1. An arm angle is 0 where the arm is level, positive below",
        "geometry:",
        *(f"  {key}_m: {_number(value)}" for key, value in metres.items()),
        "  azimuth_deg: [0, 120, 240]   # directions of the arms, seen from above",
        *_drive(answers),
        *(NO_SENSORS if answers["sensors"] == "none" else _sensors(below)),
    ]


NO_SENSORS = [
    "",
    "# No distance sensors: only you can see whether an arm is off at home, so homing asks for",
    "# --accept-unseen on the real robot.",
]


def _sensors(below_m: float) -> list[str]:
    beside, above = _number(round(below_m, 3)), _number(round(1.2 * below_m, 3))
    return [
        "",
        "# Three distance sensors; delete this section if there are none. One reports",
        "# offset + axis . p, with p the platform's position. The offsets are a guess; 'deltactl",
        "# sensors --calibrate z=0.412' says what they are.",
        "sensors:",
        f"  x: {{offset_m: {beside}, axis: [1, 0, 0]}}",
        f"  y: {{offset_m: {beside}, axis: [0, 1, 0]}}",
        f"  z: {{offset_m: {above}, axis: [0, 0, 1]}}",
    ]


def _drive(answers: Answers) -> list[str]:
    steps, gear = numbers(answers, MICROSTEPS.key)[0], numbers(answers, GEAR.key)[0]
    return [
        "",
        "drive:",
        f"  microsteps_per_rev: {_number(steps)}",
        f"  gear_ratio: {_number(gear)}",
    ]


def _stepper(answers: Answers) -> list[str]:
    return [
        *_drive(answers),
        f"zero: {answers['zero']}   {ZERO}",
    ]


def _servo(answers: Answers) -> list[str]:
    inertia, gain = numbers(answers, MOVED)[0], _known(answers, GAIN)
    unit = "kg" if answers["motion"] == "linear" else "kg m2"
    lines = [f"motion: {answers['motion']}"]
    if inertia > 0.0:
        lines.append(f"inertia: {_number(inertia)}   # {unit}")
    else:
        lines.append(f"# inertia: 0.1   # {unit}; needed where the recording has an effort column")
    if gain is None and inertia > 0.0:
        lines.append(f"effort_gain: {UNKNOWN}   {OF_EFFORT}")
    elif gain is not None and (inertia > 0.0 or gain != 1.0):
        lines.append(f"effort_gain: {_number(gain)}")
    if answers["motion"] == "rotary":
        lines.append(_hanging(answers))
    elif answers["recorded"] != "command" or answers["slope_n"] != UNKNOWN:
        lines.append(_slope(answers))
    return [
        *lines,
        f"zero: {answers['zero']}   {ZERO}",
    ]


NOTHING = "# nothing pulls at it: level, upright or balanced"


def _known(answers: Answers, key: str) -> float | None:
    """A number that was answered, None where nobody knows it."""
    return None if answers[key] == UNKNOWN else numbers(answers, key)[0]


def _slope(answers: Answers) -> str:
    """What weight does to a slide; an example behind a # where nobody knows."""
    force_n = _known(answers, "slope_n")
    if force_n == 0.0:
        return f"gravity: {{force_n: 0}}   {NOTHING}"
    said = f"gravity: {{force_n: {_number(force_n or 20.0)}}}   #"
    if not force_n:
        return f"# {said} only for a slide on a slope: N that hold it there"
    return f"{said} N that hold it on its slope"


def _hanging(answers: Answers) -> str:
    """What weight does to an axis that turns; an example behind a # where nobody knows."""
    torque_nm, constant_nm = _known(answers, "hanging_nm"), _known(answers, "constant_nm")
    constant = f"constant_nm: {_number(constant_nm or 1.0)}"
    load = f"gravity: {{{constant}}}   #"
    if constant_nm is None and not torque_nm:
        return f"# {load} only where a load pulls at every angle: N m that hold it"
    if constant_nm and not torque_nm:
        return f"{load} the load: N m that hold it at every angle"
    if torque_nm == 0.0:
        return f"gravity: {{torque_nm: 0}}   {NOTHING}"
    zero = _number(math.radians(numbers(answers, "hanging_deg")[0]))
    weight = f"torque_nm: {_number(torque_nm or 1.5)}, zero_rad: {zero}"
    said = f"gravity: {{{weight}{f', {constant}' if constant_nm else ''}}}   #"
    means = "N m that hold it level; the angle in rad at which it hangs straight down"
    if not torque_nm:
        return f"# {said} only where a weight hangs on the axis: {means}"
    return f"{said} the weight: {means}"


def _wiring(answers: Answers) -> list[str]:
    low, high = numbers(answers, "arm_deg", 2)
    return [
        "",
        "steps:                        # BCM numbers",
        f"  step_pins: {_pins(answers, 'step_pins')}",
        f"  direction_pins: {_pins(answers, 'direction_pins')}",
        f"  enable_pin: {_pin(answers, 'enable_pin')}",
        f"  alarm_pins: {_pins(answers, 'alarm_pins')}",
        "",
        "inputs:",
        f"  estop_pin: {_pin(answers, 'estop_pin')}",
        "",
        *([] if answers["sensors"] == "none" else _ranging(answers)),
        "limits:                       # checked along the whole path before anything moves",
        f"  arm_deg: [{_number(low)}, {_number(high)}]",
        *(
            f"  {key}: {_number(numbers(answers, key)[0])}"
            for key in (
                *("step_rate_hz", "joint_speed_radps", "joint_acceleration_radps2"),
                "approach_speed_radps",
            )
        ),
        "",
        "homing:",
        "  method: placed              # the arms are put against stops or a jig by hand",
        f"  angle_deg: [{', '.join(map(_number, numbers(answers, 'home_deg', 3)))}]",
    ]


def _ranging(answers: Answers) -> list[str]:
    return ["ranging:", f"  xshut_pins: {_pins(answers, 'xshut_pins')}", ""]


def _pins(answers: Answers, key: str) -> str:
    if _none(answers[key]):
        return "null"
    return f"[{', '.join(map(_number, numbers(answers, key, 3)))}]"


def _pin(answers: Answers, key: str) -> str:
    return "null" if _none(answers[key]) else _number(numbers(answers, key)[0])


def _none(text: str) -> bool:
    return text.strip().lower() in ("none", "no", "null", "-", "")


def _number(value: float) -> str:
    return str(int(value)) if value == int(value) else f"{value:.10g}"


def _text(value: str) -> str:
    return "'" + value.replace("'", "''") + "'" if not value.replace("-", "").isalnum() else value
