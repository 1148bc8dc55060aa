"""Stretches in which a sensor repeats an old value."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from deltactl.diagnosis.observations.options import OBSERVATIONS
from deltactl.diagnosis.observations.readings import BoolArray, Readings, long_repeats


@dataclass(frozen=True, slots=True)
class Stale:
    """A stretch [first, last] of rows in which a sensor repeats one number."""

    channel: str
    first: int
    last: int
    log_p: float


def stale_runs(readings: Readings, channels: Sequence[str]) -> list[Stale]:
    """Repeats in some channels, too long for rounding and noise to make by chance."""
    found: list[Stale] = []
    for column, name in enumerate(readings.names):
        if name not in channels:
            continue
        values = readings.values[:, column]
        rate = float(np.mean(np.diff(values) == 0.0))
        if not 0.0 < rate < 0.6:
            continue
        own: list[Stale] = []
        for first, last in long_repeats(values, OBSERVATIONS.fewest_repeats):
            log_p = float(np.log(len(values)) + (last - first) * np.log(rate))
            if log_p < np.log(OBSERVATIONS.chance):
                own.append(Stale(name, first, last, log_p))
        held = [values[run.first] for run in own]
        if len(own) < OBSERVATIONS.many or len(set(held)) > len(own) // 2:
            found += own  # the same value again and again is the end of a range, not an old value
    return found


def without_stale(readings: Readings, channels: Sequence[str]) -> tuple[BoolArray, list[Stale]]:
    """The mask of valid readings (n, channels) less repeats of old values, and those repeats.

    channels: those that may repeat one.
    """
    runs = stale_runs(readings, channels)
    kept = readings.valid.copy()
    for run in runs:
        kept[run.first + 1 : run.last + 1, readings.names.index(run.channel)] = False
    return kept, runs
