"""Observations of one or several recordings, laid end to end, with a mask of what is valid."""

from __future__ import annotations

import itertools
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from functools import cached_property
from types import MappingProxyType
from typing import Any

import numpy as np
from scipy.ndimage import median_filter

from deltactl.diagnosis.observations.options import OBSERVATIONS
from deltactl.foundation.scatter import MAD_TO_SIGMA
from deltactl.recording.column_measures import first_of, step_of
from deltactl.recording.tables.flat import GAP_PERIODS, FlatRecording

FloatArray = np.ndarray[Any, np.dtype[np.float64]]
BoolArray = np.ndarray[Any, np.dtype[np.bool_]]
IntArray = np.ndarray[Any, np.dtype[np.intp]]


@dataclass(frozen=True, eq=False)
class Readings:
    """Values (n, channels) of the named channels; NaN or invalid where nothing was seen.

    t_s counts on from recording to recording (`shift_s` says by how much each was moved).
    """

    t_s: FloatArray
    fresh: BoolArray
    part: np.ndarray[Any, np.dtype[np.intp]]
    """Number of the recording each sample comes from, (n,)."""
    shift_s: tuple[float, ...]
    names: tuple[str, ...]
    units: tuple[str, ...]
    values: FloatArray
    valid: BoolArray

    @cached_property
    def rounding(self) -> list[float]:
        """Standard deviation of rounding to its smallest step, for each channel."""
        return [_rounding(self.values[:, column]) for column in range(len(self.names))]

    @cached_property
    def period_s(self) -> float:
        """Usual time between samples [s]."""
        return float(np.median(np.diff(self.t_s)))

    @cached_property
    def step_s(self) -> FloatArray:
        """Time since the row before (n,) [s]; 0 where a stretch begins."""
        return np.where(self.fresh, 0.0, np.diff(self.t_s, prepend=self.t_s[0]))

    @cached_property
    def stretch_start_s(self) -> FloatArray:
        """When the stretch of a row began (n,) [s]."""
        began: FloatArray = self.t_s[self.fresh][np.cumsum(self.fresh) - 1]
        return began

    @property
    def span_s(self) -> float:
        """Time from first to last sample [s]."""
        return float(self.t_s[-1] - self.t_s[0])

    def own_time_s(self, t_s: float) -> float:
        """A time on the joint axis as the recording it lies in counts it."""
        at = min(int(np.searchsorted(self.t_s, t_s)), len(self.t_s) - 1)
        return t_s - self.shift_s[int(self.part[at])]

    def recording_of(self, t_s: float) -> int:
        """Number (from 1) of the recording that a time on the joint axis lies in."""
        at = min(int(np.searchsorted(self.t_s, t_s)), len(self.t_s) - 1)
        return int(self.part[at]) + 1

    def end_s(self, recording: int) -> float:
        """Last time of a recording (counted from 1), as that recording counts it."""
        last = int(np.flatnonzero(self.part == recording - 1)[-1])
        return float(self.t_s[last]) - self.shift_s[recording - 1]

    @property
    def whole(self) -> list[tuple[float, float]]:
        """First and last time of each recording, as it counts them itself."""
        firsts = [int(np.argmax(self.part == n)) for n in range(len(self.shift_s))]
        return [
            (float(self.t_s[first]) - self.shift_s[n], self.end_s(n + 1))
            for n, first in enumerate(firsts)
        ]


