"""Before and after the findings against the noise floor, in words."""

from __future__ import annotations

import math

from deltactl.diagnosis.answer.records import Diagnosis, Fit
from deltactl.diagnosis.report.phrases.left_words import (
    doubtful_floor,
    mostly_by_place,
    moves_at_rest,
    record_more,
    said_of_rest,
    scatter_within,
    where_left,
)
from deltactl.diagnosis.report.phrases.sizes import quantity
from deltactl.models.effects import VOCABULARY

ONE_OFF = frozenset(kind.name for kind in VOCABULARY.values() if kind.event)

LEAST_ABOVE = 0.01
"""Of the noise floor: a mismatch that is hardly above it has no share to speak of."""
LEFT_OUT = "parts of the recording to which no size was fitted (causes were chosen with all of it)"


def fit_title(diagnosis: Diagnosis) -> str:
    """Heading of the figures of the fit."""
    return "Does it help?" if diagnosis.findings else "How well the robot file fits"


def fit_lines(diagnosis: Diagnosis) -> list[str]:
    """Before and after against the noise floor, on this recording and on held-out data."""
    fit = diagnosis.fit
    before, after, floor = (
        quantity(value, fit.unit, digits=3)
        for value in (fit.rms_before_m, fit.rms_after_m, fit.noise_floor_m)
    )
    beside = [*_filtered(fit), *_by_place(diagnosis)]
    unheld = [f"Held-out data left out: {why}." for why in diagnosis.not_held_out]
    if diagnosis.verdict == "unexplained" and not diagnosis.findings:
        return [f"Mismatch {before}.", *beside, *_elsewhere(fit), *unheld]
    if not diagnosis.findings:
        allowed = f"; {after} with the small errors allowed for" if diagnosis.loosely_built else ""
        mismatch = f"Mismatch {before}{allowed}{_floor(fit, floor)}."
        return [mismatch, *beside, *_elsewhere(fit), *unheld]
    lines = [f"Mismatch before {before}, after {after}{_floor(fit, floor)}.", *beside]
    held = (fit.holdout_rms_before_m, fit.holdout_rms_after_m)
    if all(math.isfinite(value) for value in held):
        where = "another run" if fit.holdout == "run" else LEFT_OUT
        was, became = (quantity(value, fit.unit, digits=3) for value in held)
        lines.append(f"On {where}: before {was}, after {became}{_held_out_gain(diagnosis)}.")
    else:
        lines.append("Nothing could be held out, so that the gain is not proved on other data.")
    return [*lines, *unheld]


def _elsewhere(fit: Fit) -> list[str]:
    """The mismatch on another run, where nothing was found."""
    size = fit.holdout_rms_before_m
    if fit.holdout != "run" or not math.isfinite(size):
        return []
    return [f"On another run: mismatch {quantity(size, fit.unit, digits=3)}."]


def _filtered(fit: Fit) -> list[str]:
    """That efforts were compared after a filter, which single readings were not."""
    if fit.unit not in ("N", "N m") or fit.left_apart_s is None:
        return []
    apart = quantity(fit.left_apart_s, "s", digits=2)
    return [
        f"This is of the effort after a low-pass filter, one reading every {apart}; single readings"
        " scatter by more."
    ]


def _floor(fit: Fit, floor: str) -> str:
    """The noise floor, as a clause; empty where it is doubtful: it then depends on what else was
    fitted, and the same recording would be told another floor against a corrected file.
    """
    return "" if doubtful_floor(fit) else f"; the noise alone is {floor}"


def _by_place(diagnosis: Diagnosis) -> list[str]:
    """That most of what counts as noise does not show in readings at one place.

    Empty where it is said of what is left.
    """
    fit, rest = diagnosis.fit, diagnosis.unexplained
    if not mostly_by_place(fit) or moves_at_rest(fit):
        return []
    if said_of_rest(fit) and not rest.depends_on and rest.share_of_mismatch <= 0.0:
        return []
    what = "what is left" if doubtful_floor(fit) else "this noise"
    return [
        f"Readings at one place scatter by {scatter_within(fit, 3)}: {where_left(fit, what)}."
        f" {record_more(fit)}"
    ]


def _held_out_gain(diagnosis: Diagnosis) -> str:
    """How much of what is above the noise floor the findings take away on held-out data; of all of
    it where that floor is doubtful.
    """
    fit = diagnosis.fit
    if fit.holdout == "run" and all(one.effect in ONE_OFF for one in diagnosis.findings):
        return " (what happens once does not come back in another run)"
    doubtful = doubtful_floor(fit)
    above_m = fit.holdout_rms_before_m - (0.0 if doubtful else fit.noise_floor_m)
    if not math.isfinite(above_m) or above_m <= LEAST_ABOVE * fit.noise_floor_m:
        return ""
    gain = 100.0 * (fit.holdout_rms_before_m - fit.holdout_rms_after_m) / above_m
    if gain <= 0.0:
        return " (no gain there)"
    share = "over 99" if gain > 99.0 else f"{gain:.0f}"
    return f" ({share} % of {'it' if doubtful else 'what is above the noise'} is gone)"
