"""The sentences of an answer's fields: of each finding, where it shows, and the remaining error."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any

from deltactl.diagnosis.answer.how_sure import late_in_all
from deltactl.diagnosis.answer.records import Diagnosis, Finding
from deltactl.diagnosis.answer.verdict import NAMELESS
from deltactl.diagnosis.report import pairs
from deltactl.diagnosis.report.fit import unexplained
from deltactl.diagnosis.report.names import all_followed, effect, followed, part_of
from deltactl.diagnosis.report.sizes import forced, of_larger_wave, quantity
from deltactl.diagnosis.report.templates import say
from deltactl.models.effects import VOCABULARY, Search, card_of, found_by
from deltactl.models.effects.kind import EffectKind
from deltactl.models.effects.lone_axis import command_effects, effort_effects, sensor_effects
from deltactl.models.robot import EffectEntry, RangeSensor, RobotModel, ServoAxis, StepperAxis


def kinds_of(robot: RobotModel, answer: Diagnosis) -> Mapping[str, EffectKind]:
    """The vocabulary of an answer."""
    if isinstance(robot, RangeSensor):
        return sensor_effects()
    if not isinstance(robot, ServoAxis | StepperAxis):
        return VOCABULARY
    motion = robot.motion if isinstance(robot, ServoAxis) else "rotary"
    return effort_effects(motion) if forced(answer.fit.unit) else command_effects(motion)


def in_words(
    answer: Diagnosis,
    kinds: Mapping[str, EffectKind] = VOCABULARY,
    known: Sequence[EffectEntry] = (),
) -> Diagnosis:
    """The same answer with a sentence for each finding and for the remaining error.

    kinds: the effects of the machine by name, which know their own sentences. known: effects that
    the robot file has already. What has a sentence keeps it.
    """
    findings = [
        finding if finding.says else _in_words(finding, answer, kinds, known)
        for finding in answer.findings
    ]
    rest = answer.unexplained
    answer = answer.model_copy(update={"findings": findings})
    rest = rest.model_copy(update={"says": rest.says or unexplained(answer)})
    return answer.model_copy(update={"unexplained": rest})


def _in_words(
    finding: Finding,
    answer: Diagnosis,
    kinds: Mapping[str, EffectKind],
    known: Sequence[EffectEntry],
) -> Finding:
    regime = finding.where.regime or _regime(finding, of_delta=kinds is VOCABULARY)
    where = finding.where.model_copy(update={"regime": regime})
    says = _sentence(finding, answer, kinds, known)
    finding = finding.model_copy(update={"says": says, "where": where})
    says = pairs.harmonic(finding, known) or says
    several = answer.picture is not None and len(answer.picture.shift_s) > 1
    if several and len(where.recordings) == 1:
        says = say("words.in_recording", says=says, number=where.recordings[0])
    return finding.model_copy(update={"says": says})


def _sentence(
    finding: Finding,
    answer: Diagnosis,
    kinds: Mapping[str, EffectKind],
    known: Sequence[EffectEntry],
) -> str:
    """A finding in one sentence, with its size."""
    where = part_of(finding.effect, finding.component, finding.depends_on)
    if finding.effect == NAMELESS:
        uneven = pairs.uneven(finding, answer.findings, known)
        return _unknown(finding, "uneven" if uneven else "unknown", where)
    if finding.effect == found_by(Search.REPEATS).name and finding.where.times_s:
        begin, end = finding.where.times_s[0]
        return say("words.repeats", part=where, begin=begin, end=end)
    if (late := late_in_all(finding)) is not None:
        return say("words.late", part=where, size=quantity(late.components[0][0], "s", digits=3))
    kind = kinds.get(finding.effect)
    if kind is None:
        return effect(finding.effect, finding.component)
    values: dict[str, Any] = {p.name: p.default for p in kind.parameters if p.default is not None}
    for name, size in of_larger_wave(finding.parameters).items():
        found = [value for value, _, _ in size.components]
        values[name] = found if isinstance(size.value, list) else found[0]
    return kind.sentence(where, values)


def _unknown(finding: Finding, case: str, where: str) -> str:
    which = all_followed([name for name in finding.depends_on if name not in finding.tied])
    if finding.tied:
        either = ", ".join(map(followed, finding.tied))
        which = say("words.or_tied", which=which, tied=either)
    size = finding.parameters["size_rms"]
    shown = quantity(size.components[0][0], size.unit, digits=3)
    return say(f"words.{case}", part=where, which=which, size=shown)


def _regime(finding: Finding, of_delta: bool) -> str:
    """Where a finding shows, by its card; of an axis, and of an unknown, with what it follows."""
    nameless = finding.effect == NAMELESS
    if finding.depends_on and (nameless or not of_delta):
        return say("words.with", name=followed(finding.depends_on[0]))
    words = card_of(finding.effect).words
    where = part_of(finding.effect, finding.component, finding.depends_on)
    return "" if nameless else (words.regime if of_delta else words.axis_regime).format(part=where)
