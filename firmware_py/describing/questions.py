"""What is asked about a machine of each kind: a table, with what a good answer looks like."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

from foundation.errors import ConfigError


@dataclass(frozen=True, slots=True)
class Question:
    """One thing to know. `key` is also the option, `--upper-arm-mm`; unit is said in its name."""

    key: str
    text: str
    default: str | None = None
    """What Enter means; None where there is no safe guess."""
    choices: tuple[str, ...] = ()

    def wrong(self, answer: str) -> str:
        """Why an answer cannot be taken, to be asked again at once; empty where it may do."""
        if self.choices and answer not in self.choices:
            return f"{answer!r}: must be {' or '.join(self.choices)}"
        if self.choices or self.key == "name" or answer.strip() == "none":
            return ""
        try:
            [float(part) for part in answer.replace(",", " ").split()]
        except ValueError:
            return f"{answer!r}: must be numbers"
        return ""

    @property
    def option(self) -> str:
        """As it is typed on the command line."""
        return "--" + self.key.replace("_", "-")


NAME = Question("name", "Name of the machine", "my-robot")
MICROSTEPS = Question("microsteps_per_rev", "Microsteps for one turn of the motor", "1600")
GEAR = Question("gear_ratio", "Turns of the motor for one turn of the arm (1 without a gear)")
ZERO = Question(
    "zero", "Is the zero of the readings that of the commands (absolute), or not (arbitrary)?",
    "absolute", ("absolute", "arbitrary"),
)  # fmt: skip
QUESTIONS: dict[str, tuple[Question, ...]] = {
    "delta": (
        NAME,
        Question("base_radius_mm", "Base radius: from the middle to a motor axis, mm"),
        Question("platform_radius_mm", "Platform radius: from its middle to a joint, mm"),
        Question("upper_arm_mm", "Upper arm: from the motor axis to the elbow, mm"),
        Question("forearm_mm", "Forearm: from the elbow to the platform's joint, mm"),
        MICROSTEPS,
        GEAR,
    ),
    "stepper_axis": (NAME, MICROSTEPS, GEAR, ZERO),
    "servo_axis": (
        NAME,
        Question(
            "motion", "Does it turn (rotary) or slide (linear)?", "rotary", ("rotary", "linear")
        ),
        Question("inertia", "Moving inertia, kg m2 (rotary) or kg (linear); 0 if unknown", "0"),
        Question("effort_gain", "N m (or N) for one unit of the effort column", "1"),
        ZERO,
    ),
    "range_sensor": (NAME,),
}
WIRING: tuple[Question, ...] = (
    Question("step_pins", "STEP pins of motors 1, 2, 3 (BCM numbers)"),
    Question("direction_pins", "DIR pins of motors 1, 2, 3"),
    Question("enable_pin", "ENA pin of the drives, or none"),
    Question("alarm_pins", "ALM pins of drives 1, 2, 3, or none"),
    Question("estop_pin", "E-stop pin (normally closed to ground), or none"),
    Question("xshut_pins", "XSHUT pins of sensors x, y, z"),
    Question("arm_deg", "Lowest and highest arm angle, degrees (0 level, positive down)"),
    Question("step_rate_hz", "Most steps a second of a motor (a Pi sends up to 20000)"),
    Question("joint_speed_radps", "Fastest an arm may turn, rad/s"),
    Question("joint_acceleration_radps2", "Fastest it may gain speed, rad/s2"),
    Question("approach_speed_radps", "How fast it goes to where a job begins, rad/s (say 0.5)"),
    Question("home_deg", "Angles of arms 1, 2, 3 at the stops or jig where they are put, degrees"),
)
"""What hardware needs besides, and nobody can guess; a file without it runs simulated only."""
Answers = dict[str, str]


def gather(
    questions: tuple[Question, ...], given: Answers, ask: Callable[[Question], str] | None
) -> Answers:
    """An answer to each question: as given, as asked for, or its default.

    Raises ConfigError naming all that is missing where nobody can be asked.
    """
    answers, missing = Answers(), []
    for question in questions:
        if question.key in given:
            answers[question.key] = given[question.key]
        elif ask is not None:
            answers[question.key] = ask(question)
        elif question.default is not None:
            answers[question.key] = question.default
        else:
            missing.append(question)
    if missing:
        raise ConfigError(
            *(f"{one.option} is missing: {one.text}" for one in missing)
        )  # all of them at once
    return answers


def numbers(answers: Answers, key: str, count: int = 1) -> tuple[float, ...]:
    """The numbers of an answer, with spaces or commas between. Raises ConfigError."""
    text = answers[key]
    option = "--" + key.replace("_", "-")
    try:
        found = tuple(float(part) for part in text.replace(",", " ").split())
    except ValueError:
        raise ConfigError(f"{option} {text!r}: must be numbers") from None
    if len(found) != count:
        raise ConfigError(f"{option} {text!r}: must be {count} number(s), with spaces between")
    return found
