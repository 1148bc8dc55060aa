"""The verdict, for every kind of machine: made from the figures of the same answer."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

from deltactl.diagnosis.answer.options import VERDICT
from deltactl.diagnosis.answer.records import Alternative, Finding, Fit, Verdict
from deltactl.models.effects import VOCABULARY, Trait, has
from deltactl.models.effects.lone_axis import COMPONENT

ALARM = VERDICT.alarm
"""The one level of the engine, for the rooms that test."""
NAMELESS = "unknown"


@dataclass(frozen=True, slots=True)
class Rest:
    """What the tests say of the residual of the chosen explanation."""

    p: float
    """Calibrated p of its being noise."""
    depends_on: tuple[str, ...] = ()
    """Covariates of the best test."""
    component: str = ""
    """Where that enters."""
    share: float = 0.0
    """Share of the residual's chi-square that the best test explains."""


def seen(p: float) -> bool:
    """Whether a calibrated p raises the alarm."""
    return not p > VERDICT.alarm


def at_floor(fit: Fit) -> bool:
    """Whether the residual is no larger than the noise that the answer states."""
    return fit.rms_after_m <= VERDICT.at_floor * fit.noise_floor_m


def goes_on(fit: Fit) -> bool:
    """Whether what is left is much the same from one reading to the next, as no sensor's noise is.

    Tests and floor allow for noise with a memory, so that they take it for noise.
    """
    return (fit.left_correlation or 0.0) >= VERDICT.half_of_power


def too_little(fit: Fit, share: float, found: bool) -> bool:
    """Whether what is left is too little to act on.

    share: of the model error, that nothing explains. found: whether there are findings; without any
    all of the model error is left, which is held against what the file's measured effects do.
    """
    if found:
        return share < VERDICT.too_little
    left = fit.rms_after_m**2 - fit.noise_floor_m**2
    return left < VERDICT.too_little * fit.done_by_known_m**2


def much_goes_on(fit: Fit) -> bool:
    """Whether more than a faint rest of the model error is left and goes on between readings."""
    going_on = (fit.left_correlation or 0.0) * fit.rms_after_m**2
    return goes_on(fit) and going_on > VERDICT.faint_rest * fit.rms_before_m**2


def faint(fit: Fit, rest: Rest) -> bool:
    """Whether so little is left that is not a sensor's noise that the model explains the rest."""
    quiet = not seen(rest.p) or left_over(fit, rest) <= VERDICT.faint_rest
    return quiet and not much_goes_on(fit)


def is_noise(fit: Fit, rest: Rest) -> bool:
    """Whether the residual is consistent with measurement noise: by the tests and by its size."""
    return not seen(rest.p) and at_floor(fit)


def rather_unknown(finding: Finding) -> bool:
    """Whether it is named and far more probably a part of something unknown."""
    others = [
        alternative.probability or 0.0
        for alternative in finding.alternatives
        if alternative.effect == NAMELESS
    ]
    least = VERDICT.outweighed * (finding.probability or 0.0)
    return finding.effect != NAMELESS and max(others, default=0.0) > least


def as_well(other: Alternative) -> bool:
    """Whether an alternative fits as well, so that its probability is only how usual it is."""
    return abs(other.delta_chi2) < VERDICT.as_well


def claimed(finding: Finding) -> bool:
    """Whether it claims a cause by name."""
    return finding.effect != NAMELESS and not rather_unknown(finding)


def grew(fit: Fit) -> bool:
    """Whether the held-out model error grew with the findings."""
    return fit.holdout_rms_after_m > VERDICT.grew * fit.holdout_rms_before_m


def fits_worse(fit: Fit) -> bool:
    """Whether the model error as a whole is larger with what was found: tests that allow for noise
    with a memory judge by the fine course of the readings, and not by their size.
    """
    return fit.rms_after_m > VERDICT.grew * fit.rms_before_m


def gained(findings: Sequence[Finding], fit: Fit) -> bool:
    """Whether the held-out model error fell with the findings; where all of them are events, which
    do not come back, or act at places that another run may not come to, whether it did not grow.
    """
    kinds = [VOCABULARY.get(finding.effect) for finding in findings]
    if all(kind is not None and (kind.event or kind.local) for kind in kinds):
        return not grew(fit)
    return fit.holdout_rms_after_m < fit.holdout_rms_before_m


def left_over(fit: Fit, rest: Rest) -> float:
    """Share of the model error's power above the noise that nothing explains; 0 where it is
    noise."""
    if is_noise(fit, rest):
        return 0.0
    missing = fit.rms_before_m**2 - fit.noise_floor_m**2
    left = fit.rms_after_m**2 - fit.noise_floor_m**2
    return min(max(left / missing, 0.0), 1.0) if missing > 0.0 else 1.0


def verdict(
    findings: Sequence[Finding], fit: Fit, p: float, rest: Rest, nothing: float | None = None
) -> Verdict:
    """What may be said of findings, figures, p of 'nothing is missing' and the residual's test.

    nothing: posterior of the empty set. The alarm may be silent and the posterior not convinced:
    then neither claim would be sound.
    """
    if not findings:
        sound = not seen(p) and is_noise(fit, rest) and (nothing is None or nothing >= VERDICT.even)
        return "nothing_missing" if sound else "unexplained"
    named = [claimed(finding) for finding in findings]
    if not any(named):
        return "unexplained"
    whole = all(named) and at_floor(fit) and faint(fit, rest) and gained(findings, fit)
    return "explained" if whole else "partly_explained"


def differs_with_speed(finding: Finding, findings: Sequence[Finding]) -> int:
    """Number of the unknown by which a force of a single axis differs with the speed; 0 without
    one.

    What all speeds of a recording have in common is then no force of the machine at any of them.
    """
    if not has(finding.effect, Trait.FORCE) or finding.component != COMPONENT:
        return 0
    if not any(parameter.unit.startswith("N") for parameter in finding.parameters.values()):
        return 0
    for number, one in enumerate(findings, 1):
        by_speed = bool(one.depends_on) and one.depends_on[0].startswith("velocity")
        if one.effect == NAMELESS and one.component == COMPONENT and by_speed:
            return number
    return 0
