"""What a simulated VL53L1X sees, how its samples scatter, and what can be made to go wrong with it.

The shapes are physics (return falls with the square of the distance, scatter with shot noise,
phase is time of flight in clocks of the PLL); the constants are chosen so that the figures
are those of a white target on a breakout board. Noise is repeatable from a seed.

Does not model: the SPAD array (always 128 SPADs), crosstalk of a cover glass, the field of
view (one flat target), temperature, or several targets.
"""

from __future__ import annotations

import math
import random
from dataclasses import dataclass
from typing import NamedTuple


@dataclass
class ChipFaults:
    """Knobs, all off at first; may be turned at any time. `clear` turns all off again."""

    nack_transfers: int = 0
    """So many of the next transfers are not acknowledged (errno 121)."""
    timeout_transfers: int = 0
    """So many of the next transfers time out (errno 110)."""
    io_error_transfers: int = 0
    """So many of the next transfers fail with an I/O error (errno 5)."""
    flip: tuple[int, int] | None = None
    """(byte, mask) to invert in what is read from it ..."""
    flip_reads: int = 0
    """... for so many reads that are long enough."""
    frozen: bool = False
    """Ranging goes on but the results, stream count included, no longer change."""
    raw_status: int | None = None
    """Status code of every sample."""
    stuck_m: float | None = None
    """Every sample is this distance, with a good status and a stream count that goes on."""
    held: bool = False
    """Every sample is the one before, in the same way: crosstalk of a dirty glass, say."""
    offset_m: float = 0.0
    """Added to every distance: the sensor has slipped on its mount."""
    scale: float = 1.0
    """Every distance is multiplied by this."""
    spike_rate: float = 0.0
    """This part of the samples, evenly spread, ..."""
    spike_m: float = 0.3
    """... is so much too far."""
    sda_stuck: bool = False
    """Holds SDA low: the whole bus times out. A reset (XSHUT low) frees it."""
    extra_boot_ns: int = 0
    """Boots so much later, silent (not acknowledging) ..."""
    deaf_firmware_ns: int = 0
    """... and then acknowledges so long before the firmware says that it has booted."""
    model_id: int | None = None
    """Answers with another model id (0x010F)."""
    no_osc_calibration: bool = False
    """RESULT__OSC_CALIBRATE_VAL reads 0."""
    silent_flag: bool = False
    """New samples no longer set the ready flag."""
    xshut_broken: bool = False
    """The XSHUT wire is open: the board's pull-up keeps it running."""
    unpowered: bool = False
    """No supply, or not there at all."""

    def clear(self) -> None:
        """Turn all knobs off."""
        self.__dict__.update(ChipFaults().__dict__)

    def shown_m(self, distance_m: float, sample: int, before_m: float) -> float:
        """What a sample of this number shows of a distance; `before_m` is what the last showed."""
        if self.stuck_m is not None:
            return self.stuck_m
        if self.held:
            return before_m
        spikes = int(sample * self.spike_rate) - int((sample - 1) * self.spike_rate)
        return distance_m * self.scale + self.offset_m + spikes * self.spike_m

    def transfer_errno(self) -> int | None:
        """The errno with which the next transfer fails, counting it; None when it does not."""
        if self.timeout_transfers > 0:
            self.timeout_transfers -= 1
            return 110
        if self.io_error_transfers > 0:
            self.io_error_transfers -= 1
            return 5
        if self.nack_transfers > 0:
            self.nack_transfers -= 1
            return 121
        return None

    def disturb(self, data: bytes) -> bytes:
        """Flip the bits asked for in what was read."""
        if self.flip is None or self.flip_reads <= 0 or len(data) <= self.flip[0]:
            return data
        self.flip_reads -= 1
        at, mask = self.flip
        return data[:at] + bytes([data[at] ^ mask]) + data[at + 1 :]


@dataclass(frozen=True, slots=True)
class RangeNoise:
    """How a sensor's samples scatter: AR(1) from sample to sample, plus rare outliers.

    `correlation` is that of neighbouring samples; `sigma_m` the standard deviation of each.
    """

    sigma_m: float = 0.0015
    correlation: float = 0.0
    outlier_rate: float = 0.0
    """Part of the samples."""
    outlier_m: float = 0.1
    """Standard deviation of an outlier."""
    seed: int = 1

    def source(self) -> NoiseSource:
        """A fresh sequence."""
        return NoiseSource(self)


