"""The files in config/: what the papers say, and jobs that may run."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
import yaml

from deltactl.firmware_py.job_file import GeometryIk, JobFile, load_job
from deltactl.firmware_py.named_files import CONFIG_FOLDER, find
from deltactl.firmware_py.planner.plan import home_counts, plan_of
from deltactl.firmware_py.planner.stream import MotionStream
from deltactl.firmware_py.planner.summary import CheckSummary
from deltactl.firmware_py.program.building import make_program
from deltactl.firmware_py.program.includes import read_whole
from deltactl.firmware_py.program.totals import summarise_program
from deltactl.firmware_py.robot_file import RobotFile, load_robot
from deltactl.foundation.errors import LimitExceeded, UnreachablePoint
from deltactl.models.inverse_kinematics import GeometricInverse
from deltactl.models.linkage import Linkage, Status, forward
from deltactl.models.robot import KINDS
from deltactl.models.robot_files import load_delta, load_robot_model

FILES = sorted(CONFIG_FOLDER.glob("*.yaml"))
KIND = {path: yaml.safe_load(path.read_text(encoding="utf-8")).get("kind") for path in FILES}
ROBOTS = [path for path in FILES if KIND[path] == "delta"]
JOBS = [path for path in FILES if KIND[path] is None]


def name(path: Path) -> str:
    return path.stem


def dry_run(path: Path, robot: RobotFile | None = None) -> CheckSummary:
    """By geometry, whatever the job says: a network differs from it by less than a step."""
    whole = read_whole(path).job
    job = whole.model_copy(update={"inverse_kinematics": GeometryIk(kind="geometry")})
    robot = robot or load_robot(find(job.robot, beside=path))
    inverse = GeometricInverse(robot.geometry)
    return summarise_program(make_program(job, robot, lambda one: inverse), home_counts(robot))


def test_all_that_was_asked_for_is_there():
    assert {path.stem for path in ROBOTS} >= {
        "zhao-2023",
        "zhao-2023-as-printed",
        "uzunovic-2013",
    }
    assert {path.stem for path in JOBS} >= {"heart", "circle", "spiral", "survey"}


@pytest.mark.parametrize("path", ROBOTS, ids=name)
def test_a_robot_stands_at_home_and_is_the_same_for_the_diagnosis(path):
    robot = load_robot(path)
    home = np.deg2rad(robot.homing.angle_deg)
    assert forward(Linkage.of(robot.geometry), home).status == Status.OK
    model = load_delta(path)
    assert model.geometry == robot.geometry
    assert model.drive == robot.drive


@pytest.mark.parametrize("kind", KINDS)
def test_every_kind_of_machine_has_an_example(kind):
    assert any(load_robot_model(path).kind == kind for path in FILES if KIND[path] == kind)


@pytest.mark.parametrize("path", JOBS, ids=name)
def test_a_job_may_run_and_is_named_like_its_file(path):
    summary = dry_run(path)
    assert summary.job == path.stem
    assert summary.smallest_margin > 0.1


def test_zhao_2023_has_the_papers_numbers():
    robot = load_robot(CONFIG_FOLDER / "zhao-2023.yaml")
    geometry, masses = robot.geometry, robot.masses
    assert (geometry.base_radius_m, geometry.platform_radius_m) == (0.325, 0.075)
    assert masses is not None
    assert (masses.upper_arm_kg, masses.forearm_kg, masses.platform_kg) == (0.205, 0.153, 0.653)
    assert np.rad2deg(robot.drive.rad_per_step) == pytest.approx(360 / (1600 * 10))
    assert robot.limits.arm_deg == (-20.0, 110.0)
    assert robot.ranging.rate_hz == 50.0


@pytest.mark.parametrize(
    ("file", "share"), [("zhao-2023.yaml", 1.0), ("zhao-2023-as-printed.yaml", 0.012)]
)
def test_how_many_random_poses_can_be_assembled(file, share):
    """Note 1 on the papers: 1.2 % as printed, all of them with the lengths exchanged."""
    linkage = Linkage.of(load_robot(CONFIG_FOLDER / file).geometry)
    angles = np.deg2rad(np.random.default_rng(0).uniform(-20, 110, (20_000, 3)))
    made = (forward(linkage, angles).status == Status.OK).mean()
    assert made == pytest.approx(share, abs=0.002)


def test_the_printed_lengths_cannot_run_the_heart():
    printed = load_robot(CONFIG_FOLDER / "zhao-2023-as-printed.yaml")
    with pytest.raises(UnreachablePoint, match=r"heart: point 0: target .* out of reach"):
        dry_run(CONFIG_FOLDER / "heart.yaml", printed)


def test_uzunovic_2013_has_the_papers_numbers():
    robot = load_robot(CONFIG_FOLDER / "uzunovic-2013.yaml")
    assert robot.geometry.upper_arm_m == 0.040
    assert robot.geometry.forearm_m == 0.068
    assert robot.drive.kind == "servo"
    assert robot.drive.encoder_deg == 0.01
    assert robot.drive.loop_rate_hz == 10_000
    assert robot.drive.reference_bandwidth_radps == 1200.0
    assert (robot.drive.velocity_gain_1ps, robot.drive.position_gain_1ps2) == (100.0, 1000.0)
    # The paper's z reference starts at -0.07084 m with all joints at 30 degrees.
    home = forward(Linkage.of(robot.geometry), np.deg2rad(robot.homing.angle_deg)).position_m
    assert home == pytest.approx([0, 0, -0.0708], abs=6e-4)


def test_zhaos_curves_run_about_half_a_minute_inside_the_working_cylinder():
    for file in ("heart", "circle", "spiral"):
        summary = dry_run(CONFIG_FOLDER / f"{file}.yaml")
        job = load_job(CONFIG_FOLDER / f"{file}.yaml")
        assert job.timing.model_dump() == {"mode": "together", "t_pwm_s": 0.006}
        assert 20.0 < summary.duration_s < 60.0
        x, y, z = summary.box_m
        assert np.hypot(max(map(abs, x)), max(map(abs, y))) < 0.2
        assert -0.6 <= z[0] <= z[1] <= -0.35


def test_the_heart_is_what_the_shipped_network_runs():
    job: JobFile = load_job(CONFIG_FOLDER / "heart.yaml")
    assert job.inverse_kinematics.model_dump() == {"kind": "network", "file": "zhao-2023.tflite"}


def test_the_survey_draws_as_the_paper_does():
    job = load_job(CONFIG_FOLDER / "survey.yaml")
    assert job.path.model_dump()["angle_deg"] == (-20.0, 110.0)
    assert job.timing.model_dump()["t_pwm_s"] == 0.006


def test_the_heart_by_the_shipped_network_is_checked_and_streamed_alike():
    """The stream asks the network again, target by target, and must get the checked counts."""
    plan = plan_of(CONFIG_FOLDER / "heart.yaml")
    chunks = list(MotionStream(plan, home_counts(plan.robot)))
    counts = np.concatenate([chunk.reached.counts[~chunk.reached.left] for chunk in chunks])
    assert (counts == plan.first.lap.counts).all()
    by_geometry = GeometricInverse(plan.robot.geometry).angles_rad_many(plan.first.lap.targets)
    apart = np.abs(counts * plan.robot.drive.rad_per_step - by_geometry)
    assert np.rad2deg(apart.max()) < 0.5


def test_a_path_outside_what_the_network_was_trained_for_is_refused(tmp_path):
    text = (CONFIG_FOLDER / "heart.yaml").read_text(encoding="utf-8")
    (tmp_path / "low.yaml").write_text(text.replace("-0.45", "-0.64"), encoding="utf-8")
    with pytest.raises(LimitExceeded, match=r"heart: point 0: .* was trained for"):
        plan_of(tmp_path / "low.yaml")
