"""Deltas beside other tools: their own kinematics, a printer's calibration, and the scorer."""

from __future__ import annotations

import json
from pathlib import Path
from typing import Any

import mujoco
import numpy as np
import pytest

from benchmarks.rivals.cases import Answers, Scored
from benchmarks.rivals.delta_sysid import _changed, _pose
from benchmarks.rivals.delta_tools import by_klipper, finding, off, recording
from benchmarks.rivals.deltas import robot_values, scored_deltas, write_bodies, write_deltas
from deltactl.proof.cases import RECORDING, Case, assemble, write_blind

LENGTH = "forearm_length arm3"


@pytest.fixture(scope="module")
def longer(tmp_path_factory: pytest.TempPathFactory) -> tuple[Case, Path]:
    """A delta of which one forearm has another length, in a survey of a minute."""
    folder = tmp_path_factory.mktemp("delta")
    rng = np.random.default_rng(46)
    case = assemble(0, "single", ["forearm_length"], rng, "survey", seconds=60.0)
    write_blind(case, folder, 46)
    return case, folder


def _entry(case: Case) -> tuple[str, float]:
    line = case.truth()["answers"][0]
    return f"{line['effect']} {line['where']}", line["parameters"]["length_error"]


@pytest.mark.study
def test_the_other_kinematics_leave_only_the_noise_of_what_is_hidden(
    longer: tuple[Case, Path],
) -> None:
    case, folder = longer
    entry, size = _entry(case)
    run = recording(folder / RECORDING, robot_values())

    def typical(values: dict[str, float]) -> float:
        return float(1.4826 * np.median(np.abs(off(run, values))))

    noise = float(np.hypot(case.machine.noise.sigma_m, 1e-3 / np.sqrt(12.0)))
    assert typical({entry: size}) < 1.1 * noise
    assert typical({}) > 1.2 * noise


@pytest.mark.study
def test_a_calibration_of_a_printer_moves_to_a_length_and_fits(
    longer: tuple[Case, Path],
) -> None:
    case, folder = longer
    run = recording(folder / RECORDING, robot_values())
    _, values = by_klipper(run)
    entry, size = _entry(case)
    explained = np.median(np.abs(off(run, values)))
    assert explained < 1.05 * np.median(np.abs(off(run, {entry: size})))


def _scored(line: dict[str, Any], findings: list[dict[str, Any]]) -> Scored:
    truth = {"case": "case_0001", "answers": [line] if line else [], "sigma": 0.002,
             "bound": {"length_error": [1e-4]}}  # fmt: skip
    verdict = "explained" if findings else "nothing_missing"
    answer = {"diagnosis": {"verdict": verdict, "findings": findings}, "failure": None,
              "seconds": 1.0, "heldout": 0.002}  # fmt: skip
    return scored_deltas([truth], Answers({"case_0001": answer}, 1.0))[0]


def test_a_name_of_a_delta_counts_with_its_place() -> None:
    line = {"effect": "forearm_length", "where": "arm3", "parameters": {"length_error": 0.004}}
    right = _scored(line, [finding(LENGTH, 0.0039, 0.0002)])
    assert (right.right, right.sizes, right.false) == (True, [True], None)
    assert right.over_bound == [pytest.approx(1.0)]
    elsewhere = _scored(line, [finding("forearm_length arm1", 0.0039, 0.0002)])
    assert (elsewhere.right, elsewhere.sizes) == (False, [])
    needless = _scored(line, [finding(LENGTH, 0.0035, 0.0002), finding("base_radius frame", 1, 1)])
    assert (needless.right, needless.sizes) == (False, [False])
    assert not _scored(line, []).right


def test_a_name_of_a_healthy_delta_is_a_false_claim() -> None:
    assert _scored({}, [finding(LENGTH, 0.0039, 0.0002)]).false
    assert _scored({}, []).false is False


@pytest.mark.study
def test_half_of_the_deltas_are_healthy_and_no_file_says_what_is_hidden(tmp_path: Path) -> None:
    truths = write_deltas(2, 904, tmp_path)
    assert [bool(truth["answers"]) for truth in truths] == [False, True]
    for truth in truths:
        own = tmp_path / truth["case"]
        names = {file.name for file in own.iterdir()}
        assert names == {"recording.csv.gz", "holdout.csv.gz", "robot.yaml", "robot.json"}
        assert json.loads((own / "robot.json").read_text()) == robot_values()


def _gap_m(model: mujoco.MjModel, pose: np.ndarray) -> float:
    data = mujoco.MjData(model)
    data.qpos[:] = pose
    mujoco.mj_kinematics(model, data)
    loops = [f"{arm}{side}" for arm in "123" for side in "ab"]
    ends, anchors = (
        np.array([data.site(f"{name}_{loop}").xpos for loop in loops])
        for name in ("rod_end", "anchor")
    )
    return float(np.abs(ends - anchors).max())


def test_the_loops_of_the_simulated_robot_are_closed_and_a_length_opens_one(
    tmp_path: Path,
) -> None:
    write_bodies(tmp_path / "robot.xml")
    spec = mujoco.MjSpec.from_file(str(tmp_path / "robot.xml"))
    model, robot = spec.compile(), robot_values()
    pose = _pose(model, np.array([0.6, 0.9, 0.7]), robot)
    assert _gap_m(model, pose) < 1e-6
    for entry in (LENGTH, "upper_arm_length arm3", "base_radius frame"):
        assert _gap_m(_changed(spec.copy(), {entry: 0.004}, robot), pose) > 1e-3