class Layout:
    """How the columns of all joints, or of all that was measured, are one: one after another,
    section after section.

    Samples a filter's memory apart say all that passed the low-pass; the others are left out.

    Sections hold equally many rows that count, so that a share of the column left out is a time
    left out of all joints, as a size is to be foretold in another motion and not in another joint.
    """

    def __init__(self, counts: BoolArray, sections: int, stride: int = 1):
        """counts: (samples, columns); stride: samples from one that is kept to the next."""
        self.kept = np.arange(0, len(counts), stride)
        samples, self.width = len(self.kept), counts.shape[1]
        counted = np.cumsum(counts[self.kept].sum(axis=1))
        ends = np.searchsorted(counted, counted[-1] * np.arange(1, sections) / sections)
        section = np.searchsorted(ends, np.arange(samples), side="right")
        key = section[:, None] * self.width + np.arange(self.width)
        order = np.argsort(key.T.ravel(), kind="stable")
        self.column: IntArray = np.repeat(np.arange(self.width), samples)[order]
        self._row: IntArray = np.tile(np.arange(samples), self.width)[order]
        self.sample: IntArray = self.kept[self._row]

    def laid(self, values: FloatArray) -> FloatArray:
        """(samples, columns) or (samples, columns, k) as (n,) or (n, k)."""
        return values[self.sample, self.column]

    def apart(self, column: FloatArray) -> FloatArray:
        """(n,) as (samples, columns)."""
        made = np.empty((len(self.kept), self.width))
        made[self._row, self.column] = column
        return made

    def readings(self, whole: Readings, counts: BoolArray, channel: str, unit: str) -> Readings:
        """One channel in stretches of a column each, nothing observed yet; whole: when it was."""
        own_s, period_s = whole.t_s[self.sample], whole.period_s
        stretch = np.cumsum(whole.fresh)[self.sample]
        fresh = np.diff(stretch, prepend=-1) != 0
        fresh |= np.diff(self.column, prepend=-1) != 0
        fresh |= np.diff(self._row, prepend=-2) != 1
        step = np.diff(own_s, prepend=own_s[0])
        step[fresh] = OBSERVATIONS.between_recordings_s
        step[0] = 0.0
        t_s = own_s[0] + np.cumsum(np.maximum(step, 1e-3 * period_s))
        return Readings(
            t_s, fresh, whole.part[self.sample], whole.shift_s, (channel,), (unit,),
            np.zeros((len(t_s), 1)), counts[self.sample, self.column][:, None],
        )  # fmt: skip


def _rounding(values: FloatArray) -> float:
    known = values[np.isfinite(values)]
    steps = np.diff(np.unique(np.round(known, 9)))
    steps = steps[steps > 1e-8]
    return float(steps.min()) / np.sqrt(12.0) if len(steps) else 0.0


def starts_of(recording: FlatRecording) -> BoolArray:
    """Where a new stretch starts: a change of `segment`, or a gap of twenty periods."""
    t_s = recording.t_s
    fresh = np.zeros(len(t_s), dtype=bool)
    fresh[0] = True
    if len(t_s) > 2:
        step = np.diff(t_s)
        fresh[1:] |= step > GAP_PERIODS * np.median(step)
    if "segment" in recording.columns:
        fresh[1:] |= np.diff(recording.columns["segment"]) != 0
    return fresh


def gather(
    recordings: Sequence[FlatRecording],
    names: Sequence[str],
    unit: dict[str, str],
    status: Mapping[str, str] = MappingProxyType({}),
) -> Readings:
    """Lay recordings end to end.

    names: channels to gather, with `unit` for each. status: for channels that have one, the column
    that is 0 where a reading is good.
    """
    times, fresh, parts, values, valid, shifts = [], [], [], [], [], []
    begin = 0.0
    for number, recording in enumerate(recordings):
        shift = begin - recording.t_s[0] if number else 0.0
        times.append(recording.t_s + shift)
        shifts.append(float(shift))
        begin = float(times[-1][-1]) + OBSERVATIONS.between_recordings_s
        fresh.append(starts_of(recording))
        parts.append(np.full(len(recording), number))
        block, good = _block(recording, names, status)
        values.append(block)
        valid.append(good)
    return Readings(
        np.concatenate(times), np.concatenate(fresh), np.concatenate(parts), tuple(shifts),
        tuple(names), tuple(unit[name] for name in names),
        np.concatenate(values), np.concatenate(valid),
    )  # fmt: skip


