"""What is read: a range sensor and its errors, when rows are taken, and what noise adds to them."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from scipy.signal import lfilter

from deltactl.proof.axis.commanded import Sizes
from deltactl.proof.axis.drives import play
from deltactl.proof.axis.motions import FloatArray, Motion

LONG_GAP_PERIODS = 60


@dataclass(frozen=True)
class Noise:
    """What one channel adds: `sigma` white or with the correlation `rho` from row to row.

    outliers: share of rows with an error of 8 to 40 sigma. count: step of the encoder or converter.
    """

    sigma: float
    rho: float = 0.0
    outliers: float = 0.0
    count: float = 0.0

    @property
    def scatter(self) -> float:
        """Standard deviation without outliers, rounding included."""
        return float(np.hypot(self.sigma, self.count / np.sqrt(12.0)))

    def read(self, clean: FloatArray, rng: np.random.Generator) -> FloatArray:
        """Readings of a noiseless signal (n,)."""
        white = rng.standard_normal(len(clean))
        white[1:] *= np.sqrt(1.0 - self.rho**2)
        read = clean + self.sigma * lfilter([1.0], [1.0, -self.rho], white)
        wild = rng.random(len(clean)) < self.outliers
        size = self.scatter * rng.uniform(8.0, 40.0, len(clean))
        read += np.where(wild, rng.choice([-1.0, 1.0], len(clean)) * size, 0.0)
        counted: FloatArray = self.count * np.round(read / self.count) if self.count else read
        return counted


@dataclass(frozen=True)
class Mess:
    """How untidy a log is.

    jitter: spread of the sampling instants, stamp: error of the stamps, both in periods. drop:
    share of rows that are missing; gaps: number of long ones. held: share of rows that repeat the
    reading before. clock_s: resolution of the stamps; of rows with the same stamp the first stays,
    as the refusal of such a table advises.
    """

    jitter: float = 0.0
    stamp: float = 0.0
    drop: float = 0.0
    gaps: int = 0
    held: float = 0.0
    clock_s: float = 0.0


@dataclass(frozen=True)
class Rows:
    """True instants, stamps, and for each row the row whose reading it shows; all (n,)."""

    true_s: FloatArray
    stamp_s: FloatArray
    shown: np.ndarray[tuple[int], np.dtype[np.intp]]

    @classmethod
    def drawn(cls, seconds: float, rate_hz: float, mess: Mess, rng: np.random.Generator) -> Rows:
        """Rows of a log of so many seconds, the first at a round time."""
        period = 1.0 / rate_hz
        count = int(seconds * rate_hz) - 2
        true_s = (1.0 + np.arange(count) + mess.jitter * rng.uniform(-0.5, 0.5, count)) * period
        stamp_s = true_s + mess.stamp * period * rng.uniform(-0.5, 0.5, count)
        if mess.clock_s:
            stamp_s = mess.clock_s * np.round(stamp_s / mess.clock_s)
        keep = rng.random(count) >= mess.drop
        for _ in range(mess.gaps):
            begin = int(rng.integers(0, max(count - LONG_GAP_PERIODS, 1)))
            keep[begin : begin + LONG_GAP_PERIODS] = False
        keep[1:] &= np.diff(np.maximum.accumulate(stamp_s)) > 0.0
        true_s, stamp_s = true_s[keep], stamp_s[keep]
        later = np.concatenate([[True], np.diff(np.maximum.accumulate(stamp_s)) > 0.0])
        true_s, stamp_s = true_s[later], stamp_s[later]
        shown = np.arange(len(true_s))
        held = rng.random(len(true_s)) < mess.held
        held[0] = False
        shown[held] = 0
        return cls(true_s, stamp_s, np.maximum.accumulate(shown))


def whitened(columns: FloatArray, noise: Noise) -> FloatArray:
    """Columns (n, k) as independent rows of unit noise see them."""
    innovation = noise.scatter * np.sqrt(1.0 - noise.rho**2)
    first = columns[:1] / noise.scatter
    later: FloatArray = (columns[1:] - noise.rho * columns[:-1]) / innovation
    return np.concatenate([first, later])


@dataclass(frozen=True)
class RangeSensor:
    """The motion is the true distance, never below the nearest that it can measure."""

    motion: Motion
    wander: FloatArray
    """Temperature over the same time, -1 to 1."""

    def clean(self, sizes: Sizes, rows_s: FloatArray, ideal: bool = False) -> FloatArray:
        """Noiseless ranges (n,) at the rows' true times."""
        motion = self.motion
        seen = motion.position
        if "hysteresis" in sizes:
            seen = play(seen, sizes["hysteresis"]["width"], 0.0)
        late_s = sizes.get("sensor_latency", {}).get("time", 0.0)
        seen = np.interp(rows_s - late_s, motion.t_s, seen)
        since_s = rows_s - rows_s[0]
        read = seen * sizes.get("sensor_scale", {}).get("scale", 1.0)
        read = read + sizes.get("sensor_offset", {}).get("offset", 0.0)
        read = read + sizes.get("sensor_crosstalk", {}).get("curvature", 0.0) * seen**2
        if "sensor_drift" in sizes:
            drift = sizes["sensor_drift"]
            read = read - drift["offset"] * np.expm1(-since_s / drift["time_constant"])
        if "temperature" in sizes:
            warm = np.interp(rows_s, motion.t_s, self.wander)
            read = read + sizes["temperature"]["size"] * warm
        if "stripes" in sizes:
            stripes = sizes["stripes"]
            read = read + stripes["size"] * np.sin(2.0 * np.pi * seen / stripes["period"])
        if "reflection" in sizes:
            bump = sizes["reflection"]
            read = read + bump["size"] * np.exp(-(((seen - bump["at"]) / bump["within"]) ** 2))
        return read
