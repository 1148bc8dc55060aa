"""The answer put together: verdict, fit, what the file knew, and sizes as far as rows tell."""

from __future__ import annotations

import math
from collections.abc import Sequence
from pathlib import Path
from typing import Any

from deltactl.diagnosis.answer.finding import ParameterResult
from deltactl.diagnosis.answer.options import VERDICT
from deltactl.diagnosis.answer.records import Diagnosis, Finding, Fit, Known, Unexplained
from deltactl.diagnosis.answer.verdict import Rest, is_noise, left_over, seen, verdict
from deltactl.models.effects import Trait, has
from deltactl.models.robot import RobotModel

SMEARED = 1.0 / 4.0 + 1.0 / 4.0
"""Most that straight lines add to the variance of a delay, in squared row distances: f (1 - f) of a
dead time that ends at a part f of a row, and twice the eighth by which a chord misses a bend."""


def as_far_as_rows_tell(finding: Finding, period_s: float) -> Finding:
    """A delay with both its parts as uncertain as rows so far apart [s] leave them."""
    time, dead = (finding.parameters.get(name) for name in ("time", "dead_time"))
    if not has(finding.effect, Trait.DRIVE_DELAY) or time is None or dead is None:
        return finding
    if len(time.components) != 1 or len(dead.components) != 1:
        return finding
    value_s, low_s, high_s = time.components[0]
    _, dead_low_s, dead_high_s = dead.components[0]
    slack_s = math.hypot(value_s, math.sqrt(SMEARED) * period_s) - value_s
    slack_s = min(slack_s, max(dead_high_s, 0.0))  # their sum stays, and no dead time is below 0
    wider = {
        "time": _between(time, low_s, high_s + slack_s),
        "dead_time": _between(dead, min(dead_low_s, max(dead_low_s - slack_s, 0.0)), dead_high_s),
    }
    return finding.model_copy(update={"parameters": {**finding.parameters, **wider}})


def _between(result: ParameterResult, low: float, high: float) -> ParameterResult:
    return result.model_copy(update={"ci95": [low, high]})


def known_of(robot: RobotModel, recordings: Sequence[Path]) -> list[Known]:
    """Effects of the robot file that a diagnosis found; recordings: what is diagnosed now."""
    names = {path.name for path in recordings}
    return [
        Known(
            effect=entry.effect,
            component=entry.component,
            probability=entry.found.probability,
            from_these_recordings=bool(names & set(entry.found.recordings)),
        )
        for entry in robot.effects
        if entry.found is not None
    ]


def assembled(
    findings: Sequence[Finding],
    fit: Fit,
    p: float,
    rest: Rest,
    probability_nothing_missing: float | None = None,
    **more: Any,
) -> Diagnosis:
    """The answer: findings and figures that agree, what is left, the verdict.

    p: calibrated p of 'nothing is missing', before any finding. more: further fields of
    `Diagnosis`.
    """
    fit = with_floor(fit, rest)
    share = left_over(fit, rest)
    found = sharing(findings, 1.0 - share)
    return Diagnosis(
        verdict=verdict(found, fit, p, rest, probability_nothing_missing),
        probability_nothing_missing=probability_nothing_missing,
        false_alarm_p=p,
        fit=fit,
        findings=found,
        unexplained=unexplained(fit, rest, share),
        **more,
    )


def with_floor(fit: Fit, rest: Rest) -> Fit:
    """The noise floor no higher than what is left; lower where a test explains some of that.

    A floor is estimated with many columns at once and is uncertain; a fit of a few sizes that
    leaves less shows that the noise is less.
    """
    most = fit.rms_after_m
    if seen(rest.p):
        most *= math.sqrt(max(1.0 - max(rest.share, VERDICT.least_seen), 0.0))
    return fit.model_copy(update={"noise_floor_m": min(fit.noise_floor_m, most)})


def allowing(fit: Fit, may_m: float) -> Fit:
    """The same where no test sees more: what effects of the robot file may leave is noise too.

    may_m: how large that is, root mean square, in the unit of the fit.
    """
    least = max(fit.noise_floor_m, min(fit.rms_after_m, math.hypot(fit.noise_floor_m, may_m)))
    return fit.model_copy(update={"noise_floor_m": least, "left_by_known_m": may_m})


def sharing(findings: Sequence[Finding], most: float) -> list[Finding]:
    """Findings whose shares add up to no more than `most`: what two explain alike counts once."""
    total = sum(finding.share_of_mismatch for finding in findings)
    if total <= most:
        return list(findings)
    return [
        one.model_copy(update={"share_of_mismatch": one.share_of_mismatch * most / total})
        for one in findings
    ]


def unexplained(fit: Fit, rest: Rest, share: float) -> Unexplained:
    """What no finding explains."""
    if is_noise(fit, rest):
        return Unexplained(share_of_mismatch=0.0, p=rest.p)
    return Unexplained(
        share_of_mismatch=share,
        depends_on=list(rest.depends_on),
        component=rest.component,
        p=rest.p,
    )
