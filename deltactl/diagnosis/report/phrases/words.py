"""Effects, components and what a mismatch follows, in a mechanic's words."""

from __future__ import annotations

import re
from collections.abc import Sequence

from deltactl.foundation.counting import count as count

EFFECTS: dict[str, str] = {
    "gear_backlash": "free play in the gear or coupling of {part}",
    "joint_friction": "bearing friction in {part}",
    "viscous_friction": "friction that grows with speed in {part}",
    "stribeck_friction": "friction in {part} that falls with speed near standstill",
    "joint_compliance": "shafts of {part} that yield under load",
    "home_offset": "a wrong home angle of {part}",
    "gear_ratio": "a wrong gear ratio of {part}",
    "transmission_error": "a periodic error of the gear or coupling of {part}",
    "encoder_error": "a periodic error of the angle encoder of {part}",
    "lost_steps": "steps lost by {part}",
    "following_lag": "a drive of {part} that follows late",
    "upper_arm_length": "a wrong length of the upper arm of {part}",
    "forearm_length": "a wrong length of the forearm of {part}",
    "base_radius": "a wrong radius of the base or the platform",
    "motor_azimuth": "a wrong direction of {part} around the base",
    "frame_tilt": "sensors turned against the robot",
    "thermal_expansion": "arms that grow while they warm up",
    "payload": "a wrong mass at {part}",
    "contact": "something in the way of {part}",
    "resonance": "ringing of {part} after moves",
    "sensor_offset": "a constant error of {part}",
    "sensor_scale": "a wrong scale of {part}",
    "sensor_crosstalk": "an error of {part} that grows with the distance squared",
    "sensor_drift": "a drift of {part}",
    "sensor_latency": "readings that come late",
    "stale_reading": "old values repeated by {part}",
    "inertia": "a wrong inertia of {part}",
    "effort_offset": "a constant force or torque on {part}",
    "effort_gain": "a wrong scale between effort and force or torque of {part}",
    "unknown": "an unknown error at {part}",
}
"""The vocabulary of the contract as noun phrases."""

OF_AN_AXIS: dict[str, str] = {
    "home_offset": "a wrong home position of {part}",
    "encoder_error": "a periodic error of the encoder of {part}",
    "gear_backlash": "free play between drive and load of {part}",
    "gear_ratio": "a wrong ratio between command and motion of {part}",
    "transmission_error": "a periodic error of the gear, screw or belt of {part}",
    "joint_friction": "dry friction in {part}",
    "viscous_friction": "viscous friction in {part}",
    "joint_compliance": "parts of {part} that yield under load",
}
"""What is called otherwise where nothing need turn, and no gear be."""

OF_EFFORT: dict[str, str] = {
    "following_lag": "a delay between effort and motion of {part}",
}
"""What is called otherwise where an effort says what moves the axis, and no command."""

FURTHER: dict[str, str] = {
    "gear_backlash": "further play of {part}",
    "home_offset": "a further offset of {part}",
    "gear_ratio": "a further error of the ratio of {part}",
    "transmission_error": "a further periodic error of the gear, screw or belt of {part}",
    "encoder_error": "a further periodic error of the encoder of {part}",
    "joint_friction": "further dry friction in {part}",
    "viscous_friction": "further viscous friction in {part}",
    "joint_compliance": "further yielding of {part} under load",
    "following_lag": "a further delay of {part}",
}
"""Of what the robot file has already: on top of that."""
BEYOND = "{phrase} beyond what the robot file has"
"""Of whatever else the robot file has."""

OF_SEVERAL: dict[str, str] = {
    "gear_backlash": "free play in the gears or couplings of {part}",
    "home_offset": "wrong home angles of {part}",
    "gear_ratio": "wrong gear ratios of {part}",
    "transmission_error": "periodic errors of the gears or couplings of {part}",
    "encoder_error": "periodic errors of the angle encoders of {part}",
    "following_lag": "drives of {part} that follow late",
    "upper_arm_length": "wrong upper arm lengths of {part}",
    "forearm_length": "wrong forearm lengths of {part}",
    "motor_azimuth": "wrong directions of {part} around the base",
    "sensor_offset": "constant errors of {part}",
    "sensor_scale": "wrong scales of {part}",
    "sensor_crosstalk": "errors of {part} that grow with the distance squared",
    "sensor_drift": "drifts of {part}",
}
"""What is spoken of otherwise where several parts have it."""

