"""What tracking is possible, against what a chain with those very effects does."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from deltactl.firmware_py.job_file import load_job
from deltactl.firmware_py.job_targets import kinematics_of
from deltactl.firmware_py.named_files import CONFIG_FOLDER
from deltactl.firmware_py.planner.plan import make_plan
from deltactl.firmware_py.program.coverage import coverage
from deltactl.firmware_py.program.includes import read_whole
from deltactl.firmware_py.program.totals import program_of
from deltactl.firmware_py.robot_file import load_robot
from deltactl.models.robot import EffectEntry, FoundBy
from deltactl.repair.limit import Limit, limit_of, limit_of_program, moved_by_sigma

JOB = CONFIG_FOLDER / "demo-heart.yaml"
STEP_RAD = np.deg2rad(0.0225)
ELBOW_M = 0.25


def limit(*effects: EffectEntry, job: str = "demo-heart.yaml") -> Limit | None:
    robot = load_robot(CONFIG_FOLDER / "zhao-2023.yaml").model_copy(update={"effects": effects})
    path = CONFIG_FOLDER / job
    asked = load_job(path)
    plan = make_plan(asked, robot, kinematics_of(asked, robot, path))
    return limit_of(plan, coverage(asked, robot, path))


def home(sigma_rad: float) -> EffectEntry:
    ends = (0.01 - 1.96 * sigma_rad, 0.01 + 1.96 * sigma_rad)
    return EffectEntry(
        effect="home_offset",
        component="motor1",
        parameters={"angle": 0.01},
        found=FoundBy(recordings=("survey.mcap",), on="2026-01-31", ci95={"angle": ends}),
    )


def test_a_sound_robot_is_limited_by_a_microstep() -> None:
    found = limit()
    assert found is not None
    assert 0.3 * STEP_RAD * ELBOW_M < found.rms_m < 1.5 * STEP_RAD * ELBOW_M
    assert (found.sizes_m, found.left_m) == (0.0, 0.0)


@pytest.mark.study
def test_a_size_half_as_well_known_opens_twice_as_much() -> None:
    once, twice = limit(home(2e-4)), limit(home(4e-4))
    assert once is not None
    assert twice is not None
    assert twice.sizes_m == pytest.approx(2.0 * once.sizes_m, rel=1e-2)
    # An arm that is off by an angle moves the platform by about its elbow's way.
    assert 0.3 < once.sizes_m / (2e-4 * ELBOW_M) < 2.0
    assert once.left_m == 0.0
    assert once.rms_m == pytest.approx(np.hypot(once.steps_m, once.sizes_m))


def lag(spread: dict[str, tuple[float, ...]]) -> EffectEntry:
    ends = {"time": (0.05, 0.09), "dead_time": (0.04, 0.08)}
    found = FoundBy(recordings=("survey.mcap",), on="2026-01-31", ci95=ends, spread=spread)
    parameters = {"time": 0.07, "dead_time": 0.06}
    return EffectEntry(
        effect="following_lag", component="motor1", parameters=parameters, found=found
    )


def test_a_lag_that_is_known_in_all_leaves_little_open() -> None:
    """Dead time and time constant make up for each other where they spread together."""
    alone = limit(lag({}))
    together = limit(lag({"time": (0.0102,), "dead_time": (-0.0102, 0.0005)}))
    assert alone is not None
    assert together is not None
    assert together.sizes_m < 0.3 * alone.sizes_m


def test_sizes_that_spread_together_move_the_way_that_their_bounds_leave() -> None:
    """A dead time of nothing only grows: then the time constant shrinks by as much."""
    found = lag({"time": (0.01,), "dead_time": (-0.01,)})
    found = found.model_copy(update={"parameters": {"time": 0.07, "dead_time": 0.0}})
    ((moved,),) = moved_by_sigma((found,))
    assert moved.parameters == pytest.approx({"time": 0.06, "dead_time": 0.01})


@pytest.mark.study
def test_a_size_at_its_bound_is_moved_away_from_it() -> None:
    ends = (np.pi - 0.2, np.pi + 0.1)
    wave = EffectEntry(
        effect="transmission_error",
        component="motor1",
        parameters={"amplitude": 0.005, "period": 0.6, "phase": np.pi - 0.05},
        found=FoundBy(recordings=("survey.mcap",), on="2026-01-31", ci95={"phase": ends}),
    )
    found = limit(wave)
    assert found is not None
    # A wave shifted by a small angle is off by its amplitude times that, RMS over its way.
    assert found.sizes_m == pytest.approx(0.005 * 0.3 / 3.92 * ELBOW_M / np.sqrt(2.0), rel=0.5)


def test_what_nothing_compensates_is_what_is_left() -> None:
    table = EffectEntry(effect="contact", component="platform", parameters={"height": -0.449})
    found = limit(table)
    assert found is not None
    assert found.left_m > 3.0 * found.steps_m
    assert found.rms_m > 0.9 * found.left_m


def test_a_network_that_does_not_know_leaves_the_effect() -> None:
    found = limit(home(0.0), job="heart.yaml")
    assert found is not None
    assert found.left_m == pytest.approx(0.01 * ELBOW_M, rel=0.5)


def test_a_path_in_arm_angles_has_no_targets_to_be_off() -> None:
    assert limit(job="survey.yaml") is None


def of_job(path: Path, *effects: EffectEntry) -> Limit | str:
    job = read_whole(path).job
    robot = load_robot(CONFIG_FOLDER / job.robot).model_copy(update={"effects": effects})
    return limit_of_program(program_of(path, robot), path)


@pytest.mark.study
def test_steps_are_limited_as_their_paths_are_each_by_its_targets(tmp_path: Path) -> None:
    path = tmp_path / "both.yaml"
    path.write_text(
        "name: both\nrobot: zhao-2023.yaml\ntiming: {mode: together, t_pwm_s: 0.006}\n"
        "inverse_kinematics: {kind: geometry}\nsteps:\n- include: circle.yaml\n"
        "- repeat: 2\n  steps:\n  - include: demo-heart.yaml\n- include: survey.yaml\n"
    )
    parts = [
        of_job(CONFIG_FOLDER / name, home(2e-4)) for name in ("circle.yaml", "demo-heart.yaml")
    ]
    both = of_job(path, home(2e-4))
    assert isinstance(both, Limit)
    squares = [one.sizes_m**2 for one in parts if isinstance(one, Limit)]
    assert min(squares) < both.sizes_m**2 < max(squares)


def test_where_no_limit_is_stated_the_reason_is() -> None:
    assert "arm angles" in str(of_job(CONFIG_FOLDER / "survey.yaml"))
    assert "servo drives" in str(of_job(CONFIG_FOLDER / "micro-circle.yaml"))
