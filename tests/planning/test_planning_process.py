"""Plans made in a process of their own are those made here, within bounds, and cost nobody else."""

from __future__ import annotations

import os
import resource
import signal
import threading
import time
from collections.abc import Iterator
from pathlib import Path

import numpy as np
import pytest

from deltactl.firmware_py.controller.claim import Claim
from deltactl.firmware_py.file_access import FileAccess
from deltactl.firmware_py.named_files import CONFIG_FOLDER
from deltactl.firmware_py.planner.plan import home_counts
from deltactl.firmware_py.planner.stream import MotionStream
from deltactl.firmware_py.planning import process
from deltactl.firmware_py.planning.packed import pack, unpack
from deltactl.firmware_py.planning.prepared import InForce, Prepared, prepare_here
from deltactl.firmware_py.planning.process import PlanningProcess
from deltactl.firmware_py.robot_file import load_robot
from deltactl.foundation.errors import (
    ConfigError,
    DeltactlError,
    MissingFile,
    ServiceError,
    UnreachablePoint,
)

ROBOT_FILE = CONFIG_FOLDER / "zhao-2023.yaml"
ROBOT = InForce(load_robot(ROBOT_FILE), ROBOT_FILE, ROBOT_FILE.read_text())
JOBS = ("circle.yaml", "spiral.yaml", "survey.yaml")
ACCELERATED = """name: fast
robot: zhao-2023.yaml
path: {shape: circle, centre_m: [0.0, 0.0, -0.45], radius_m: 0.05}
timing: {mode: accelerated, speed_mps: 0.2}
inverse_kinematics: {kind: geometry}
repeats: 2
on_blind: warn
"""


@pytest.fixture(scope="module")
def planning() -> Iterator[PlanningProcess]:
    one = PlanningProcess(most_s=60.0)
    yield one
    one.close()


def motion(prepared: Prepared) -> list[tuple[object, ...]]:
    """Every tick and every target of the whole job."""
    chunks = MotionStream(prepared.plan, tuple(prepared.plan.first.lap.counts[0].tolist()))
    return [
        (chunk.ticks.due_ns.tolist(), chunk.ticks.steps.tolist(), chunk.reached.counts.tolist())
        for chunk in chunks
    ]


@pytest.mark.parametrize("name", [*JOBS, "fast"])
def test_a_plan_is_the_same_to_the_last_step(tmp_path: Path, name: str) -> None:
    job = CONFIG_FOLDER / name
    if name == "fast":
        job = tmp_path / "fast.yaml"
        job.write_text(ACCELERATED)
    here = prepare_here(job, ROBOT)
    there = unpack(pack(here), ROBOT, job)
    assert there.job_text == here.job_text
    assert there.plan.job.model_dump(exclude={"path"}) == here.plan.job.model_dump(exclude={"path"})
    assert there.plan.ramp_s == here.plan.ramp_s
    assert motion(there) == motion(here)


PLAY = """
effects:
- {effect: gear_backlash, component: motor1, parameters: {width: 0.004}}
- {effect: gear_backlash, component: motor3, parameters: {width: 0.003}}
"""


@pytest.mark.parametrize(
    "path", ["{shape: joints, angles_deg: [[40, 50, 60]]}", "{shape: straight, to_m: [0, 0, -0.5]}"]
)
def test_a_move_by_hand_keeps_its_speed(tmp_path: Path, path: str) -> None:
    job = tmp_path / "hand.yaml"
    own = ACCELERATED.splitlines()
    own = [f"path: {path}" if one.startswith("path:") else one for one in own]
    job.write_text("\n".join(one for one in own if not one.startswith("repeats:")) + "\n")
    here = prepare_here(job, ROBOT)
    there = unpack(pack(here), ROBOT, job)
    start = home_counts(ROBOT.robot)
    assert there.plan.ramp_s == here.plan.ramp_s
    ways = [MotionStream(one.plan, start).approach.duration_ns for one in (here, there)]
    assert ways[0] == ways[1]


