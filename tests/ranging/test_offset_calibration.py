"""Calibration of a sensor's offset at a known distance."""

from __future__ import annotations

import pytest

from deltactl.drivers.fakes.ranging_bench import RangingBench
from deltactl.drivers.fakes.vl53l1x_scene import RangeNoise
from deltactl.drivers.ranging.calibration import OffsetCalibration, calibrate_offset
from deltactl.drivers.settings import RangingSettings
from deltactl.foundation.errors import SensorFault

NOISE = RangeNoise(sigma_m=0.003, correlation=0.3, outlier_rate=0.02, outlier_m=0.05, seed=5)


def _calibrate(
    bench: RangingBench, axis: str, true_m: float, **kwargs: object
) -> OffsetCalibration:
    index = "xyz".index(axis)
    return calibrate_offset(
        bench.bank,
        bench.clock,
        axis,
        true_m,
        bench.settings.offsets_mm[index],
        bench.settings.rate_hz,
        **kwargs,
    )


@pytest.fixture
def noisy() -> RangingBench:
    made = RangingBench(RangingSettings(offsets_mm=(5.0, 0.0, -3.0)), noise=NOISE)
    made.bank.start()
    return made


@pytest.mark.parametrize("axis", ["x", "y", "z"])
def test_the_offset_is_what_was_missing(noisy: RangingBench, axis: str) -> None:
    """Targets stand 12 mm further than the sensors see."""
    true_m = noisy.true_m[axis] + 0.012
    found = _calibrate(noisy, axis, true_m, readings=400)
    assert found.offset_after_mm == pytest.approx(12.0, abs=4 * found.uncertainty_mm)
    assert found.uncertainty_mm < 2.0
    assert abs(found.error_after_mm) < 2.0 < abs(found.error_before_mm)
    assert not found.warning


def test_nothing_changes_unless_it_is_asked_for(noisy: RangingBench) -> None:
    before = [r.distance_m for r in noisy.run(2.0) if r.axis == "x"]
    found = _calibrate(noisy, "x", noisy.true_m["x"])
    assert not found.applied
    assert "dry run" in found.says()
    after = [r.distance_m for r in noisy.run(2.0) if r.axis == "x"]
    mean = [sum(distances) / len(distances) for distances in (before, after)]
    assert mean[1] == pytest.approx(mean[0], abs=0.002)


def test_an_offset_that_no_sensor_has_is_warned_of(noisy: RangingBench) -> None:
    found = _calibrate(noisy, "y", 0.9)
    assert "not a sensor's" in found.warning
    assert not found.applied


def test_a_moving_target_is_noticed(noisy: RangingBench) -> None:
    chip = noisy.chips["y"]
    chip._distance_m = lambda start, end: 0.4 + 0.05 * (end % 1_000_000_000) * 1e-9
    found = _calibrate(noisy, "y", 0.42)
    assert "keep the target still" in found.warning


def test_no_target_is_said_with_the_reasons(noisy: RangingBench) -> None:
    noisy.true_m["y"] = float("inf")
    with pytest.raises(SensorFault, match=r"sensor y gave only 0 good readings of 200 .*by status"):
        _calibrate(noisy, "y", 0.5)


def test_too_few_readings_are_refused(noisy: RangingBench) -> None:
    with pytest.raises(ValueError, match="20 readings or more"):
        _calibrate(noisy, "y", 0.5, readings=5)
