"""What is asked about a delta, an axis, and hardware, and the answers to it."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace

from deltactl.firmware_py.describing.question import (
    LEAST_PULSES,
    UNKNOWN,
    Notation,
    Question,
    of_both,
    of_ratio,
    pulses_remark,
    ratio_remark,
    read_numbers,
    too_few_pulses,
)
from deltactl.firmware_py.describing.question import Answers as Answers
from deltactl.foundation.errors import ConfigError
from deltactl.models.gearing import LEAST_RATIO, too_small_ratio

NAME = Question("name", "Name of the machine", "my-robot", any_text=True)
MICROSTEPS = Question(
    "microsteps_per_rev",
    "Step pulses for one turn of the motor, as set at the drive (200 full steps of 8 microsteps:"
    " 1600, or 200x8). With servo drives, or where recordings hold angles and no steps, 1600 will"
    " do",
    "1600",
    least=LEAST_PULSES,
    whole=True,
    too_small=too_few_pulses,
    # Whoever writes both does not mean the one by the other.
    notation=Notation(of_both, least=1.0),
    guessed=True,
)
GEAR = Question(
    "gear_ratio",
    "Turns of the motor for one turn of what it drives (5 for a gear of 5:1, 1 without a gear)",
    least=0.001,
    notation=Notation(of_ratio),
)


LEAST_MM, MOST_MM = 1.0, 9999.0


def _in_metres(size: float) -> str:
    if size <= 0.0:
        return ""
    return f"must not be below {LEAST_MM:g} mm; is it in metres? Then write {1e3 * size:g}"


GEAR_OF_ARM = replace(GEAR, least=LEAST_RATIO, too_small=too_small_ratio)
LENGTHS = tuple(
    Question(key, text, least=LEAST_MM, most=MOST_MM, too_small=_in_metres)
    for key, text in (
        ("base_radius_mm", "Base radius: from the middle to a motor axis, mm"),
        ("platform_radius_mm", "Platform radius: from its middle to a joint, mm"),
        ("upper_arm_mm", "Upper arm: from the motor axis to the elbow, mm"),
        ("forearm_mm", "Forearm: from the elbow to the platform's joint, mm"),
    )
)
DELTA: tuple[Question, ...] = (
    NAME,
    *LENGTHS,
    MICROSTEPS,
    GEAR_OF_ARM,
    Question(
        "sensors",
        "Distance sensors that see the platform: three along x, y and z (xyz), or none?",
        "xyz",
        ("xyz", "none"),
    ),
)
WIRING: tuple[Question, ...] = (
    Question("step_pins", "STEP pins of motors 1, 2, 3 (BCM numbers)", count=3),
    Question("direction_pins", "DIR pins of motors 1, 2, 3", count=3),
    Question("enable_pin", "ENA pin of the drives, or none"),
    Question("alarm_pins", "ALM pins of drives 1, 2, 3, or none", count=3),
    Question("estop_pin", "E-stop pin (normally closed to ground), or none"),
    Question("xshut_pins", "XSHUT pins of sensors x, y, z", count=3, unless=(("sensors", "none"),)),
    Question("arm_deg", "Lowest and highest arm angle, degrees (0 level, positive down)", count=2),
    Question("step_rate_hz", "Most steps a second of a motor (a Pi sends up to 20000)"),
    Question("joint_speed_radps", "Fastest an arm may turn, rad/s"),
    Question("joint_acceleration_radps2", "Fastest it may gain speed, rad/s2"),
    Question("approach_speed_radps", "How fast it goes to where a job begins, rad/s (say 0.5)"),
    Question(
        "home_deg",
        "Angles of arms 1, 2, 3 at the stops or jig where they are put, degrees",
        count=3,
    ),
)
"""What hardware needs besides, and nobody can guess; a file without it runs simulated only."""


ZERO = Question(
    "zero",
    "Should the reading be 0 where the command is 0? absolute: yes (commanded to 30, it should"
    " read 30; also where one was set equal to the other once, at the start or at home); arbitrary:"
    " no (an encoder that begins anywhere, and reads 217 there)",
    "absolute",
    ("absolute", "arbitrary"),
    unless=(("recorded", "effort"),),
)
TURNS = ("motion", "rotary", "a servo_axis that turns")
SLIDES = ("motion", "linear", "a servo_axis that slides")
NO_EFFORT = (("recorded", "command"),)
INERTIA = Question(
    "inertia",
    "Moving inertia, kg m2 (rotary) or kg (linear); 0 if unknown or no effort is recorded",
    "0",
    least=0.0,
    unless=NO_EFFORT,
)
EFFORT_GAIN = Question(
    "effort_gain",
    "N m (or N) for one unit of the effort column: 1 if it is in N m or N, of a current the motor"
    " constant times the gear; unknown: if you do not know",
    UNKNOWN,
    unknown=True,
    unless=NO_EFFORT,
)
STEPPER_AXIS: tuple[Question, ...] = (NAME, MICROSTEPS, GEAR, ZERO)
SERVO_AXIS: tuple[Question, ...] = (
    NAME,
    Question("motion", "Does it turn (rotary) or slide (linear)?", "rotary", ("rotary", "linear")),
    Question(
        "recorded",
        "What is recorded beside the position: its command, the effort (force, torque,"
        " current), or both?",
        "command",
        ("command", "effort", "both"),
    ),
    INERTIA,
    EFFORT_GAIN,
    Question(
        "hanging_nm",
        "Torque that holds a weight on the axis level, N m (kg * 9.81 * metres from the axis);"
        " 0: none hangs there, or the axis is upright; unknown: if you do not know",
        UNKNOWN,
        unknown=True,
        unless=(("motion", "linear"),),
        only=TURNS,
    ),
    Question(
        "hanging_deg",
        "Position at which that weight hangs straight down, degrees",
        "0",
        unless=(("motion", "linear"), ("hanging_nm", "0"), ("hanging_nm", UNKNOWN)),
        only=TURNS,
    ),
    Question(
        "constant_nm",
        "Torque that holds a load of one size at every angle, N m (a weight on a rope over a drum:"
        " kg * 9.81 * its radius), negative if it holds towards lower positions; 0: there is none;"
        " unknown: if you do not know",
        "0",
        unknown=True,
        unless=(*NO_EFFORT, ("motion", "linear")),
        only=TURNS,
    ),
    Question(
        "slope_n",
        "Force that holds the slide on its slope, N (kg * 9.81 * sine of the slope), negative"
        " if it holds towards lower positions; 0: it is level, or balanced; unknown: if you do not"
        " know",
        UNKNOWN,
        unknown=True,
        unless=(*NO_EFFORT, ("motion", "rotary")),
        only=SLIDES,
    ),
    ZERO,
)


QUESTIONS: dict[str, tuple[Question, ...]] = {
    "delta": DELTA,
    "stepper_axis": STEPPER_AXIS,
    "servo_axis": SERVO_AXIS,
    "range_sensor": (NAME,),
}
_NOTATIONS = {one.key: one.notation for asked in QUESTIONS.values() for one in asked}
"""By the key of the question."""


def gather(
    questions: tuple[Question, ...], given: Answers, ask: Callable[[Question], str] | None
) -> Answers:
    """An answer to each question: as given, as asked for, or its default.

    Raises ConfigError naming all that cannot be taken, or is missing where nobody can be asked.
    """
    answers, missing, wrong = Answers(), list[str](), list[str]()
    guessed: list[str] = []
    for question in questions:
        if question.key in given:
            answers[question.key] = given[question.key]
            if why := question.wrong(given[question.key]):
                wrong.append(f"{question.option} {why}")
            if why := question.misplaced(answers):
                wrong.append(why)
        elif _settled(question, answers):
            if question.default is not None:
                answers[question.key] = question.default
        elif ask is not None:
            answers[question.key] = ask(question)
        elif question.default is not None:
            answers[question.key] = question.default
            if question.guessed:
                why = f"without it {question.default} would be assumed"
                guessed.append(f"{question.option} is missing ({why}): {question.text}")
        else:
            missing.append(f"{question.option} is missing: {question.text}")
    if missing or wrong:  # all of them at once, and what else should be said
        raise ConfigError(*wrong, *missing, *(guessed if missing else ()))
    return answers


def _settled(question: Question, answers: Answers) -> bool:
    """Whether another answer leaves nothing to ask."""
    return any(answers.get(key) == answer for key, answer in question.unless)


def remarks(questions: tuple[Question, ...], given: Answers, answers: Answers) -> list[str]:
    """What was taken without anybody having said it, and what is seldom meant."""
    taken = [
        one
        for one in questions
        if one.key not in given
        and one.default == answers.get(one.key)
        and not _settled(one, answers)
    ]
    said = []
    if names := ", ".join(f"{one.option} {one.default}" for one in taken):
        said.append(f"assumed:         {names}")
    if MICROSTEPS in questions:
        said += ratio_remark(answers[GEAR.key])
        said += pulses_remark(answers[MICROSTEPS.key], numbers(answers, MICROSTEPS.key)[0])
    return said


def numbers(answers: Answers, key: str, count: int = 1) -> tuple[float, ...]:
    """The numbers of an answer, with spaces or commas between. Raises ConfigError."""
    found = read_numbers(answers[key], count, _NOTATIONS.get(key))
    if isinstance(found, str):
        raise ConfigError(f"--{key.replace('_', '-')} {answers[key]!r}: {found}")
    return found
