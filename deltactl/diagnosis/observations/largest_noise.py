"""The largest noise that the spectra of readings allow, whatever an explanation leaves of them.

Noise of a reading is white or remembers the readings before (an autoregression of first order), or
both: its spectrum is a sum of such shapes, in all bands at once. What the machine does adds to it
in some bands, and takes nothing away in any. So noise is nowhere above what is seen, and what is
seen between the bands of the motion bounds it in them (Welch 1967, IEEE Trans. Audio Electroacoust.
15, 70-73; Mann and Lees 1996, Climatic Change 33, 409-445, for the red background).
"""

from __future__ import annotations

import itertools
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from scipy.special import gammaincinv

from deltactl.diagnosis.observations.options import OBSERVATIONS
from deltactl.diagnosis.observations.readings import BoolArray, FloatArray, IntArray


@dataclass(frozen=True, slots=True, eq=False)
class Spectrum:
    """Mean periodogram (m,) at angles (m,) a reading, white noise of variance 1 being 1 in it.

    segments: how many independent ones were averaged.
    """

    angle: FloatArray
    power: FloatArray
    segments: float

    def between(self, low: float, high: float) -> Spectrum:
        """The part in a band of angles."""
        chosen = (self.angle >= low) & (self.angle <= high)
        return Spectrum(self.angle[chosen], self.power[chosen], self.segments)


@dataclass(frozen=True, slots=True, eq=False)
class Bound:
    """What is seen in a band, and what each kind of noise has in it per unit, (m, k)."""

    seen: Spectrum
    shapes: FloatArray


@dataclass(frozen=True, slots=True, eq=False)
class NoiseBounds:
    """Bounds on a mixture of noises; each of unit size has a `variance` (k,) in the residual."""

    bounds: Sequence[Bound]
    variance: FloatArray

    def largest(self, level: float) -> float:
        """Standard deviation that noise exceeds with a chance of at most `level`."""
        from scipy.optimize import linprog  # takes 0.1 s to import

        count = sum(len(one.seen.power) for one in self.bounds)
        rows = [one.shapes / _at_most(one.seen, level / count)[:, None] for one in self.bounds]
        shapes = np.concatenate(rows)
        scale = np.maximum(shapes.max(axis=0), 1e-300)
        value = self.variance / scale
        best = linprog(
            -value / float(value.max()), A_ub=shapes / scale, b_ub=np.ones(count), bounds=(0, None)
        )
        return float(np.sqrt(value @ best.x)) if best.success else float("inf")

    def chance(self, size: float) -> float:
        """Chance that noise leaves as much, to the next lower level; 1 where it well may."""
        found = 1.0
        for level in OBSERVATIONS.noise_levels:
            if size <= self.largest(level):
                break
            found = level
        return found


def _at_most(seen: Spectrum, level: float) -> FloatArray:
    """What a mean periodogram's expectation exceeds with a chance of at most `level`, (m,)."""
    freedom = max(seen.segments, 2.0)
    most: FloatArray = seen.power * (freedom / (2.0 * gammaincinv(freedom / 2.0, level)))
    return most


def remembering(angle: FloatArray) -> FloatArray:
    """Spectra (m, k) of noises of unit variance that remember little to much."""
    turned = np.exp(-1j * angle)[:, None]
    rho = np.array(OBSERVATIONS.noise_memories)
    density: FloatArray = (1.0 - rho**2) / np.abs(1.0 - rho * turned) ** 2
    return density


def spectrum(
    values: FloatArray, groups: IntArray, segment: int, counts: BoolArray | None = None
) -> Spectrum | None:
    """Spectrum of values (n,) by half-overlapping segments within each group (n,); None: too few of
    them.

    counts: (n,) which values are known. Halves the segments until there are enough.
    """
    ends = [0, *(np.flatnonzero(np.diff(groups)) + 1).tolist(), len(values)]
    known = np.ones(len(values)) if counts is None else counts.astype(float)
    while segment >= OBSERVATIONS.shortest_segment:
        window = np.hanning(segment + 2)[1:-1]
        begins = [
            begin
            for first, last in itertools.pairwise(ends)
            for begin in range(first, last - segment + 1, segment // 2)
        ]
        rows = np.array(begins, dtype=np.intp)[:, None] + np.arange(segment)
        mask = known[rows]
        full = (mask * window**2).sum(axis=1) / float(window @ window)
        kept = full > OBSERVATIONS.least_of_segment
        if np.count_nonzero(kept) >= OBSERVATIONS.fewest_segments:
            mask, part = mask[kept], values[rows[kept]]
            part = mask * (part - _line(part, mask))
            power = np.abs(np.fft.rfft(part * window, axis=1)) ** 2
            mean = power.sum(axis=0) / float(np.sum((mask * window) ** 2))
            bins = np.arange(1, segment // 2)
            if not mean[bins].all():  # what never changes has no noise to see
                return None
            return Spectrum(2.0 * np.pi * bins / segment, mean[bins], float(full[kept].sum()))
        segment //= 2
    return None


def _line(part: FloatArray, mask: FloatArray) -> FloatArray:
    """Mean and, of whole segments, slope of each segment (s, m), at its values."""
    mean = (part * mask).sum(axis=1) / mask.sum(axis=1)
    along = np.arange(part.shape[1]) - 0.5 * (part.shape[1] - 1.0)
    slope = (part @ along) / float(along @ along) * mask.all(axis=1)
    line: FloatArray = mean[:, None] + slope[:, None] * along
    return line


def segment_for(readings: int, band: float = 0.0) -> int:
    """Readings a segment: enough to resolve a band of angles, and few enough for a mean."""
    fine = (
        OBSERVATIONS.bins_in_band * 2.0 * np.pi / band
        if band
        else OBSERVATIONS.longest_plain_segment
    )
    most = max(readings // OBSERVATIONS.readings_of_segments, OBSERVATIONS.shortest_segment)
    limit = OBSERVATIONS.longest_segment if band else OBSERVATIONS.longest_plain_segment
    return int(2 ** np.floor(np.log2(min(2.0 ** np.ceil(np.log2(fine)), most, limit))))