PARTS: dict[str, str] = {
    "joints": "all joints",
    "arms": "the arms",
    "frame": "the frame",
    "platform": "the platform",
    "sensors": "the sensors",
    "sensor": "the sensor",
    "axis": "the axis",
    "time": "the time stamps",
}
"""Components that carry no number; the others are made by `part`."""

_MOTORS = ("motor1", "motor2", "motor3")
_OF_A_SENSOR = ("sensor_offset", "sensor_scale", "sensor_crosstalk", "sensor_drift")

_NAMED_EFFECT = re.compile(
    rf"\b({'|'.join(EFFECTS)})\b\s*(?:@|:|/|\bat\b|\bof\b|\()?\s*"
    rf"\b((?:motor|arm)[123]|range_[xyz]|{'|'.join(PARTS)})\b\)?"
)
"""'gear_backlash motor2', 'gear_backlash at motor2', 'gear_backlash@motor2'."""
_FOLLOWED: tuple[tuple[str, str], ...] = (
    (r"theta_([123])", "the angle of arm {0}"),
    (r"(?:speed|velocity)_([123])", "the speed of motor {0}"),
    (r"(?:torque|load)_([123])", "the load on motor {0}"),
    (r"(?:acceleration|accel)_([123])", "the acceleration of motor {0}"),
    (r"direction_([123])", "the direction in which motor {0} turns"),
    (r"current_([123])", "the current of motor {0}"),
    (r"speed_range_([xyz])", "the speed of the platform along {0}"),
    (r"(?:range|pos|position)_([xyz])", "where the platform is along {0}"),
    (r"temp_c|temperature", "the temperature"),
    (r"range_x, range_y", "how far the platform is from the middle"),
    (r"t_pwm", "the step period"),
    (r"time|t", "the time since the start"),
    (r"position|angle", "the position"),
    (r"speed|velocity", "the speed"),
    (r"direction", "the direction of motion"),
    (r"acceleration", "the acceleration"),
    (r"effort|torque|force", "the effort"),
    (r"load", "the load"),
    (r"distance|range", "the distance"),
    (r"command", "the command"),
)


def part(component: str) -> str:
    """`motor2` -> 'motor 2', `range_x` -> 'the x sensor'; unknown names as they are."""
    if component in PARTS:
        return PARTS[component]
    if found := re.fullmatch(r"(motor|arm|joint)([123])", component):
        return f"{found[1]} {found[2]}"
    if found := re.fullmatch(r"range_([xyz])", component):
        return f"the {found[1]} sensor"
    return component.replace("_", " ") or "an unknown place"


def part_of(effect: str, component: str, follows: Sequence[str] = ()) -> str:
    """A component as the place of an effect: a range sensor alone is no axis.

    follows: what an unknown error follows; the distance only where there is nothing but a sensor.
    """
    alone = component == "axis" and (effect in _OF_A_SENSOR or "distance" in follows)
    return "the sensor" if alone else part(component)


def parts(components: Sequence[str]) -> str:
    """Several components: 'motors 1, 2 and 3', 'the x and y sensors'; all joints are all motors."""
    if {"joints", *_MOTORS} <= set(components):
        components = [name for name in components if name not in _MOTORS]
    if len(components) == 1:
        return part(components[0])
    stems = {re.sub(r"[123xyz]$", "", name) for name in components}
    lasts = listed([name[-1] for name in components])
    if stems in ({"motor"}, {"arm"}):
        return f"{stems.pop()}s {lasts}"
    return f"the {lasts} sensors" if stems == {"range_"} else listed([part(c) for c in components])


