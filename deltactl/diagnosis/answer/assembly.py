"""The one place where an answer is put together, so that its parts agree."""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import Any

from deltactl.diagnosis.answer.options import VERDICT
from deltactl.diagnosis.answer.records import Diagnosis, Finding, Fit, Unexplained
from deltactl.diagnosis.answer.verdict import Rest, is_noise, left_over, seen, verdict


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
        share_of_mismatch=share, depends_on=list(rest.depends_on), component=rest.component,
        p=rest.p,
    )  # fmt: skip
