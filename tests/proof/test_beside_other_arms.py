"""Arms and axes with effort beside other tools: what they read, their fits, and the scorer."""

from __future__ import annotations

import gzip
import itertools
import json
from pathlib import Path
from typing import Any

import mujoco
import numpy as np
import pytest

from benchmarks.proofs.drawn_arms import tier_of
from benchmarks.proofs.moving_machines import fourier, machine
from benchmarks.rivals.arm_cases import numbers
from benchmarks.rivals.arm_signals import URDF, ArmRun, arm_finding, arm_signals, sureness
from benchmarks.rivals.arm_tools import _fitted, _load
from benchmarks.rivals.arms import scored_arms
from benchmarks.rivals.cases import Answers, Scored
from benchmarks.rivals.inverse_sysid import LOAD, _arm
from benchmarks.rivals.real import ARMS, write_real

LAG_S, LOAD_KG = 0.02, 0.8
FRICTIONLESS = 1
"""A seed whose drawing states no friction."""


@pytest.fixture(scope="module")
def moved(tmp_path_factory: pytest.TempPathFactory) -> ArmRun:
    """An arm whose last link is heavier, and whose elbow's effort acts late; MuJoCo moves it."""
    folder = tmp_path_factory.mktemp("arm")
    rng = np.random.default_rng(FRICTIONLESS)
    own = machine(rng, gantry=False)
    (folder / URDF).write_text(own.urdf())
    spec = mujoco.MjSpec.from_file(str(folder / URDF))
    spec.body(own.tip).mass += LOAD_KG
    model = spec.compile()
    model.opt.disableflags |= int(mujoco.mjtDisableBit.mjDSBL_LIMIT)
    data, motion, effort = mujoco.MjData(model), fourier(rng, own, 20.0), []
    for q, v, a in zip(motion.at, motion.speed, motion.change, strict=True):
        data.qpos, data.qvel, data.qacc = q, v, a
        mujoco.mj_inverse(model, data)
        effort.append(data.qfrc_inverse.copy())
    efforts = np.array(effort)
    efforts[:, 2] = np.interp(motion.t_s + LAG_S, motion.t_s, efforts[:, 2])
    head = ",".join(["t", *(f"{name}_{n}" for name in ("theta", "effort") for n in range(1, 7))])
    with gzip.open(folder / "recording.csv.gz", "wt") as text:
        table = np.column_stack([motion.t_s, motion.at, efforts])[::10]
        np.savetxt(text, table, "%.9g", ",", header=head, comments="")
    robot = {"joints": list(own.joints), "effort_gain": [1.0] * 6}
    return arm_signals(folder / "recording.csv.gz", robot)


def test_the_inverse_dynamics_leave_nothing_of_an_arm_with_its_load_and_its_lag(
    moved: ArmRun,
) -> None:
    plant = _arm(moved)
    hidden = {("payload", moved.tip): LOAD_KG, ("following_lag", "elbow"): LAG_S}
    # The load is where the link's own centre is, and turns with as much as its mass brings.
    model = plant.model
    at = model.body_ipos[-1]
    for name, size in zip(LOAD[1:4], LOAD_KG * at, strict=True):
        hidden[name, moved.tip] = size
    spread = LOAD_KG * (at @ at * np.eye(3) - np.outer(at, at))
    for name, (row, column) in zip(
        LOAD[4:], ((0, 0), (0, 1), (1, 1), (0, 2), (1, 2), (2, 2)), strict=True
    ):
        hidden[name, moved.tip] = spread[row, column]

    def typical(values: dict[tuple[str, str], float]) -> np.ndarray[Any, Any]:
        return np.asarray(np.sqrt(np.mean(plant.misses(values) ** 2, axis=0)))

    healthy, known = typical({}), typical(hidden)
    assert (known[:5] < 0.02 * healthy[:5]).all()
    del hidden["following_lag", "elbow"]
    assert typical(hidden)[2] > 5.0 * known[2]


def test_a_size_that_a_drawing_leaves_open_is_no_name(moved: ArmRun) -> None:
    usual = float(np.sqrt(np.mean(moved.effort[moved.rows, 1] ** 2)))
    one = ("effort_offset", "shoulder")
    assert sureness(moved, one, 0.03 * usual, 1e-3 * usual) > 4.0
    assert sureness(moved, one, 0.01 * usual, 1e-3 * usual) < 4.0
    assert sureness(moved, one, 0.03 * usual, 0.01 * usual) < 4.0
    assert sureness(moved, ("joint_friction", "shoulder"), -0.3 * usual, 1e-3 * usual) < 0.0