def test_a_robot_with_play_that_is_compensated(tmp_path: Path) -> None:
    path = tmp_path / "play.yaml"
    path.write_text(ROBOT.text + PLAY)
    robot = InForce(load_robot(path), path, path.read_text())
    job = tmp_path / "job.yaml"
    job.write_text(ACCELERATED.replace("zhao-2023.yaml", "play.yaml"))
    here = prepare_here(job, robot)
    there = unpack(pack(here), robot, job)
    assert here.plan.preload_rad is not None
    np.testing.assert_array_equal(there.plan.preload_rad, here.plan.preload_rad)
    assert motion(there) == motion(here)


@pytest.mark.study
def test_through_the_process(planning: PlanningProcess, tmp_path: Path) -> None:
    job = tmp_path / "fast.yaml"
    job.write_text(ACCELERATED)
    there = planning.prepare(job, ROBOT)
    assert motion(there) == motion(prepare_here(job, ROBOT))
    assert not there.plan.first.lap.targets.flags.writeable  # a view, not a copy


def test_refusals_are_those_of_here(planning: PlanningProcess, tmp_path: Path) -> None:
    with pytest.raises(MissingFile, match="cannot be read"):
        planning.prepare(tmp_path / "none.yaml", ROBOT)
    job = tmp_path / "far.yaml"
    job.write_text(ACCELERATED.replace("radius_m: 0.05", "radius_m: 0.9"))
    with pytest.raises(UnreachablePoint) as there:
        planning.prepare(job, ROBOT)
    with pytest.raises(UnreachablePoint) as here:
        prepare_here(job, ROBOT)
    assert str(there.value) == str(here.value)


@pytest.mark.study
def test_the_robot_in_force_is_planned_for_not_the_one_on_the_disk(
    planning: PlanningProcess, tmp_path: Path
) -> None:
    path = tmp_path / "mine.yaml"
    path.write_text("broken: [")
    job = tmp_path / "job.yaml"
    job.write_text(ACCELERATED.replace("zhao-2023.yaml", "mine.yaml"))
    in_force = InForce(ROBOT.robot, path, ROBOT.text)
    assert planning.prepare(job, in_force).plan.robot is ROBOT.robot


@pytest.mark.study
def test_what_takes_too_long_is_ended_and_the_next_job_is_planned(tmp_path: Path) -> None:
    long = tmp_path / "long.yaml"
    text = (CONFIG_FOLDER / "survey.yaml").read_text()
    long.write_text("\n".join(_counted(line) for line in text.splitlines()))
    planning = PlanningProcess(most_s=2.0)
    try:
        with pytest.raises(ConfigError, match="planning takes longer than 2 s; split the job"):
            planning.prepare(long, ROBOT)
        planning._most_s = 60.0
        assert planning.prepare(CONFIG_FOLDER / "circle.yaml", ROBOT).plan.first is not None
    finally:
        planning.close()


@pytest.mark.study
@pytest.mark.parametrize("blocks", [True, False])
def test_a_robot_file_that_takes_too_long_is_refused_with_both_limits(
    monkeypatch: pytest.MonkeyPatch, tmp_path: Path, blocks: bool
) -> None:
    """By the clock where reading blocks, as on a lost network drive, else by processor time."""
    path = tmp_path / "mine.yaml"
    path.write_text(f"{ROBOT.text}\nmore: [{'1, ' * (0 if blocks else 300_000)}]\n")
    monkeypatch.setattr(process, "START_S", 0.75 if blocks else process.START_S)
    planning = PlanningProcess(most_read_s=0.25)
    in_all_s = 0.25 + process.START_S
    try:
        assert planning._next is not None
        if blocks:
            os.kill(planning._next._process.pid, signal.SIGSTOP)
        says = f"0.25 s of processor time, or {in_all_s:g} s in all"
        with pytest.raises(ConfigError, match=says):
            planning.read_robot(path, FileAccess())
        monkeypatch.setattr(process, "START_S", 60.0)
        planning._most_read_s = process.MOST_READ_S
        assert planning.read_robot(ROBOT_FILE, FileAccess()).robot == ROBOT.robot
    finally:
        planning.close()


