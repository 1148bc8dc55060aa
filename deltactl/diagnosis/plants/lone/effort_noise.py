"""What the noise of an effort and of a position comes to in the force that nothing explains."""

from __future__ import annotations

import numpy as np

from deltactl.diagnosis.observations.inverse_dynamics import Motion
from deltactl.diagnosis.observations.largest_noise import (
    Bound,
    NoiseBounds,
    remembering,
    segment_for,
    spectrum,
)
from deltactl.diagnosis.observations.options import OBSERVATIONS
from deltactl.diagnosis.observations.readings import BoolArray, FloatArray, IntArray
from deltactl.models.signals import between_rows

DIFFERENCES = 3
"""By which a position's slow course is taken off before its fast part is looked at."""


class EffortNoise:
    """Bounds on both noises, from the raw readings beyond the low-pass and the residual within."""

    def __init__(self, motion: Motion, inertia: float, period_s: float, groups: IntArray):
        self._motion, self._groups = motion, groups
        self._period_s, self._inertia = period_s, inertia
        self._edge = 2.0 * np.pi * motion.cut_off_hz * period_s
        self._segment = segment_for(len(groups), self._edge)

    def bounds(
        self, left: FloatArray, force: FloatArray, position: FloatArray, counts: BoolArray
    ) -> NoiseBounds | None:
        """Bounds for a residual force (n,), all and where it counts, and of raw force and
        position."""
        bands = OBSERVATIONS.within_band, OBSERVATIONS.beyond_band
        within, beyond = (band * self._edge for band in bands)
        found: list[Bound] = []
        for known in (None, counts):
            seen = spectrum(left, self._groups, self._segment, known)
            seen = seen and seen.between(0.0, within)
            if seen is not None and len(seen.angle) >= OBSERVATIONS.fewest_bins:
                found.append(Bound(seen, self._passed(seen.angle)))
        fast = np.zeros_like(position)
        fast[DIFFERENCES:] = np.diff(position, DIFFERENCES)
        for values, order, column in ((force, 0, 0), (fast, DIFFERENCES, 1)):
            seen = spectrum(values, self._groups, self._segment)
            seen = seen and seen.between(within, beyond)
            if seen is not None and len(seen.angle) >= OBSERVATIONS.fewest_bins:
                gain = (2.0 * np.sin(0.5 * seen.angle)) ** (2 * order)
                own = gain[:, None] * remembering(seen.angle)
                parts = [np.zeros_like(own), np.zeros_like(own)]
                parts[column] = own
                found.append(Bound(seen, np.concatenate(parts, axis=1)))
        if not found:
            return None
        angle = np.linspace(0.0, np.pi, OBSERVATIONS.angles_summed)[1:]
        return NoiseBounds(found, self._passed(angle).mean(axis=0))

    def _passed(self, angle: FloatArray) -> FloatArray:
        """Spectra (m, 2 k) of unit noises of effort and of position in the residual."""
        passed = self._motion.passes(angle)[:, None] * remembering(angle)
        bent = (self._inertia * (angle[:, None] / self._period_s) ** 2) ** 2
        return np.concatenate([passed, bent * passed], axis=1)


def between_samples(motion: Motion, force: FloatArray) -> FloatArray:
    """What the low-pass keeps of a force (n,) that is no straight line between its samples."""
    angle = np.linspace(0.0, np.pi, OBSERVATIONS.angles_summed)[1:]
    kept = float(np.mean(motion.passes(angle)))
    kept_power: FloatArray = kept * np.maximum(motion.low_passed(between_rows(force) ** 2), 0.0)
    return np.sqrt(kept_power)
