"""What an answer rests on: the robot file, small errors allowed for, and what could not be seen."""

from __future__ import annotations

import math
from collections.abc import Sequence

from deltactl.diagnosis.answer.how_sure import unsure
from deltactl.diagnosis.answer.options import SAYING
from deltactl.diagnosis.answer.records import AllowedFor, Diagnosis, Known, SmallestDetectable
from deltactl.diagnosis.answer.what_is_left import surely_nothing
from deltactl.diagnosis.report.finding import in_brackets
from deltactl.diagnosis.report.names import by_noise, effect, further, listed, percent, sentence
from deltactl.diagnosis.report.sizes import quantity, scale_of, unsigned
from deltactl.diagnosis.report.templates import say
from deltactl.models.robot import RobotModel


def of_the_file(diagnosis: Diagnosis, brief: bool = False) -> list[str]:
    """How surely the robot file is complete, what is taken as known from it, and allowed for."""
    lines = (alarm_line(diagnosis, brief), known_line(diagnosis), allowed_line(diagnosis))
    return [line for line in lines if line]


def alarm_line(diagnosis: Diagnosis, brief: bool = False) -> str:
    """How surely the robot file is incomplete; empty where the headline or a table says it."""
    p, nothing = diagnosis.false_alarm_p, diagnosis.probability_nothing_missing
    if math.isnan(p):
        return say("alarm.not_computed")
    if not diagnosis.findings:
        return "" if surely_nothing(diagnosis) else say("alarm.more_data")
    if brief and nothing is not None and max(nothing, 1e6 * p) < 1.0 - SAYING.settled_p:
        return ""
    sure = "" if nothing is None else say("alarm.sure", sure=percent(1.0 - nothing))
    return sentence(say("alarm.incomplete", sure=sure, p=by_noise(p)))


def known_line(diagnosis: Diagnosis) -> str:
    """What was found before, how sure it was, and whether in the same recordings; else empty."""
    notes: dict[tuple[str, str], list[str]] = {}
    for one in diagnosis.known:
        notes.setdefault((one.effect, _notes(one)), []).append(one.component)
    names = [f"{effect(name, *places)}{note}" for (name, note), places in notes.items()]
    return say("known.taken", names=listed(names)) if names else ""


def _notes(one: Known) -> str:
    """How sure it was, where it was not certain, and whether the recording is the same."""
    sure = say("known.sure", sure=percent(one.probability or 0.0))
    here = say("known.here")
    facts = [(sure, unsure(one.probability)), (here, one.from_these_recordings)]
    return in_brackets([fact for fact, holds in facts if holds])


def allowed_line(diagnosis: Diagnosis) -> str:
    """What was allowed for, with the sizes that the recording shows; empty where nothing was."""
    if not diagnosis.loosely_built:
        return ""
    sizes = say("allowed.sizes", sizes=listed([_allowed(one) for one in diagnosis.allowed_for]))
    return say("allowed.line", sizes=sizes if diagnosis.allowed_for else "")


def _allowed(one: AllowedFor) -> str:
    """'a wrong home angle of motor 2 (+0.44 degrees, usually up to 0.23 degrees)'."""
    (name, result), *_ = one.parameters.items()
    sizes = [quantity(value, result.unit, name) for value, _, _ in result.components]
    usual = unsigned(scale_of(result.unit, name).zero + one.usual, result.unit, name)
    what = effect(one.effect, one.component)
    return say("allowed.each", what=what, size=", ".join(sizes), usual=usual)


def limit_name(name: str, components: Sequence[str], robot: RobotModel | None) -> str:
    """What has a detection limit; on top of what the robot file has of it."""
    more = all(in_file(robot, name, one) for one in components)
    return further(name, *components) if more else effect(name, *components)


def limit_size(one: SmallestDetectable) -> str:
    """A detection limit as a size; what yields is seen from this softness on."""
    size = limit_alone(one)
    return say("page.softer", size=size) if one.parameter == "stiffness" else size


def limit_alone(one: SmallestDetectable) -> str:
    """The number and unit of a detection limit."""
    zero = scale_of(one.unit, one.parameter).zero
    return quantity(zero + above_nothing(one), one.unit, one.parameter).lstrip("+-")


def in_file(robot: RobotModel | None, name: str, component: str) -> bool:
    """Whether the robot file has this effect already."""
    known = robot.effects if robot is not None else ()
    return any((one.effect, one.component) == (name, component) for one in known)


def above_nothing(one: SmallestDetectable) -> float:
    """How far a detection limit is from nothing; that of a scale may be 1.003 or 0.003."""
    zero = scale_of(one.unit, one.parameter).zero
    return abs(one.value - zero if one.value > 0.5 * zero else one.value)
