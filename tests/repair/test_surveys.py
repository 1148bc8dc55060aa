"""Another survey follows where the intervals of what was found leave too much of the job open."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
import yaml

from deltactl.diagnosis.plants.delta.safe_poses import between
from deltactl.firmware_py.job_file import JobFile, load_job
from deltactl.firmware_py.job_targets import kinematics_of, path_of
from deltactl.firmware_py.named_files import CONFIG_FOLDER
from deltactl.firmware_py.paths.survey import LEAST_GAIN
from deltactl.firmware_py.planner.plan import home_counts, make_plan, plan_of
from deltactl.firmware_py.planner.stream import MotionStream
from deltactl.firmware_py.robot_file import load_robot
from deltactl.foundation.clock import NS_PER_S
from deltactl.models.linkage import Linkage, forward
from deltactl.models.robot import FloatArray
from deltactl.proof.motions import arm_angles
from deltactl.proof.robot.as_built import Body
from deltactl.recording.tables.flat import FlatRecording
from deltactl.recording.tables.flat_files import write_flat
from deltactl.repair.campaign import ROBOT
from deltactl.repair.heal_campaign import causes_of
from deltactl.repair.machine import faulty_robot
from deltactl.repair.played import Paths
from deltactl.repair.surveys import (
    ALMOST,
    MOST_ROBOT_S,
    POSE_S,
    RANGES,
    SURVEY_S,
    SWINGS_S,
    first_s,
    more_s,
    read_above,
    survey_in,
    survey_job,
)

JOB = CONFIG_FOLDER / "demo-heart.yaml"
SURVEYED_S = 240.0


def corrected(folder: Path, half_rad: float) -> Path:
    """A robot whose home of motor 2 was found to within this."""
    entry = {
        "effect": "home_offset",
        "component": "motor2",
        "parameters": {"angle": 0.01},
        "found": {
            "recordings": ["survey.mcap"],
            "on": "2026-11-22",
            "ci95": {"angle": [0.01 - half_rad, 0.01 + half_rad]},
        },
    }
    path = folder / "mine.yaml"
    text = (CONFIG_FOLDER / "zhao-2023.yaml").read_text()
    path.write_text(f"{text}\n{yaml.safe_dump({'effects': [entry]})}")
    return path


@pytest.mark.study
def test_wide_intervals_ask_for_more_and_narrow_ones_for_nothing(tmp_path: Path) -> None:
    some = more_s(JOB, Paths(JOB), corrected(tmp_path, 0.0010), SURVEYED_S, SURVEYED_S)
    assert 0.0 < some < MOST_ROBOT_S - SURVEYED_S
    assert more_s(JOB, Paths(JOB), corrected(tmp_path, 0.00005), SURVEYED_S, SURVEYED_S) == 0.0


@pytest.mark.study
def test_the_robot_moves_no_longer_than_ten_minutes(tmp_path: Path) -> None:
    wide = corrected(tmp_path, 0.01)
    assert 0.0 < more_s(JOB, Paths(JOB), wide, SURVEYED_S, 300.0) < MOST_ROBOT_S - 300.0
    assert more_s(JOB, Paths(JOB), wide, SURVEYED_S, MOST_ROBOT_S - 60.0) == 0.0


@pytest.mark.study
def test_noise_makes_the_first_survey_longer_within_bounds(tmp_path: Path) -> None:
    robot = corrected(tmp_path, 0.0001)
    quiet, usual, loud = (first_s(JOB, robot, noise_m) for noise_m in (1e-5, 1.5e-3, 1e-2))
    assert quiet <= usual <= loud
    assert (quiet, loud) == (120.0, 300.0)


@pytest.mark.parametrize("above_m", [(), (-0.53,)])
def test_a_survey_takes_its_time_also_where_there_is_little_room(
    above_m: tuple[float, ...],
) -> None:
    robot = load_robot(ROBOT)
    job = JobFile.model_validate(survey_in(150.0, robot, ROBOT, 2, above_m))
    plan = make_plan(job, robot, kinematics_of(job, robot, ROBOT))
    took_s = MotionStream(plan, home_counts(robot)).end_ns / NS_PER_S
    assert ALMOST * 150.0 <= took_s <= 150.0


def test_readings_while_something_was_in_the_way_are_left_out(tmp_path: Path) -> None:
    """And those within a second of it; commands are kept."""
    robot = load_robot(ROBOT)
    t_s = np.arange(0.0, 40.0, 0.02)
    angle_rad = np.deg2rad(np.interp(t_s, [0.0, 20.0, 40.0], [10.0, 60.0, 10.0]))
    steps = np.round(angle_rad / robot.drive.rad_per_step)
    columns = {f"steps_{motor}": steps for motor in (1, 2, 3)}
    columns |= {name: np.full(len(t_s), 0.2) for name in RANGES}
    path = tmp_path / "survey.csv.gz"
    write_flat(FlatRecording(t_s, columns), path)
    lowest_m = forward(Linkage.of(robot.geometry), np.full((1, 3), angle_rad.max())).position_m
    above_m = float(lowest_m[0, 2]) + 0.02
    table = read_above(robot, [above_m])(path)
    assert np.array_equal(table.column("steps_1"), steps)
    seen = np.isfinite(table.column("range_z"))
    assert seen[(t_s < 5.0) | (t_s > 35.0)].all()
    place_m = forward(Linkage.of(robot.geometry), angle_rad[:, None] + np.zeros(3)).position_m
    first_s, last_s = t_s[place_m[:, 2] <= above_m][[0, -1]]
    assert not seen[(t_s > first_s - SWINGS_S) & (t_s < last_s + SWINGS_S)].any()


def test_surveys_go_to_different_places(tmp_path: Path) -> None:
    robot_file = corrected(tmp_path, 0.0001)
    robot = load_robot(robot_file)
    ends = []
    for seed in (1, 2):
        job = tmp_path / f"survey-{seed}.yaml"
        job.write_text(yaml.safe_dump(survey_job(robot, robot_file, 5, seed)))
        assert load_job(job).path is not None
        ends.append(plan_of(job, robot).last_counts)
    assert ends[0] != ends[1]


def least_gain_of(body: Body, home_rad: FloatArray, angles_rad: FloatArray) -> float:
    """The smallest singular value over the upper arm along a survey, by the proof's own inverse.

    0 where a machine cannot be assembled, or where its inverse leads to other angles.
    """
    machine = Linkage(
        radius_m=body.base_radius_m - body.platform_radius_m,
        upper_arm_m=body.upper_arm_m,
        forearm_m=body.forearm_m,
        azimuth_rad=body.azimuth_rad,
        home_offset_rad=np.zeros(3),
    )
    true_rad = angles_rad + home_rad
    position_m = forward(machine, true_rad).position_m
    if np.isnan(position_m).any():
        return 0.0
    assert np.abs(arm_angles(position_m, body) - true_rad).max() < 1e-6
    step_m = 1e-6 * np.eye(3)
    slopes = [
        (arm_angles(position_m + d, body) - arm_angles(position_m - d, body)) / 2e-6 for d in step_m
    ]
    most = np.linalg.norm(np.stack(slopes, axis=-1), 2, axis=(-2, -1)).max()
    return float(1.0 / (most * body.upper_arm_m.mean()))


@pytest.mark.study
def test_the_platforms_of_drawn_robots_stay_held_in_the_surveys(tmp_path: Path) -> None:
    robot, poses, least = load_robot(ROBOT), round(SURVEY_S[1] / POSE_S), []
    for number in range(24):
        job = tmp_path / "survey.yaml"
        job.write_text(yaml.safe_dump(survey_job(robot, ROBOT, poses, 1 + number % 2)))
        drawn = faulty_robot(causes_of(5504, number), number).machine.robot
        along = between(path_of(load_job(job), robot).targets)
        least.append(least_gain_of(drawn.body, drawn.joints.home_rad, along))
    assert min(least) >= LEAST_GAIN
