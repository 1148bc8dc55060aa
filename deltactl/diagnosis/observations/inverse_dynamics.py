"""Velocity and acceleration of a measured position, with the low-pass both sides must pass."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from itertools import pairwise

import numpy as np

from deltactl.diagnosis.observations.ahead_in_time import SPLINE
from deltactl.diagnosis.observations.options import OBSERVATIONS
from deltactl.diagnosis.observations.readings import BoolArray, FloatArray
from deltactl.foundation.scatter import MAD_TO_SIGMA

FRAYED = 6
"""Rows at each end of a stretch where a slope of noisy readings is mostly their noise."""


@dataclass(frozen=True, slots=True, eq=False)
class Motion:
    """Low-passed position, velocity and acceleration (n,), and where they can be trusted."""

    position: FloatArray
    velocity: FloatArray
    acceleration: FloatArray
    settled: BoolArray
    """Rows away from the ends of a stretch, where a filter begins."""
    cut_off_hz: float
    turning: FloatArray
    """Velocity (n,) for friction, which turns faster than a low-passed one (Gautier 1997)."""
    velocity_noise: float
    """Standard deviation of the velocity's noise."""
    top_speed: float
    low_passed: Callable[[FloatArray], FloatArray]
    """Low-pass of values (n, ...)."""
    passes: Callable[[FloatArray], FloatArray]
    """Power (m,) that the low-pass leaves at angles (m,) a sample."""


def motion_of(
    t_s: FloatArray,
    fresh: BoolArray,
    position: FloatArray,
    velocity: FloatArray | None,
    narrower: float = 1.0,
) -> Motion:
    """Motion of a position (n,), stretch by stretch; velocity: as measured, where there is one.

    narrower: share of the frequency where the position meets its noise at which the low-pass ends.
    """
    # Takes 0.3 s to import. Splines: differences make a mass larger by (omega period)^2 / 3.
    from scipy.fft import dct, idct
    from scipy.interpolate import make_interp_spline

    step_s = float(np.median(np.diff(t_s)))
    starts = [*np.flatnonzero(fresh).tolist(), len(t_s)]
    stretches = [slice(a, b) for a, b in pairwise(starts)]
    longest = max(stretches, key=lambda s: s.stop - s.start)
    # A filter counts samples: a logger that takes 10 ms here and 12 there would make it bend time.
    uneven = any(_uneven(t_s[part], step_s) for part in stretches)

    def even_s(part: slice) -> FloatArray:
        return np.asarray(np.linspace(t_s[part][0], t_s[part][-1], part.stop - part.start))

    def resampled(values: FloatArray, from_s: FloatArray, to_s: FloatArray) -> FloatArray:
        return np.asarray(make_interp_spline(from_s, values, SPLINE)(to_s)) if uneven else values

    evenly = resampled(position[longest], t_s[longest], even_s(longest))
    cut_off_hz = narrower * cut_off(evenly, step_s)

    def kept(angle: FloatArray, wider: float = 1.0) -> FloatArray:
        """Share (m,) of a Butterworth filter, run there and back, at angles (m,) a sample."""
        of_nyquist = min(2.0 * wider * cut_off_hz * step_s, OBSERVATIONS.highest_of_nyquist)
        ratio = np.tan(angle / 2.0) / np.tan(np.pi * of_nyquist / 2.0)
        return np.asarray(1.0 / (1.0 + ratio ** (2 * OBSERVATIONS.low_pass_order)))

    def low_passed(values: FloatArray, slopes: int = 0, wider: float = 1.0) -> FloatArray:
        smooth = np.array(values, dtype=float) if slopes == 0 else np.zeros(values.shape)
        frayed = [(FRAYED, FRAYED), *[(0, 0)] * (values.ndim - 1)]
        for part in stretches:
            if part.stop - part.start >= OBSERVATIONS.fewest_in_stretch:
                own_s, grid_s = t_s[part], even_s(part)
                evenly = resampled(values[part], own_s, grid_s)
                for _ in range(slopes):
                    evenly = np.asarray(make_interp_spline(grid_s, evenly, SPLINE)(grid_s, 1))
                inner = evenly[FRAYED:-FRAYED]
                share = kept(np.pi * np.arange(len(inner)) / len(inner), wider)
                waves = dct(inner, axis=0) * share.reshape(-1, *[1] * (values.ndim - 1))
                passed = idct(waves, axis=0)
                smooth[part] = resampled(np.pad(passed, frayed, "edge"), grid_s, own_s)
        return smooth

    # Filtered last, as the force is: what a filter does where a stretch ends is then the same.
    read, order = (position, 1) if velocity is None else (velocity, 0)
    speed, rise = low_passed(read, order), low_passed(read, order + 1)
    turning = low_passed(read, order, OBSERVATIONS.turning_wider)
    settled = np.zeros(len(t_s), dtype=bool)
    periods = int(OBSERVATIONS.edge_periods / (cut_off_hz * step_s))
    edge = FRAYED + max(OBSERVATIONS.edge_rows, periods)
    shortest = max(OBSERVATIONS.fewest_in_stretch, OBSERVATIONS.edges_in_stretch * edge)
    for part in stretches:
        if part.stop - part.start >= shortest:
            settled[part.start + edge : part.stop - edge] = True
    noise = white_noise(position) * np.sqrt(8.0 * np.pi**2 / 3.0 * cut_off_hz**3 * step_s)
    top = float(np.quantile(np.abs(speed), OBSERVATIONS.top_speed_quantile))
    return Motion(
        low_passed(position), speed, rise, settled, cut_off_hz, turning, float(noise),
        max(top, 1e-300), low_passed, lambda angle: kept(angle) ** 2,
    )  # fmt: skip


def _uneven(t_s: FloatArray, step_s: float) -> bool:
    """Whether samples of one stretch are not taken at a steady rate."""
    off = np.abs(np.diff(t_s) - step_s)
    return bool(off.max(initial=0.0) > OBSERVATIONS.uneven * step_s)


def cut_off(position: FloatArray, step_s: float) -> float:
    """Frequency [Hz] above which the spectrum of a position (n,) is its noise."""
    count = len(position)
    spectrum = np.abs(np.fft.rfft((position - position.mean()) * np.hanning(count)))
    frequency = np.fft.rfftfreq(count, step_s)
    floor = float(np.median(spectrum[len(spectrum) // 2 :]))
    band = max(1, int(OBSERVATIONS.spectrum_band_hz / frequency[1])) if count > 2 else 1
    smooth = np.convolve(spectrum, np.ones(band) / band, "same")
    above = np.flatnonzero(smooth > OBSERVATIONS.above_noise * floor)
    lowest_hz, highest_hz = OBSERVATIONS.cut_off_hz
    edge = float(frequency[above[-1]]) if len(above) else lowest_hz
    return float(np.clip(edge, lowest_hz, min(OBSERVATIONS.cut_off_of_rate / step_s, highest_hz)))


def white_noise(position: FloatArray) -> float:
    """Standard deviation of noise without memory, from third differences."""
    third = np.diff(position, 3)
    return MAD_TO_SIGMA * float(np.median(np.abs(third))) / float(np.sqrt(20.0))
