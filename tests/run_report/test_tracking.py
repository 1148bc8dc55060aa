"""Tracking errors are exactly those that were put in, and only those on the path count."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
import pytest

from deltactl.firmware_py.run_report.reference import path_windows, targets_at
from deltactl.firmware_py.run_report.tracking import robot_of, track
from deltactl.foundation.errors import ConfigError
from deltactl.recording.reading.run import Run

MakeRun = Callable[..., Run]
MS = 1_000_000


def test_errors_are_those_put_in_and_only_on_the_path(recorded_run: MakeRun) -> None:
    run = recorded_run(truth_error_m=(0.001, -0.002, 0.003), range_error_m=(-0.004, 0.0, 0.005))
    found = track(run, robot_of(run))
    assert found.truth is not None
    assert found.measured is not None
    assert found.truth.rms_m == pytest.approx((0.001, 0.002, 0.003), abs=1e-8)
    assert found.truth.max_m == pytest.approx((0.001, 0.002, 0.003), abs=1e-8)
    assert found.measured.rms_m == pytest.approx((0.004, 0.0, 0.005), abs=1e-8)
    assert found.measured.samples == (60, 60, 60)


def test_error_is_position_minus_target(recorded_run: MakeRun) -> None:
    run = recorded_run(truth_error_m=(0.001, -0.002, 0.003))
    truth = track(run, robot_of(run)).truth
    assert truth is not None
    np.testing.assert_allclose(truth.error_m, [[0.001, -0.002, 0.003]] * 60, atol=1e-8)


def test_sensors_that_look_askew(recorded_run: MakeRun) -> None:
    """Positions come from all three ranges through the inverse of the sensors' directions."""
    c, s = 0.8, 0.6
    run = recorded_run(
        axes=[[c, s, 0.0], [-s, c, 0.0], [0.0, s, c]],
        range_error_m=(0.001, 0.002, 0.003),
        robot=(
            "kind: delta\nname: askew\n"
            "geometry: {base_radius_m: 0.325, platform_radius_m: 0.075, upper_arm_m: 0.25,"
            " forearm_m: 0.5}\n"
            "drive: {microsteps_per_rev: 1600, gear_ratio: 10}\n"
            "sensors:\n"
            f"  x: {{offset_m: 0.60, axis: [{c}, {s}, 0.0]}}\n"
            f"  y: {{offset_m: 0.60, axis: [-{s}, {c}, 0.0]}}\n"
            f"  z: {{offset_m: 0.90, axis: [0.0, {s}, {c}]}}\n"
        ),
        weak=frozenset({("z", 40)}),
    )
    measured = track(run, robot_of(run)).measured
    assert measured is not None
    assert measured.rms_m == pytest.approx((0.001, 0.002, 0.003), abs=1e-8)
    # z is seen through y and z, but x and y do not need the sensor that was weak.
    assert measured.samples == (60, 60, 59)


def test_sensors_read_one_after_another(recorded_run: MakeRun) -> None:
    """At 79 mm/s a third of a round is half a millimetre, which is no error of the robot."""
    run = recorded_run(stagger_ms=(0.0, 6.7, 13.3), range_error_m=(0.0, 0.001, 0.0))
    measured = track(run, robot_of(run)).measured
    assert measured is not None
    assert measured.max_m == pytest.approx((0.0, 0.001, 0.0), abs=1e-5)


def test_weak_and_silent_readings_are_left_out(recorded_run: MakeRun) -> None:
    run = recorded_run(
        weak=frozenset({("x", 30), ("x", 31), ("x", 5)}), silent=frozenset({("y", 40)})
    )
    measured = track(run, robot_of(run)).measured
    assert measured is not None
    assert measured.samples == (58, 59, 60)


def test_commanded_error_is_that_of_whole_steps(recorded_run: MakeRun) -> None:
    run = recorded_run()
    commanded = track(run, robot_of(run)).commanded
    assert commanded is not None
    # Half a step of 0.0225 degrees at 0.25 m is 49 um along the arm's circle.
    assert 1e-6 < max(commanded.max_m) < 2e-4


def test_windows(recorded_run: MakeRun) -> None:
    run = recorded_run(
        events=((10, "path_start"), (20, "path_end"), (20, "path_end"), (50, "path_start"))
    )
    assert path_windows(run) == ((200 * MS, 400 * MS), (1000 * MS, 1980 * MS))
    truth = track(run, robot_of(run)).truth
    assert truth is not None
    assert truth.samples == (61, 61, 61)


def test_a_path_never_begun_has_no_errors(recorded_run: MakeRun) -> None:
    run = recorded_run(events=())
    found = track(run, robot_of(run))
    assert found.windows_ns == ()
    assert found.truth is not None
    assert found.truth.as_json()["x"] == {"rms_m": None, "max_m": None, "samples": 0}


def test_what_is_not_recorded_is_not_compared(recorded_run: MakeRun) -> None:
    run = recorded_run(with_truth=False, with_readings=False)
    found = track(run, robot_of(run))
    assert found.truth is None
    assert found.measured is None
    assert [one.name for one in found.all()] == ["commanded"]


def test_targets_between_and_outside(recorded_run: MakeRun) -> None:
    run = recorded_run()
    middle = targets_at(run, np.array([-0.01, 0.41, 5.0]))
    np.testing.assert_allclose(middle[1], run.targets.position_m[20:22].mean(axis=0))
    assert np.isnan(middle[[0, 2]]).all()


def test_a_robot_file_that_is_none(recorded_run: MakeRun) -> None:
    with pytest.raises(ConfigError, match=r"drawn\.mcap \(robot file in it\):1"):
        robot_of(recorded_run(robot="nonsense"))
