"""An answer put into words: every sentence of it is made here, from its fields.

The summary has plain sentences, the most important first, for the page and the JSON.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from typing import Any

from deltactl.diagnosis.answer.how_sure import is_about, late_in_all_s, settled, tied
from deltactl.diagnosis.answer.records import Diagnosis, Finding, Picture, Thinned
from deltactl.diagnosis.answer.shape_of_a_finding import period_takes_s
from deltactl.diagnosis.answer.verdict import NAMELESS
from deltactl.diagnosis.answer.what_is_left import apart
from deltactl.diagnosis.plants.lone.options import COMMANDED_AXIS
from deltactl.diagnosis.report import pairs
from deltactl.diagnosis.report.finding import by_priors, finding_lines, finding_title, span_s
from deltactl.diagnosis.report.fit import fit_lines, fit_title, unexplained, unexplained_line
from deltactl.diagnosis.report.headline import opening
from deltactl.diagnosis.report.limits import (
    allowed_line,
    faintest_line,
    in_file,
    of_the_file,
    untested_lines,
)
from deltactl.diagnosis.report.names import (
    all_followed,
    effect,
    followed,
    part,
    percent,
    upper,
)
from deltactl.diagnosis.report.next_run import experiment_line, hint, telling_apart, tie_lines
from deltactl.diagnosis.report.remedies import remedies
from deltactl.diagnosis.report.sizes import forced, quantity
from deltactl.diagnosis.report.templates import TERMINAL, Ways, say
from deltactl.models.effects import VOCABULARY, Search, card_of, found_by
from deltactl.models.effects.kind import EffectKind
from deltactl.models.effects.lone_axis import command_effects, effort_effects, said, sensor_effects
from deltactl.models.robot import EffectEntry, RangeSensor, RobotModel, ServoAxis, StepperAxis

A_MINUTE_S = 60.0
"""Times from here on are given in minutes."""


def plain_lines(
    diagnosis: Diagnosis, robot: RobotModel | None = None, ways: Ways = TERMINAL
) -> list[str]:
    """The summary as plain lines. robot: whose lengths what is to be done is said in."""
    return [line for _, line in _summary(diagnosis, robot, ways)]


def head_lines(diagnosis: Diagnosis) -> list[str]:
    """Those of them that are titles."""
    return [line for is_head, line in _summary(diagnosis, None, TERMINAL) if is_head]


def at_once(lines: Sequence[str]) -> int:
    """How many of the plain lines say what is the matter and what to do; reasons follow."""
    why = say("summary.why")
    return lines.index(why) if why in lines else len(lines)


def _summary(
    diagnosis: Diagnosis, robot: RobotModel | None, ways: Ways
) -> Iterator[tuple[bool, str]]:
    """Whether it is a title, and each line."""
    first, *others = opening(diagnosis)
    yield True, first
    yield from ((False, line) for line in others)
    if do := remedies(diagnosis, robot, ways):
        yield True, say("summary.do_this")
        yield from ((False, f"- {line}") for line in do)
        yield True, say("summary.why")
    yield from ((False, line) for line in of_the_file(diagnosis))
    for number, finding in enumerate(diagnosis.findings, 1):
        yield True, f"{number}. {finding_title(finding)}"
        known = in_file(robot, finding.effect, finding.component)
        lines = [ways.on_top] if known else []
        lines += finding_lines(finding, diagnosis, span_s(diagnosis))
        if diagnosis.next_experiment is None and not diagnosis.open_ties and tied(finding):
            lines += filter(None, [hint(finding, ways, diagnosis.pull_said)])
        yield from ((False, f"   {line}") for line in lines)
    yield from ((False, line) for line in remarks(diagnosis, ways))
    yield True, fit_title(diagnosis)
    left, faint = unexplained_line(diagnosis), faintest_line(diagnosis, robot)
    more = [*fit_lines(diagnosis), left, *untested_lines(diagnosis), faint]
    yield from ((False, line) for line in more if line)
    if following := experiment_line(diagnosis):
        yield True, say("summary.next")
        yield False, following


def remarks(diagnosis: Diagnosis, ways: Ways = TERMINAL) -> list[str]:
    """Remarks on the machine and the search as a whole, in addition to the findings."""
    lines = [
        allowed_line(diagnosis),
        *search_lines(diagnosis, ways),
        *(
            by_priors(one)
            for one in diagnosis.prior_sensitivity
            if not any(is_about(one, finding) for finding in diagnosis.findings)
        ),
        *tie_lines(diagnosis),
    ]
    return [line for line in lines if line]


def search_lines(diagnosis: Diagnosis, ways: Ways = TERMINAL) -> list[str]:
    """What was not compared, and what of the recordings was not used."""
    early = [say("summary.ended_early", way=ways.all_compared)] if diagnosis.ended_early else []
    return [
        *early,
        *map(left_out_line, diagnosis.left_out),
        *map(_thinned_line, diagnosis.thinned),
        *(say("summary.not_read", why=why) for why in diagnosis.not_read),
    ]


def left_out_line(why: str) -> str:
    """That a recording of several was not used."""
    return say("summary.left_out", why=why)


def _thinned_line(thinned: Thinned) -> str:
    """That only stretches of a recording were used, and what follows from it."""
    return say("summary.thinned", hours=thinned.span_s / 3600, **thinned.model_dump())


def told(answer: Diagnosis, kinds: Mapping[str, EffectKind] = VOCABULARY) -> Diagnosis:
    """The same answer with its sentences: of each finding, of what is left, and as a whole.

    kinds: the effects of the machine by name, which know their own sentences. What has a sentence
    already keeps it.
    """
    several = answer.picture is not None and len(answer.picture.shift_s) > 1
    findings = [_told(finding, kinds, several) for finding in answer.findings]
    rest = answer.unexplained
    rest = rest.model_copy(update={"says": rest.says or unexplained(answer)})
    answer = answer.model_copy(update={"findings": findings, "unexplained": rest})
    return answer.model_copy(update={"says": answer.says or plain_lines(answer)})


def _told(finding: Finding, kinds: Mapping[str, EffectKind], several: bool) -> Finding:
    says, where = finding.says or _sentence(finding, kinds), finding.where
    if several and len(where.recordings) == 1 and not finding.says:
        says = say("told.in_recording", says=says, number=where.recordings[0])
    where = where.model_copy(update={"regime": where.regime or _regime(finding)})
    return finding.model_copy(update={"says": says, "where": where})


def _sentence(finding: Finding, kinds: Mapping[str, EffectKind]) -> str:
    """A finding in one sentence, with its size."""
    where, late_s = part(finding.component), late_in_all_s(finding)
    if finding.effect == NAMELESS:
        return _unknown(finding, where)
    if finding.effect == found_by(Search.REPEATS).name:
        begin, end = finding.where.times_s[0]
        return say("told.repeats", part=where, begin=begin, end=end)
    if late_s is not None:
        return say("told.late", part=where, size=quantity(late_s, "s", digits=3))
    kind = kinds.get(finding.effect)
    if kind is None:
        return effect(finding.effect, finding.component)
    values: dict[str, Any] = {p.name: p.default for p in kind.parameters if p.default is not None}
    for name, size in finding.parameters.items():
        found = [value for value, _, _ in size.components]
        values[name] = found if isinstance(size.value, list) else found[0]
    return kind.sentence(where, values)


def _unknown(finding: Finding, where: str) -> str:
    which = all_followed([name for name in finding.depends_on if name not in finding.tied])
    if finding.tied:
        either = ", ".join(map(followed, finding.tied))
        which = say("told.or_tied", which=which, tied=either)
    size = finding.parameters["size_rms"]
    ((value, _, _),) = size.components
    return say("told.unknown", part=where, which=which, size=quantity(value, size.unit, digits=3))


def _regime(finding: Finding) -> str:
    """Where a finding shows."""
    if finding.effect == NAMELESS:
        return say("told.with", name=followed(finding.depends_on[0])) if finding.depends_on else ""
    return card_of(finding.effect).words.regime.format(part=part(finding.component))


def spoken(
    answer: Diagnosis,
    kinds: Mapping[str, EffectKind],
    left_out: Sequence[str] = (),
    known: Sequence[EffectEntry] = (),
) -> Diagnosis:
    """The answer of a single axis or sensor with its sentences.

    left_out: held-out recordings that tell nothing, and why. known: effects that the robot file has
    already.
    """
    findings = [_spoken(one, kinds, answer, known) for one in answer.findings]
    answer = answer.model_copy(update={"findings": findings})
    lines = [*_lone_summary(answer), *(say("fit.held_out_left_out", why=why) for why in left_out)]
    return answer.model_copy(update={"says": lines, "not_held_out": list(left_out)})


def kinds_of(
    robot: StepperAxis | ServoAxis | RangeSensor, answer: Diagnosis
) -> dict[str, EffectKind]:
    """The vocabulary of an answer."""
    if isinstance(robot, RangeSensor):
        return sensor_effects()
    motion = robot.motion if isinstance(robot, ServoAxis) else "rotary"
    return effort_effects(motion) if forced(answer.fit.unit) else command_effects(motion)


def _spoken(
    finding: Finding,
    kinds: Mapping[str, EffectKind],
    answer: Diagnosis,
    known: Sequence[EffectEntry],
) -> Finding:
    regime = card_of(finding.effect).words.axis_regime
    if finding.depends_on and finding.depends_on[0]:
        regime = say("told.with", name=finding.depends_on[0])
    regime += _in_time(finding, answer.picture)
    where = finding.where.model_copy(update={"regime": regime})
    says = _lone_sentence(finding, kinds, answer, known)
    finding = finding.model_copy(update={"says": says, "where": where})
    same_part = pairs.harmonic(finding, known)
    return finding.model_copy(update={"says": same_part}) if same_part else finding


def _in_time(finding: Finding, picture: Picture | None) -> str:
    """How long a period takes, where the axis goes at one speed."""
    took_s = period_takes_s(finding, picture, COMMANDED_AXIS.steady_correlation)
    if took_s is None:
        return ""
    shown = quantity(took_s, "s", digits=3) if took_s < A_MINUTE_S else f"{took_s / 60.0:.1f} min"
    return say("lone.period_takes", time=shown)


def _lone_sentence(
    finding: Finding,
    kinds: Mapping[str, EffectKind],
    answer: Diagnosis,
    known: Sequence[EffectEntry],
) -> str:
    if finding.effect == NAMELESS:
        sizes = finding.parameters.get("size_rms")
        size = f" of {said(sizes.components[0][0], answer.fit.unit)}" if sizes else ""
        uneven = pairs.uneven(finding, answer.findings, known)
        follows = all_followed(finding.depends_on)
        return say("lone.uneven" if uneven else "lone.unknown", size=size, follows=follows)
    if (late_s := late_in_all_s(finding)) is not None:
        return say("lone.late", size=quantity(late_s, "s", digits=3))
    values = {name: size.components[0][0] for name, size in finding.parameters.items()}
    return kinds[finding.effect].sentence(finding.component, values)


def _lone_summary(answer: Diagnosis) -> list[str]:
    """Most important first."""
    fit, rest, lines = answer.fit, answer.unexplained, []
    if answer.verdict == "nothing_missing":
        lines.append(say("lone.nothing", p=answer.false_alarm_p))
    elif not answer.findings:
        lines.append(say("lone.no_effect", rest=rest.says))
    else:
        for number, one in enumerate(answer.findings, start=1):
            sure = None if one.probability is None else percent(one.probability)
            case = "lone.finding" if sure is None else "lone.finding_sure"
            lines.append(say(case, number=number, says=upper(one.says), sure=sure))
        open_ones = [one for one in answer.findings if one.alternatives and not settled(one)]
        lines += [*map(_cannot_tell, open_ones), *telling_apart(open_ones, answer.pull_said)]
    sizes = {
        "before": fit.rms_before_m,
        "after": fit.rms_after_m,
        "floor": fit.noise_floor_m,
        "held_before": fit.holdout_rms_before_m,
        "held_after": fit.holdout_rms_after_m,
    }
    shown = {name: said(size, fit.unit) for name, size in sizes.items()}
    held = say("lone.on_run" if fit.holdout == "run" else "lone.on_blocks")
    lines += [*_agreement(answer), *map(by_priors, answer.prior_sensitivity)]
    lines.append(say("lone.figures", held=held, **shown))
    return [*lines, rest.says] if answer.findings and rest.depends_on else lines


def _agreement(answer: Diagnosis) -> list[str]:
    """Whether several recordings say the same."""
    disagree = apart(answer)
    if answer.agreement and not disagree:
        return [say("lone.agree", p=min(one.p for one in answer.agreement))]
    return [
        say(
            "lone.disagree",
            parameter=one.parameter,
            effect=one.effect,
            sizes=", ".join(said(size.components[0][0], size.unit) for size in one.sizes),
            p=one.p,
        )
        for one in disagree
    ]


def _cannot_tell(finding: Finding) -> str:
    others = dict.fromkeys(_as_named(finding.effect, one.effect) for one in finding.alternatives)
    return say("lone.cannot_tell", effect=finding.effect, others=", ".join(others))


def _as_named(finding: str, other: str) -> str:
    """The name of an alternative, with what makes it look like the finding."""
    known = card_of(finding).confusion(other)
    own = known.called if known is not None else ""
    return own.format(phrase=other) if "{phrase}" in own else other
