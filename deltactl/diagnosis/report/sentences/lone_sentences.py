"""All prose of a lone machine's answer, made from its fields."""

from __future__ import annotations

from collections.abc import Mapping, Sequence

import numpy as np

from deltactl.diagnosis.answer.records import Diagnosis, Finding, Picture
from deltactl.diagnosis.plants.lone.options import COMMANDED_AXIS
from deltactl.diagnosis.report.phrases import sureness, words
from deltactl.diagnosis.report.phrases.percent import percent
from deltactl.diagnosis.report.phrases.sizes import quantity
from deltactl.diagnosis.report.sentences.telling_apart import beside_friction, telling_apart
from deltactl.models.effects import card_of
from deltactl.models.effects.kind import EffectKind
from deltactl.models.effects.lone_axis import command_effects, effort_effects, said, sensor_effects
from deltactl.models.robot import EffectEntry, RangeSensor, ServoAxis, StepperAxis

HARMONICS = {1: "what is left", 2: "the second harmonic", 3: "the third harmonic",
             4: "the fourth harmonic"}  # fmt: skip
SAME_PERIOD = 0.03
"""How far a period may be from a whole fraction of another: what intervals of both amount to."""
A_MINUTE_S = 60.0
"""Times from here on are given in minutes."""
DISAGREES = 0.01
"""Chance below which recordings are said to disagree."""


def spoken(
    answer: Diagnosis,
    kinds: Mapping[str, EffectKind],
    left_out: Sequence[str] = (),
    known: Sequence[EffectEntry] = (),
) -> Diagnosis:
    """The answer with its sentences; left_out: held-out recordings that tell nothing, and why.

    known: effects that the robot file has already.
    """
    findings = [_harmonic(_spoken(one, kinds, answer, known), known) for one in answer.findings]
    answer = answer.model_copy(update={"findings": findings})
    lines = [*_summary(answer), *(f"Held-out data left out: {why}." for why in left_out)]
    return answer.model_copy(update={"says": lines, "not_held_out": list(left_out)})


def kinds_of(
    robot: StepperAxis | ServoAxis | RangeSensor, answer: Diagnosis
) -> dict[str, EffectKind]:
    """The vocabulary an answer is told in."""
    if isinstance(robot, RangeSensor):
        return sensor_effects()
    motion = robot.motion if isinstance(robot, ServoAxis) else "rotary"
    forced = answer.fit.unit in ("N", "N m")
    return effort_effects(motion) if forced else command_effects(motion)


def _spoken(
    finding: Finding,
    kinds: Mapping[str, EffectKind],
    answer: Diagnosis,
    known: Sequence[EffectEntry],
) -> Finding:
    follows = finding.depends_on[0] if finding.depends_on else ""
    regime = f"with {follows}" if follows else card_of(finding.effect).words.axis_regime
    where = finding.where.model_copy(update={"regime": regime + _in_time(finding, answer.picture)})
    says = _says(finding, kinds, answer, known)
    return finding.model_copy(update={"says": says, "where": where})


def _harmonic(finding: Finding, known: Sequence[EffectEntry]) -> Finding:
    """Of a periodic error by a whole fraction of a known one's period: that it is the same part."""
    period = finding.parameters.get("period")
    if period is None:
        return finding
    at = abs(period.components[0][0])
    for one in known:
        fundamental = one.parameters.get("period")
        if one.effect != finding.effect or not isinstance(fundamental, float):
            continue
        times = round(abs(fundamental) / at)
        if times in HARMONICS and abs(abs(fundamental) / at / times - 1.0) < SAME_PERIOD:
            says = (
                f"{finding.says}; this is {HARMONICS[times]} of the error with a period of "
                f"{said(abs(fundamental), period.unit)} that the robot file knows, and probably of "
                "the same part"
            )
            return finding.model_copy(update={"says": says})
    return finding


