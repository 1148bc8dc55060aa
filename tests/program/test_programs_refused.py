"""What is wrong anywhere in a job of steps is said before anything moves, with its place."""

from __future__ import annotations

from pathlib import Path

import pytest

from deltactl.firmware_py.planning.packed import pack, unpack
from deltactl.firmware_py.planning.prepared import InForce, prepare_here
from deltactl.firmware_py.program.instructions import Leaf, Move
from deltactl.firmware_py.program.totals import check_job
from deltactl.firmware_py.robot_file import load_robot
from deltactl.foundation.errors import ConfigError, DeltactlError
from tests.program.conftest import HEAD, Write

POINT = "  - path: {shape: points, points_m: [[0.0, 0.0, -0.3]]}\n"


@pytest.mark.parametrize(
    ("steps", "says"),
    [
        (POINT + "  - set: {griper: on}\n",
         "steps.1.set: 'griper' is not in 'outputs' of robot 'gripper-delta'; did you mean"),
        (POINT + "  - wait_for: {input: part, within_s: 1}\n",
         "steps.1.wait_for: 'part' is not in 'inputs.named'"),
        (POINT + f"  - repeat: 2\n    steps: [{{{POINT.strip()[2:].replace('-0.3', '-0.9')}}}]\n",
         "steps.1.steps.0: steps: point 0: target (0, 0, -0.9) m is out of reach"),
        ("  - path: {shape: way, legs: [{to_m: [0, 0, -0.3]}]}\n",
         "steps.0.path.start_m: is missing"),
        (POINT + "  - path: {shape: way, legs: [{to_m: [0.03, 0, -0.3], centre_m: [0.1, 0]}]}\n",
         "steps.1: legs.0: centre_m must be equally far"),
        ("  - include: steps.yaml\n", "steps.yaml:7: steps.0.include: steps.yaml includes itself"),
        ("  - include: picks.yaml\n", "did you mean 'pick.yaml'"),
        ("  - include: ../secret.yaml\n", "name a file beside this job"),
        ("  - include: /etc/secret.yaml\n", "name a file beside this job"),
        ("  - include: other.yaml\n", "other.yaml:2: robot: is not gripper-delta.yaml"),
        ("  - include: wrong.yaml\n", "wrong.yaml:2: shap: unknown key"),
        ("  - wait_s: -1\n", "steps.yaml:7: steps.0.wait_s:"),
        ("  - sett: {gripper: on}\n", "steps.yaml:7:"),
        ("  - wait_for: {input: part_there}\n", "'within_s' is missing"),
    ],
)  # fmt: skip
def test_mistakes_are_named_with_their_place(write: Write, steps: str, says: str) -> None:
    path = write(steps)
    path.with_name("other.yaml").write_text(HEAD.replace("gripper-delta", "zhao-2023")
                                            + "steps: [{wait_s: 1}]\n")  # fmt: skip
    path.with_name("wrong.yaml").write_text("name: wrong\nshap: [1]\n")
    with pytest.raises(DeltactlError) as error:
        check_job(path)
    assert says in str(error.value)
    assert "\n" not in str(error.value.args[0])


def test_a_job_has_a_path_or_steps(write: Write) -> None:
    path = write(POINT)
    path.write_text(path.read_text() + "path: {shape: points, points_m: [[0.0, 0.0, -0.3]]}\n")
    with pytest.raises(ConfigError, match="give either 'path' or 'steps'"):
        check_job(path)
    path.write_text(HEAD)
    with pytest.raises(ConfigError, match="give either 'path' or 'steps'"):
        check_job(path)


def test_contradictions_come_with_the_other_mistakes(write: Write) -> None:
    path = write(POINT)
    head = HEAD.replace("accelerated, speed_mps: 0.3", "together, t_pwm_s: 0.006")
    way = "path: {shape: way, legs: [{to_m: [0.01, 0.0, -0.3], speed_mps: 0.1}]}\n"
    path.write_text(head + way + "colour: red\n")
    with pytest.raises(ConfigError) as error:
        check_job(path)
    mistakes = [str(one) for one in error.value.args]
    assert len(mistakes) == 3
    for said in ("colour: unknown key", "path: start_m is missing", "need timing mode accelerated"):
        assert any(said in one for one in mistakes)


def test_mistakes_of_all_files_come_at_once(write: Write) -> None:
    """Those of the second included file came only once the first was right."""
    path = write("  - include: first.yaml\n  - repeat: 2\n    steps: [{include: second.yaml}]\n")
    first, second = path.with_name("first.yaml"), path.with_name("second.yaml")
    first.write_text(HEAD + "colour: red\nsteps: [{include: third.yaml}, {include: steps.yaml}]\n")
    second.write_text(HEAD + "steps: [{wait_s: -1}, {set: {griper: on}}]\n")
    path.with_name("third.yaml").write_text("name: [\n")
    robot = path.with_name("gripper-delta.yaml")
    robot.write_text(robot.read_text() + "weight: 3\n")
    path.write_text(path.read_text() + "size: 1\n")
    with pytest.raises(ConfigError) as error:
        check_job(path)
    mistakes = [str(one) for one in error.value.args]
    for name in ("steps", "first", "second", "third", "gripper-delta"):
        assert any(f"{name}.yaml:" in one for one in mistakes), name
    assert len(mistakes) == len(set(mistakes))


def test_jobs_that_include_each_other_for_ever_are_refused(write: Write) -> None:
    path = write("  - include: b.yaml\n")
    path.with_name("b.yaml").write_text(HEAD + "steps: [{include: steps.yaml}]\n")
    with pytest.raises(
        ConfigError, match=r"b\.yaml:6: steps\.0\.include: steps\.yaml includes itself"
    ):
        check_job(path)


def test_a_program_comes_whole_out_of_the_planning_process(folder: Path) -> None:
    robot_file = folder / "gripper-delta.yaml"
    robot = InForce(load_robot(robot_file), robot_file, robot_file.read_text())
    job = folder / "pick-and-place.yaml"
    here = prepare_here(job, robot)
    there = unpack(pack(here), robot, job)

    def told(leaf: Leaf) -> object:
        return leaf.plan.first.lap.counts.tolist() if isinstance(leaf, Move) else leaf

    assert [told(leaf) for leaf in there.program.leaves()] == [
        told(leaf) for leaf in here.program.leaves()
    ]
    assert there.job_text == here.job_text
    assert len(list(there.program.plans())) == 3  # planned once, however often they are followed