class NoiseSource:
    """One error after the other; the sequence does not depend on when it is asked for."""

    def __init__(self, noise: RangeNoise):
        self._noise = noise
        self._random = random.Random(noise.seed)
        self._innovation = math.sqrt(1.0 - noise.correlation**2)
        self._state = self._random.gauss(0.0, 1.0)

    def next_m(self) -> float:
        """The error of the next sample at nominal light [m]."""
        noise, source = self._noise, self._random
        self._state = noise.correlation * self._state + self._innovation * source.gauss(0.0, 1.0)
        error_m = noise.sigma_m * self._state
        if noise.outlier_rate > 0.0 and source.random() < noise.outlier_rate:
            error_m += source.gauss(0.0, noise.outlier_m)
        return error_m


SIGNAL_MCPS_M2 = 4.0
"""Return rate of a white target at 1 m."""
LARGEST_RATE_MCPS = 200.0
NOMINAL_AMBIENT_MCPS = 0.1
SIGMA_MM = 9.0
"""Sigma = this * sqrt(signal + ambient) / signal for 8 ms of collection."""
SIGMA_COLLECTION_NS = 8e6
HALF_LIGHT_M_PER_NS = 0.149896229

RANGE_COMPLETE, SIGMA_FAIL, NO_TARGET, MIN_CLIP, PHASE_FAIL = 9, 6, 4, 8, 5
SPADS = 128


@dataclass
class Scene:
    """Light and target in front of a sensor; may be changed while it ranges."""

    ambient_mcps: float = NOMINAL_AMBIENT_MCPS
    reflectance: float = 1.0
    wrap_m: float | None = None
    """Distances come back modulo this, with a valid status (an aliased target)."""


class Limits(NamedTuple):
    """The chip's own thresholds, from its registers."""

    sigma_mm: float
    signal_mcps: float
    phase_clocks: float


class Seen(NamedTuple):
    """What a range found. `scatter` multiplies the noise that holds at nominal light."""

    distance_m: float
    raw_status: int
    signal_mcps: float
    ambient_mcps: float
    sigma_mm: float
    phase_clocks: float
    scatter: float


def look(
    scene: Scene, distance_m: float, collection_ns: float, pll_period_ns: float, limits: Limits
) -> Seen:
    """One range at a target; a distance that is not finite means that there is none."""
    if not math.isfinite(distance_m):
        return Seen(0.0, NO_TARGET, 0.0, scene.ambient_mcps, 0.0, 0.0, 1.0)
    shown_m = distance_m if scene.wrap_m is None else distance_m % scene.wrap_m
    reach_m = max(distance_m, 0.02)
    signal = min(SIGNAL_MCPS_M2 * scene.reflectance / reach_m**2, LARGEST_RATE_MCPS)
    ambient = scene.ambient_mcps
    exposure = math.sqrt(SIGMA_COLLECTION_NS / max(collection_ns, 1.0))
    sigma_mm = SIGMA_MM * math.sqrt(signal + ambient) / max(signal, 1e-3) * exposure
    phase = max(shown_m, 0.0) / (HALF_LIGHT_M_PER_NS * pll_period_ns)
    scatter = math.sqrt((signal + ambient) / (signal + NOMINAL_AMBIENT_MCPS))
    status = _status(signal, sigma_mm, phase, shown_m, limits)
    return Seen(shown_m, status, signal, ambient, sigma_mm, phase, scatter)


def _status(
    signal_mcps: float, sigma_mm: float, phase_clocks: float, shown_m: float, limits: Limits
) -> int:
    if signal_mcps < limits.signal_mcps:
        return NO_TARGET
    if phase_clocks > limits.phase_clocks:
        return PHASE_FAIL
    if shown_m <= 0.0:
        return MIN_CLIP
    if sigma_mm > limits.sigma_mm:
        return SIGMA_FAIL
    return RANGE_COMPLETE
