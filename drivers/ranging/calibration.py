"""Offset of one distance sensor from readings at a known distance."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np

from deltactl.drivers.ranging.contract import Gate, RangingSensors, Reading
from deltactl.foundation.clock import NS_PER_S, Clock, ns
from deltactl.foundation.errors import SensorFault
from deltactl.foundation.scatter import MAD_TO_SIGMA

FloatArray = np.ndarray[Any, np.dtype[np.float64]]

LARGEST_OFFSET_MM = 60.0
"""The VL53L1X is good to 25 mm untrimmed, cover glass and mounting add some; more is a mistake."""
LARGEST_SPREAD_MM = 15.0
"""Standard deviation that a still, flat target does not exceed."""
PATIENCE = 3.0
"""Give up after this many times the time that the readings should take."""


@dataclass(frozen=True, slots=True)
class OffsetCalibration:
    """What a calibration found. Half of the readings give the offset, the other half test it."""

    axis: str
    readings: int
    true_distance_m: float
    offset_before_mm: float
    offset_after_mm: float
    """What to put into `ranging.offsets_mm`."""
    uncertainty_mm: float
    """Standard error of the offset (readings taken as correlated over five samples)."""
    spread_mm: float
    error_before_mm: float
    """Mean error of the testing half with the old offset."""
    error_after_mm: float
    """The same with the new one."""
    warning: str
    """Why the result should not be used; empty when it looks sound."""
    applied: bool = False
    """Always: what to put into the robot file is for its owner to enter."""

    def says(self) -> str:
        """The result in one line."""
        return (
            f"sensor {self.axis} at {self.true_distance_m:.3f} m: offset"
            f" {self.offset_before_mm:+.1f} -> {self.offset_after_mm:+.1f} mm"
            f" (+-{self.uncertainty_mm:.1f}), mean error {self.error_before_mm:+.1f} ->"
            f" {self.error_after_mm:+.1f} mm over {self.readings} readings"
            "; nothing was changed (dry run)"
        )


def calibrate_offset(
    sensors: RangingSensors,
    clock: Clock,
    axis: str,
    true_distance_m: float,
    offset_before_mm: float,
    rate_hz: float,
    readings: int = 200,
) -> OffsetCalibration:
    """Average `readings` good readings of a still target at `true_distance_m` from sensor `axis`.

    Polls the sensors itself, so nothing else may. Raises SensorFault when too
    few good readings come, ValueError for fewer than 20 readings.
    """
    if readings < 20:
        raise ValueError(f"a calibration takes 20 readings or more (got {readings})")
    found = _collect(sensors, clock, axis, rate_hz, readings)
    raw_mm = np.array([reading.distance_m for reading in found]) * 1e3 - offset_before_mm
    learn_mm, test_mm = raw_mm[::2], raw_mm[1::2]
    true_mm = true_distance_m * 1e3
    offset_mm = round(true_mm - _mean_without_outliers(learn_mm), 2)
    spread_mm = float(np.std(raw_mm))
    warning = _warning(offset_mm, spread_mm)
    return OffsetCalibration(
        axis=axis,
        readings=len(found),
        true_distance_m=true_distance_m,
        offset_before_mm=offset_before_mm,
        offset_after_mm=offset_mm,
        uncertainty_mm=float(spread_mm / np.sqrt(len(learn_mm) / 5.0)),
        spread_mm=spread_mm,
        error_before_mm=float(np.mean(test_mm) + offset_before_mm - true_mm),
        error_after_mm=float(np.mean(test_mm) + offset_mm - true_mm),
        warning=warning,
    )


def _collect(
    sensors: RangingSensors, clock: Clock, axis: str, rate_hz: float, wanted: int
) -> list[Reading]:
    good: list[Reading] = []
    refused: dict[str, int] = {}
    give_up_ns = clock.now_ns() + ns(PATIENCE * wanted / rate_hz)
    while len(good) < wanted:
        for reading in sensors.poll():
            if reading.axis != axis:
                continue
            if reading.gate is Gate.GOOD:
                good.append(reading)
            else:
                refused[reading.gate.value] = refused.get(reading.gate.value, 0) + 1
        if clock.now_ns() >= give_up_ns:
            raise SensorFault(_too_few(axis, len(good), wanted, refused))
        clock.sleep_until_ns(clock.now_ns() + round(NS_PER_S / rate_hz / 2))
    return good[:wanted]


def _too_few(axis: str, good: int, wanted: int, refused: dict[str, int]) -> str:
    why = ", ".join(f"{count} by {gate}" for gate, count in sorted(refused.items())) or "none came"
    return (
        f"sensor {axis} gave only {good} good readings of {wanted} (refused: {why}):"
        " put a flat, light target in front of it and keep it still"
    )


def _mean_without_outliers(values_mm: FloatArray) -> float:
    """Mean of what lies within four robust standard deviations (1 mm at least) of the median."""
    middle = np.median(values_mm)
    robust_mm = max(MAD_TO_SIGMA * float(np.median(np.abs(values_mm - middle))), 1.0)
    return float(np.mean(values_mm[np.abs(values_mm - middle) <= 4.0 * robust_mm]))


def _warning(offset_mm: float, spread_mm: float) -> str:
    if abs(offset_mm) > LARGEST_OFFSET_MM:
        return (
            f"an offset of {offset_mm:+.1f} mm is not a sensor's (up to {LARGEST_OFFSET_MM:g} mm):"
            " measure the true distance again, from the sensor's face"
        )
    if spread_mm > LARGEST_SPREAD_MM:
        return f"the readings scatter by {spread_mm:.1f} mm: keep the target still"
    return ""
