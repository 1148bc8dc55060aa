"""What is asked about a machine of each kind, and how answers are gathered."""

from __future__ import annotations

from collections.abc import Callable

from deltactl.firmware_py.describing.asked_of_a_delta import DELTA
from deltactl.firmware_py.describing.asked_of_a_delta import WIRING as WIRING
from deltactl.firmware_py.describing.asked_of_all import GEAR, NAME
from deltactl.firmware_py.describing.asked_of_all import MICROSTEPS as MICROSTEPS
from deltactl.firmware_py.describing.asked_of_an_axis import SERVO_AXIS, STEPPER_AXIS
from deltactl.firmware_py.describing.motors import pulses_remark, ratio_remark
from deltactl.firmware_py.describing.question import UNKNOWN as UNKNOWN
from deltactl.firmware_py.describing.question import Answers as Answers
from deltactl.firmware_py.describing.question import Question as Question
from deltactl.firmware_py.describing.question import read_numbers
from deltactl.foundation.errors import ConfigError

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