def _block(
    recording: FlatRecording, names: Sequence[str], status: Mapping[str, str]
) -> tuple[FloatArray, BoolArray]:
    block = np.full((len(recording), len(names)), np.nan)
    for column, name in enumerate(names):
        if name in recording.columns:
            block[:, column] = recording.columns[name]
    good = np.isfinite(block)
    for column, name in enumerate(names):
        said = recording.columns.get(status.get(name, ""))
        if said is not None:
            good[:, column] &= said == 0
        if good[:, column].any():
            good[:, column] &= ~_repeats(block[:, column])
    return block, good


def _repeats(values: FloatArray) -> BoolArray:
    """Rows that repeat the one before because the sensor was read faster than it measures.

    Only when about half the rows or more do; rounding alone also makes neighbours equal. Readings
    that mostly change by a single step are rounded: of these the first of a value is always ahead.
    """
    same = np.zeros(len(values), dtype=bool)
    same[1:] = values[1:] == values[:-1]
    known = values[np.isfinite(values)]
    moving = len(known) > 0 and known.max() > known.min()
    low, high = OBSERVATIONS.held
    if not moving or not low < same.mean() < high:
        return np.zeros_like(same)
    changes = np.abs(np.diff(known))
    if np.median(changes[changes > 0.0]) < OBSERVATIONS.single_step * step_of(known):
        return np.zeros_like(same)
    runs = np.diff(np.flatnonzero(~same))
    usual = np.median(runs) if len(runs) else 1
    even = OBSERVATIONS.evenly_held
    regular = len(runs) > 0 and usual >= 2 and np.mean(np.abs(runs - usual) <= 1) > even
    return same if regular else np.zeros_like(same)


def without_outliers(residual: FloatArray, valid: BoolArray) -> BoolArray:
    """The valid mask without single outliers in their neighbourhood (Hampel).

    If a machine rests between short moves, the model error itself looks like outliers while it
    moves: if that is more than a few readings of a channel, none of them is an outlier.
    """
    kept = valid.copy()
    for column in range(residual.shape[1]):
        rows = np.flatnonzero(valid[:, column])
        if len(rows) < OBSERVATIONS.hampel_rows:
            continue
        values = residual[rows, column]
        off = np.abs(values - median_filter(values, OBSERVATIONS.hampel_rows, mode="nearest"))
        scale = MAD_TO_SIGMA * np.median(off)
        out = off > OBSERVATIONS.hampel_limit * max(scale, 1e-15)
        if out.mean() <= OBSERVATIONS.most_outliers:
            kept[rows[out], column] = False
    return kept


def bridged(recording: FlatRecording, name: str) -> FloatArray:
    """An input column (n,) with its holes bridged; `admission` sees that they are few."""
    values = recording.columns[name]
    known = np.isfinite(values)
    return np.interp(recording.t_s, recording.t_s[known], values[known])


def known_loads(recordings: Sequence[FlatRecording]) -> FloatArray:
    """The load that a column gives, (n,), of recordings laid end to end; 0 where none does."""
    return np.concatenate(
        [bridged(r, "load") if first_of(r, ["load"]) else np.zeros(len(r)) for r in recordings]
    )


def smoothly_bridged(recording: FlatRecording, name: str) -> FloatArray:
    """The same of a motion: a straight line across one lost position has no acceleration."""
    from scipy.interpolate import CubicSpline  # takes 0.1 s to import

    values, t_s, whole = recording.columns[name], recording.t_s, bridged(recording, name)
    moments, first = np.unique(t_s[np.isfinite(values)], return_index=True)
    inside = ~np.isfinite(values) & (t_s > moments[0]) & (t_s < moments[-1])
    if inside.any():
        known = values[np.isfinite(values)][first]
        whole[inside] = CubicSpline(moments, known)(t_s[inside])
    return whole


def long_repeats(values: FloatArray, shortest: int) -> list[tuple[int, int]]:
    """Stretches [first, last] of rows that repeat one number at least `shortest` times."""
    same = np.flatnonzero(np.diff(values) != 0.0)
    edges = np.concatenate([[-1], same, [len(values) - 1]])
    return [(int(a) + 1, int(b)) for a, b in itertools.pairwise(edges) if b - a >= shortest]
