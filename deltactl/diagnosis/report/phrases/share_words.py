"""What a finding does: the mismatch without it, beside that with all findings, in words."""

from __future__ import annotations

import math

from deltactl.diagnosis.answer.records import Finding, Fit
from deltactl.diagnosis.report.phrases import sureness
from deltactl.diagnosis.report.phrases.left_words import doubtful_floor
from deltactl.diagnosis.report.phrases.sizes import quantity

MINOR = 0.2
"""Share of what is explained: what comes back of less sounds like a minor cause, which it need not
be."""
NEGLIGIBLE = 0.01
"""The same, of what is small by itself as well."""
MOSTLY_NOISE = 0.5
"""Of what is left, from which on noise would hide what a finding does: it is taken off both."""
NONE = 0.05
"""Of the mismatch without it: less is left of next to nothing."""


def share_line(finding: Finding, fit: Fit) -> str:
    """The mismatch if it alone were left out: what the other findings cannot take over."""
    compared = _compared(finding, fit)
    share, own = finding.share_of_mismatch, finding.own_share or 0.0
    if share >= MINOR:
        return f"Without it {compared}."
    if share >= NEGLIGIBLE or own >= NEGLIGIBLE:
        return (
            f"If it alone were left out, {compared}: the other findings would take over the rest,"
            " with wrong sizes."
        )
    more = ", but more than noise" if finding.evidence.p < sureness.SURE_P else ""
    return f"Its part is small{more}: without it {compared}."


def _compared(finding: Finding, fit: Fit) -> str:
    """The mismatch without it, instead of which, as a clause.

    Where it was not computed by itself, by the share of the power that comes back.
    """
    after_m, without_m, about = fit.rms_after_m, finding.left_without_m, ""
    if without_m is None:
        gone = max(fit.rms_before_m**2 - after_m**2, 0.0)
        without_m, about = math.sqrt(after_m**2 + finding.share_of_mismatch * gone), "about "
    what, beyond = "the mismatch", False
    if not doubtful_floor(fit) and fit.noise_floor_m > MOSTLY_NOISE * after_m:
        what, beyond = "the mismatch beyond the noise", True
        after_m, without_m = (_beyond(size, fit.noise_floor_m) for size in (after_m, without_m))
    without, after = (quantity(size, fit.unit, digits=3) for size in (without_m, after_m))
    if without == after:
        return f"{what} would be about the same"
    if without_m < after_m:
        return f"{what} as a whole would be no larger, yet what tells most would fit worse"
    if beyond and after_m < NONE * without_m:
        return f"{what} would be {about}{without} instead of next to none"
    unit = f" {after.partition(' ')[2]}"
    short = without.removesuffix(unit) if without.endswith(unit) else without
    return f"{what} would be {about}{short} instead of {after}"


def _beyond(size_m: float, noise_m: float) -> float:
    """What of a root mean square is not noise."""
    return math.sqrt(max(size_m**2 - noise_m**2, 0.0))
