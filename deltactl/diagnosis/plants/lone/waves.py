"""Waves over the travel of an axis: how fine ones a recording resolves, and which are distinct."""

from __future__ import annotations

import numpy as np

from deltactl.diagnosis.observations.readings import FloatArray
from deltactl.diagnosis.plants.lone.options import COMMANDED_AXIS


def resolved_waves(positions: FloatArray, span: float, resolution: float) -> float:
    """Most waves over the travel that readings at these places (n,) can follow.

    Places, not rows: many readings at few places show no wave between them, and passes whose
    readings fall between each other's show a finer one than any pass by itself. Where the places
    are evenly spaced, waves beyond half their number look like coarser ones.
    """
    if not span > 0.0:
        return 0.0
    cells = COMMANDED_AXIS.cells_of_waves
    cell = np.unique(np.round((positions - np.min(positions)) * (cells / span)).astype(np.intp))
    visited = np.zeros(cells + 1)
    visited[np.clip(cell, 0, cells)] = 1.0
    alike = np.abs(np.fft.rfft(visited, 2 * cells)) / len(cell)
    first = int(4.0 * COMMANDED_AXIS.fewest_waves)  # in half waves, as the transform counts them
    repeats = np.flatnonzero(alike[first:] > COMMANDED_AXIS.places_alike)
    evenly = 0.25 * (first + repeats[0]) if len(repeats) else np.inf
    rounded = span / max(COMMANDED_AXIS.coarsest_steps * resolution, 1e-300)
    return float(min(evenly, rounded, len(cell) / COMMANDED_AXIS.places_a_wave, cells / 8.0))


def spectrum(left: FloatArray, at: FloatArray, waves: FloatArray) -> FloatArray:
    """Power (k,) of what is left (n,) at places (n,), in travels; waves: evenly spaced, (k,).

    Readings are shared out between the two nearest points of a grid with sixteen points a wave,
    which takes two per cent off the power of the shortest.
    """
    step = float(waves[1] - waves[0])
    count = int(2 ** np.ceil(np.log2(16.0 * waves[-1] / step)))
    place = (at - np.min(at)) * step * count
    below = np.floor(place).astype(np.intp)
    share = place - below
    folded = np.bincount(below % count, (1.0 - share) * left, count)
    folded = folded + np.bincount((below + 1) % count, share * left, count)
    number = np.round(waves / step).astype(np.intp)
    power: FloatArray = np.abs(np.fft.rfft(folded)[number]) ** 2
    return power