def test_the_textbook_weighs_joints_by_what_they_leave() -> None:
    rng = np.random.default_rng(3)
    shape = (4000, 2)
    columns = [np.zeros(shape), rng.standard_normal(shape)]
    columns[0][:, 0] = 1.0
    noise = rng.standard_normal(shape) * [0.1, 10.0]
    terms, errors = _fitted(0.5 * columns[0] + 2.0 * columns[1] + noise, columns)
    assert np.abs(terms - [0.5, 2.0]) == pytest.approx([0.0, 0.0], abs=4.0 * float(errors.max()))
    assert errors == pytest.approx([0.1 / np.sqrt(4000.0)] * 2, rel=0.1)


def test_errors_of_a_load_grow_with_what_it_leaves() -> None:
    rng = np.random.default_rng(5)
    columns, covariance = rng.standard_normal((20, 3)), np.diag(np.full(20, 1e-4))
    exact = columns @ np.array([1.0, -2.0, 0.5])
    (terms, errors), (_, wider) = (
        _load(exact + size * rng.standard_normal(20), columns, covariance) for size in (0.01, 0.1)
    )
    assert terms == pytest.approx([1.0, -2.0, 0.5], abs=4.0 * float(errors.max()))
    assert wider[0] > 5.0 * errors[0]


def _scored(hidden: list[dict[str, Any]], findings: list[dict[str, Any]]) -> Scored:
    verdict = "explained" if findings else "nothing_missing"
    answer = {"diagnosis": {"verdict": verdict, "findings": findings}, "failure": None,
              "seconds": 1.0, "heldout": None}  # fmt: skip
    truth = {"case": "arm_0001", "answers": hidden}
    return scored_arms([truth], Answers({"arm_0001": answer}, 1.0))[0]


def test_a_name_of_an_arm_counts_with_its_joint() -> None:
    line = {"effect": "joint_friction", "where": "elbow", "parameter": "torque", "size": 2.0}
    right = _scored([line], [arm_finding("joint_friction", "elbow", 2.1, 0.2)])
    assert (right.right, right.sizes, right.false) == (True, [True], None)
    elsewhere = _scored([line], [arm_finding("joint_friction", "roll", 2.1, 0.2)])
    assert (elsewhere.right, elsewhere.sizes) == (False, [])
    both = [arm_finding("joint_friction", "elbow", 2.5, 0.2), arm_finding("inertia", "pan", 1, 0.1)]
    assert (_scored([line], both).right, _scored([line], both).sizes) == (False, [False])


def test_a_name_of_a_healthy_arm_is_a_false_claim() -> None:
    assert _scored([], [arm_finding("inertia", "pan", 1.0, 0.1)]).false
    assert _scored([], []).false is False


def test_drawn_arms_are_healthy_or_have_a_fault_with_a_name() -> None:
    healthy, faulty = (
        list(itertools.islice(numbers(tiers), 6)) for tiers in (("none",), ("single", "pair"))
    )
    assert {tier_of(number) for number in healthy} == {"none"}
    assert {tier_of(number) for number in faulty} == {"single", "pair"}


def test_a_real_arm_is_written_with_its_urdf_and_no_answer(tmp_path: Path, moved: ArmRun) -> None:
    own = tmp_path / "given" / "arm"
    own.mkdir(parents=True)
    (own / "six.urdf").write_bytes(moved.urdf.read_bytes())
    (own / "recording.csv.gz").write_bytes((moved.urdf.parent / "recording.csv.gz").read_bytes())
    joints = ", ".join(moved.joints)
    (own / "robot.yaml").write_text(
        f"kind: chain\nname: six\nmodel: six.urdf\njoints: [{joints}]\n"
        "effort_gain: [1, 2, 1, 1, 1, 1]\n"
    )
    (own / "expected.json").write_text(json.dumps({"recording.csv.gz": {"expected": []}}))
    known, skipped = write_real(tmp_path / "given", tmp_path / "cases", ARMS)
    assert not skipped
    case = tmp_path / "cases" / known[0]["case"]
    run = arm_signals(case / "recording.csv.gz", json.loads((case / "robot.json").read_text()))
    assert run.effort[:, 1] == pytest.approx(2.0 * moved.effort[:, 1])
    assert "expected.json" not in {file.name for file in case.iterdir()}
