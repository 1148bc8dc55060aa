"""Whether a machine was the file's until something broke, asked before any search.

An arm that flips into its other assembly mode, a rod that comes off or a motor that stops leaves
the platform somewhere else for good. That is for the eye and the spanner: no effect of the
vocabulary describes it, and what a search would name instead would be wrong.
"""

from __future__ import annotations

import numpy as np

from deltactl.diagnosis.admission.options import ADMISSION
from deltactl.diagnosis.observations.readings import FloatArray, IntArray
from deltactl.diagnosis.plants.delta.model import DeltaModel
from deltactl.foundation.errors import RecordingError


def refuse_broken(model: DeltaModel, source: str, left: FloatArray, span: float) -> None:
    """Refuse a recording in which the machine broke. Raises RecordingError, one line.

    left: readings less prediction, (n, channels), NaN where nothing was read. span: how much the
    readings move.
    """
    rows = np.flatnonzero(np.isfinite(left).any(axis=1))
    apart = np.nanmax(np.abs(left[rows]), axis=1)
    last = int((1.0 - ADMISSION.least_after) * len(apart))
    if last <= ADMISSION.least_before:
        return
    ratio, at = max(_contrast(apart, at) for at in _moments(ADMISSION.least_before, last))
    after = float(np.quantile(apart[at:], 1.0 - ADMISSION.nearly_all))
    if (
        ratio < ADMISSION.worse
        or after < ADMISSION.broken_off * span
        or not _moves(model, rows[at:], span)
    ):
        return
    shift_rad, rest = _shifted(model, rows[at:], left)
    if rest < ADMISSION.offsets * after and shift_rad < ADMISSION.most_lost_rad:
        return
    t_s, off = model.readings.t_s[rows], float(np.median(apart[at:]))
    raise RecordingError(_broke(model, source, float(t_s[at] - t_s[0]), off))


def refuse_once_near(model: DeltaModel, source: str, left: FloatArray) -> None:
    """Refuse a machine that was the file's for a time, where no other machine would fit.

    The bars are lower than those of `refuse_broken`. Raises RecordingError, one line.
    """
    read = np.isfinite(left).any(axis=1)
    apart = np.nanmax(np.abs(left[read]), axis=1)
    after = float(np.median(apart[len(apart) // 2 :]))
    near = apart < ADMISSION.still_agrees * after
    before = np.cumsum(near)[:-1]
    count = np.arange(1, len(near))
    agreed = before / count
    later = (near.sum() - before) / (len(near) - count)
    at = int(np.argmax(agreed - later))
    if (
        count[at] >= ADMISSION.least_before
        and agreed[at] > 1.0 - ADMISSION.stray
        and later[at] < ADMISSION.stray
    ):
        t_s = model.readings.t_s[read]
        raise RecordingError(_broke(model, source, float(t_s[at] - t_s[0]), after))


def _broke(model: DeltaModel, source: str, when_s: float, off: float) -> str:
    """What to tell about it."""
    return (
        f"{source}: up to {when_s:.1f} s recording and robot file agree, from there on they are "
        f"{off:.2g} {model.readings.units[0]} apart: has an arm flipped to its other side, a rod "
        "come off or a motor stopped? Put it right, home the robot and record again"
    )


def _moments(first: int, last: int) -> list[int]:
    return [int(at) for at in np.linspace(first, last, ADMISSION.moments_tried)]


def _contrast(apart: FloatArray, at: int) -> tuple[float, int]:
    """How many times farther off nearly all readings are from a moment on than before it."""
    before = float(np.quantile(apart[:at], ADMISSION.nearly_all))
    return float(np.quantile(apart[at:], 1.0 - ADMISSION.nearly_all)) / max(before, 1e-9), at


def _moves(model: DeltaModel, rows: IntArray, span: float) -> bool:
    return (
        float(np.nanmax(np.nanstd(model.position_m[rows], axis=0))) > ADMISSION.least_moving * span
    )


def _shifted(model: DeltaModel, rows: IntArray, left: FloatArray) -> tuple[float, float]:
    """The largest shift of a joint [rad] where each is shifted as fits best, and how far off the
    readings are then (median).
    """
    joints = model.traits.events
    columns = [change for place, change in model.inputs().items() if place in joints]
    known = np.isfinite(left[rows])
    moved = np.stack([change[rows][known] for change in columns], axis=1)
    rest = left[rows][known]
    shift = np.linalg.lstsq(moved, rest, rcond=None)[0]
    return float(np.abs(shift).max()), float(np.median(np.abs(rest - moved @ shift)))