def _in_time(finding: Finding, picture: Picture | None) -> str:
    """How long a period takes, where the axis goes at one speed."""
    period = finding.parameters.get("period")
    if period is None or picture is None or "position" not in picture.covariates:
        return ""
    position, t_s = picture.covariates["position"], picture.t_s
    if abs(float(np.corrcoef(position, t_s)[0, 1])) < COMMANDED_AXIS.steady_correlation:
        return ""
    took_s = abs(period.components[0][0] / float(np.polyfit(t_s, position, 1)[0]))
    shown = quantity(took_s, "s", digits=3) if took_s < A_MINUTE_S else f"{took_s / 60.0:.1f} min"
    return f" (a period takes {shown} at the speed of this recording)"


def _says(
    finding: Finding,
    kinds: Mapping[str, EffectKind],
    answer: Diagnosis,
    known: Sequence[EffectEntry],
) -> str:
    unit = answer.fit.unit
    if finding.effect == "unknown":
        sizes = finding.parameters.get("size_rms")
        size = f" of {said(sizes.components[0][0], unit)}" if sizes else ""
        if beside_friction(finding, answer.findings, known):
            return (
                "friction or play of the axis is not the same all along its travel: taken as the"
                f" same, it leaves a mismatch{size}"
            )
        follows = words.listed([words.followed(one) for one in finding.depends_on])
        return f"a mismatch{size} follows {follows}, as no known effect does"
    if (late_s := sureness.late_in_all_s(finding)) is not None:
        return f"the axis follows late, by {quantity(late_s, 's', digits=3)} in all"
    values = {name: size.components[0][0] for name, size in finding.parameters.items()}
    return kinds[finding.effect].sentence(finding.component, values)


def _summary(answer: Diagnosis) -> list[str]:
    """Most important first."""
    fit, rest = answer.fit, answer.unexplained
    if answer.verdict == "nothing_missing":
        lines = [f"Nothing is missing in the model (p = {answer.false_alarm_p:.2g})."]
    elif not answer.findings:
        lines = [f"No effect could be named. {rest.says}"]
    else:
        lines = [
            f"{number}. {_upper(one.says)}{_how_sure(one)}."
            for number, one in enumerate(answer.findings, start=1)
        ]
        tied = [one for one in answer.findings if one.alternatives and not sureness.settled(one)]
        lines += [*map(_cannot_tell, tied), *telling_apart(tied, answer.pull_said)]
    lines += [*_agreement(answer), *map(sureness.by_priors, answer.prior_sensitivity)]
    lines.append(
        f"Mismatch {said(fit.rms_before_m, fit.unit)} before, {said(fit.rms_after_m, fit.unit)} "
        f"after, noise floor {said(fit.noise_floor_m, fit.unit)}; {_held_out(answer)} "
        f"{said(fit.holdout_rms_before_m, fit.unit)} before and "
        f"{said(fit.holdout_rms_after_m, fit.unit)} after."
    )
    if answer.findings and rest.depends_on:
        lines.append(rest.says)
    return lines


def _agreement(answer: Diagnosis) -> list[str]:
    """Whether several recordings say the same."""
    compared = answer.agreement
    apart = [one for one in compared if one.p < DISAGREES]
    if not compared:
        return []
    if not apart:
        least = min(one.p for one in compared)
        return [f"Fitted one by one, the recordings agree on all sizes (least p = {least:.2g})."]
    return [
        f"The recordings do not agree on the {one.parameter} of {one.effect}: "
        + ", ".join(said(size.components[0][0], size.unit) for size in one.sizes)
        + f" (p = {one.p:.2g}); its interval holds the difference."
        for one in apart
    ]


def _held_out(answer: Diagnosis) -> str:
    if answer.fit.holdout == "run":
        return "on another recording"
    return "on blocks whose sizes were fitted without them (effects were chosen with them)"


def _how_sure(finding: Finding) -> str:
    if finding.probability is None:
        return ""
    return f" (probability {percent(finding.probability)})"


def _upper(text: str) -> str:
    return text[:1].upper() + text[1:]


def _cannot_tell(finding: Finding) -> str:
    others = [_named(finding.effect, one.effect) for one in finding.alternatives]
    return f"This recording cannot tell {finding.effect} from {', '.join(dict.fromkeys(others))}."


def _named(finding: str, other: str) -> str:
    """The name of an alternative, with what makes it look like the finding."""
    known = card_of(finding).confusion(other)
    called = known.called if known is not None else ""
    return called.format(phrase=other) if "{phrase}" in called else other
