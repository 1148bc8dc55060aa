"""Another survey follows where the intervals of what was found leave too much of the job open."""

from __future__ import annotations

from pathlib import Path

import yaml

from deltactl.firmware_py.job_file import load_job
from deltactl.firmware_py.named_files import CONFIG_FOLDER
from deltactl.firmware_py.planner.plan import plan_of
from deltactl.firmware_py.robot_file import load_robot
from deltactl.repair.surveys import MOST_ROBOT_S, first_s, more_s, survey_job

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


def test_wide_intervals_ask_for_more_and_narrow_ones_for_nothing(tmp_path: Path) -> None:
    some = more_s(JOB, corrected(tmp_path, 0.0010), SURVEYED_S, SURVEYED_S)
    assert 0.0 < some < MOST_ROBOT_S - SURVEYED_S
    assert more_s(JOB, corrected(tmp_path, 0.00005), SURVEYED_S, SURVEYED_S) == 0.0


def test_the_robot_moves_no_longer_than_ten_minutes(tmp_path: Path) -> None:
    wide = corrected(tmp_path, 0.01)
    assert 0.0 < more_s(JOB, wide, SURVEYED_S, 300.0) < MOST_ROBOT_S - 300.0
    assert more_s(JOB, wide, SURVEYED_S, MOST_ROBOT_S - 60.0) == 0.0


def test_noise_makes_the_first_survey_longer_within_bounds(tmp_path: Path) -> None:
    robot = corrected(tmp_path, 0.0001)
    quiet, usual, loud = (first_s(JOB, robot, noise_m) for noise_m in (1e-5, 1.5e-3, 1e-2))
    assert quiet <= usual <= loud
    assert (quiet, loud) == (120.0, 300.0)


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