def effect(name: str, *components: str) -> str:
    """What is wrong and where, as a noun phrase: 'free play in the gear or coupling of motor 2'."""
    where = part_of(name, components[0]) if len(components) == 1 else parts(components)
    return _phrase(name, components, where)


def further(name: str, *components: str) -> str:
    """An effect on top of what the robot file has of it."""
    if name in FURTHER:
        where = part_of(name, components[0]) if len(components) == 1 else parts(components)
        return FURTHER[name].format(part=where)
    return BEYOND.format(phrase=effect(name, *components))


def of_effort(name: str, component: str) -> str:
    """An effect of an axis that is driven by effort, and of which no command was recorded."""
    if name in OF_EFFORT:
        return OF_EFFORT[name].format(part=part(component))
    return effect(name, component)


def unknown(component: str, follows: Sequence[str]) -> str:
    """An error without a name, by its place and by what it follows."""
    name = _phrase("unknown", [component], part_of("unknown", component, follows))
    return f"{name} that follows {listed([followed(one) for one in follows])}" if follows else name


def _phrase(name: str, components: Sequence[str], where: str) -> str:
    phrases = EFFECTS | OF_AN_AXIS if list(components) == ["axis"] else EFFECTS
    if len(components) > 1:
        phrases = EFFECTS | OF_SEVERAL
    if name in phrases:
        return phrases[name].format(part=where)
    return f"{name.replace('_', ' ')} at {where}"


def rival(finding: str, other: str, component: str) -> str:
    """An alternative to an effect, said as what it is when it looks like that effect."""
    if (finding, other) == ("effort_offset", "joint_friction"):
        return f"{effect(other, component)} that is stronger one way"
    if (finding, other) == ("gear_ratio", "unknown"):
        return f"a drift of {part(component)} with time"
    if (finding, other) == ("gear_ratio", "sensor_scale"):
        return f"a wrong scale of what measures {part(component)}"
    return effect(other, component)


def followed(covariate: str) -> str:
    """A quantity that a mismatch follows: 'theta_2' -> 'the angle of arm 2'."""
    name = bare(covariate)
    for pattern, text in _FOLLOWED:
        if found := re.fullmatch(pattern, name):
            return text.format(*found.groups())
    return name.replace("_", " ")


def spelled(text: str) -> str:
    """A sentence with effects and components as people write them: 'motor2' -> 'motor 2'."""
    text = _NAMED_EFFECT.sub(lambda found: effect(found[1], found[2]), text)
    text = re.sub(r"(?<=\bfollows )\w+|(?<=\bwith )\w+", _driver_in_text, text)
    text = re.sub(r"\b(motor|arm)([123])\b", r"\1 \2", text)
    return re.sub(r"\b(?:the )?range_([xyz])\b", r"the \1 sensor", text)


def _driver_in_text(found: re.Match[str]) -> str:
    word = found[0]
    return followed(word) if re.search(r"_[123xyz]$", word) or word == "time" else word


def channel(name: str) -> str:
    """An observation column: 'range_y' -> 'distance y', 'theta_1' -> 'measured angle 1'."""
    stem, _, which = name.partition("_")
    known = {"range": "distance", "pos": "position", "theta": "measured angle"}
    if stem in known and which:
        return f"{known[stem]} {which}"
    if name == "range":
        return "reported distance"
    return name.replace("_", " ")


def bare(covariate: str) -> str:
    """A covariate's name without its unit: 'theta_1 [rad]' -> 'theta_1'."""
    return re.sub(r"\s*[\[(][^\])]*[\])]\s*$", "", covariate).strip()


def listed(items: Sequence[str], word: str = "and") -> str:
    """'a', 'a and b', 'a, b and c'."""
    if len(items) < 2:
        return "".join(items)
    return f"{', '.join(items[:-1])} {word} {items[-1]}"


def sentence(text: str) -> str:
    """With a capital first and a full stop last."""
    text = text.strip()
    if not text:
        return ""
    text = text[0].upper() + text[1:]
    return text if text[-1] in ".!?" else f"{text}."