@pytest.mark.study
def test_what_is_called_off_is_given_up_at_once(tmp_path: Path) -> None:
    """By whoever does not want it any more, before it begins and in the middle."""
    long = tmp_path / "long.yaml"
    text = (CONFIG_FOLDER / "survey.yaml").read_text()
    long.write_text("\n".join(_counted(line) for line in text.splitlines()))
    planning = PlanningProcess(most_s=60.0)
    try:
        for delay_s in (0.0, 1.0):
            claim = Claim()
            threading.Timer(delay_s, claim.call_off, ["cancelled"]).start()
            began_s = time.monotonic()
            with pytest.raises(DeltactlError):
                planning.prepare(long, ROBOT, claim)
            assert time.monotonic() - began_s < delay_s + 10.0  # planning would take a minute
        assert planning.prepare(CONFIG_FOLDER / "circle.yaml", ROBOT).plan.first is not None
    finally:
        planning.close()


def _counted(line: str) -> str:
    key, colon, rest = line.partition("count:")
    return f"{key}count: 1000000{rest[rest.index(',') :] if ',' in rest else ''}" if colon else line


@pytest.mark.study
def test_a_text_that_is_too_long_is_refused(tmp_path: Path) -> None:
    planning = PlanningProcess(most_s=60.0, most_bytes=1000)
    job = tmp_path / "long.yaml"
    job.write_text(ACCELERATED + "#" * 1000)
    try:
        with pytest.raises(ConfigError, match="is longer than 1,000 bytes"):
            planning.prepare(job, ROBOT)
    finally:
        planning.close()


def test_a_closed_planner_plans_nothing() -> None:
    planning = PlanningProcess()
    planning.close()
    with pytest.raises(ServiceError, match="closed"):
        planning.prepare(CONFIG_FOLDER / "circle.yaml", ROBOT)


@pytest.mark.parametrize("cut", [0, 10, 200])
def test_what_is_no_plan_is_refused(cut: int) -> None:
    content = pack(prepare_here(CONFIG_FOLDER / "circle.yaml", ROBOT))[:cut]
    with pytest.raises(ServiceError, match="cannot be read"):
        unpack(content, ROBOT, Path("x.yaml"))


def test_only_classes_of_a_plan_come_out() -> None:
    content = pack(prepare_here(CONFIG_FOLDER / "circle.yaml", ROBOT))
    with pytest.raises(ServiceError, match="cannot be read"):
        unpack(content.replace(b'"class": "Reach"', b'"class": "Popen"'), ROBOT, Path("x.yaml"))


def test_the_arrays_are_those_that_were_packed() -> None:
    here = prepare_here(CONFIG_FOLDER / "circle.yaml", ROBOT)
    there = unpack(pack(here), ROBOT, Path("x.yaml"))
    for name in ("targets", "counts", "rest", "dwell_s"):
        ours, theirs = getattr(here.plan.first.lap, name), getattr(there.plan.first.lap, name)
        assert ours.dtype == theirs.dtype
        np.testing.assert_array_equal(ours, theirs)


@pytest.mark.study
def test_a_large_job_costs_the_asking_process_a_small_part_of_the_work(tmp_path: Path) -> None:
    """In processor time, which other work on the machine does not change."""
    job = tmp_path / "much.yaml"
    poses = ",".join(f"[{30 + n % 7}.12345678, 31.{n:06d}, 32.12345678]" for n in range(20_000))
    head = ACCELERATED[: ACCELERATED.index("path:")]
    rest = ACCELERATED[ACCELERATED.index("inverse") : ACCELERATED.index("repeats")]
    together = "timing: {mode: together, t_pwm_s: 0.001}\n"
    job.write_text(f"{head}path: {{shape: joints, angles_deg: [{poses}]}}\n{together}{rest}")
    planning = PlanningProcess(most_s=60.0)
    try:
        its_s, ours_s = _child_s(), time.process_time()
        prepared = planning.prepare(job, ROBOT)
        ours_s, its_s = time.process_time() - ours_s, _child_s() - its_s
    finally:
        planning.close()
    assert len(prepared.plan.first.lap.counts) == 20_000
    assert its_s > 0.3  # or the share would say nothing
    assert ours_s < 0.1 * its_s


def _child_s() -> float:
    """Processor time of processes that were started here and have ended."""
    used = resource.getrusage(resource.RUSAGE_CHILDREN)
    return used.ru_utime + used.ru_stime
