"""Zhao's robot diagnosed and corrected from one short survey, with feedback and without.

The paper teaches a network 5000 poses, some days of robot time. Here the same as-built robot goes
to random angles for four minutes, is diagnosed blind, and its corrected file inverts the curves.
With feedback, the run is closed by repetition: readings of one run say where the feedback would
have stepped in, the next run has those steps, until the same steps come out again.
"""

from __future__ import annotations

import hashlib
from pathlib import Path
from typing import cast

import numpy as np

from deltactl.diagnosis.answer.corrected_robot import corrected_text
from deltactl.diagnosis.api import diagnose
from deltactl.drivers.ranging.contract import Gate, Reading
from deltactl.drivers.steps.contract import Counts, Ticks
from deltactl.firmware_py.compensation.remembering import Course, Remembering
from deltactl.firmware_py.feedback.feedback import Feedback
from deltactl.firmware_py.feedback.settings import FeedbackSettings
from deltactl.firmware_py.named_files import find
from deltactl.firmware_py.robot_file import RobotFile, load_robot
from deltactl.foundation.clock import NS_PER_S
from deltactl.foundation.plain_file import write_whole
from deltactl.models.calibrated_inverse import CalibratedInverse
from deltactl.models.robot import AXES, FloatArray
from deltactl.models.training.dataset import IntArray
from deltactl.proof.motions import survey
from deltactl.proof.ranging import read
from deltactl.proof.recorded import Machine, record
from deltactl.proof.robot.as_built import StepTrain
from deltactl.proof.robot.run import run
from deltactl.recording.tables.flat_files import write_flat
from deltactl.repair.played import Played
from deltactl.reproduction.zhao_2023.as_built import AsBuiltFile
from deltactl.reproduction.zhao_2023.tracking import (
    TRAINED_T_PWM_S,
    BoolArray,
    at_times,
    good,
    train_through,
)

SURVEY_T_PWM_S = 0.002
SEED = 3
PASSES = 8
BLOCK_S = 0.1
READINGS_HZ = 50.0


def corrected_robot(
    folder: Path, robot_name: str, machine: Machine, built: AsBuiltFile, seconds: float
) -> tuple[RobotFile, RobotFile]:
    """The robot file that one survey gives; kept in the folder. Raises RecordingError.

    And the one that --all gives, with what is tied or improbable as well (the second).
    """
    mark = hashlib.sha256(f"{built.mark} {seconds:g} sure".encode()).hexdigest()[:12]
    kept = folder / f"corrected-{mark}.yaml"
    if not kept.exists():
        folder.mkdir(parents=True, exist_ok=True)
        rng = np.random.default_rng([SEED, 1])
        recording = folder / f"survey-{mark}.csv.gz"
        write_flat(record(machine, survey(rng, seconds, SURVEY_T_PWM_S), rng), recording)
        accepted = find(robot_name)
        answer = diagnose([recording], accepted)
        everything = corrected_text(accepted, answer, all_of_them=True)
        write_whole(file_of_all(kept), everything)
        write_whole(kept, corrected_text(accepted, answer))
    return load_robot(kept), load_robot(file_of_all(kept))


def file_of_all(kept: Path) -> Path:
    """Beside a corrected robot file, what is written with --all."""
    return kept.with_stem(kept.stem + "-all")


def angles_of(robot: RobotFile, target_m: FloatArray) -> FloatArray:
    """Arm angles for targets, both (n, 3), with all that the robot file knows compensated."""
    mapped_rad = CalibratedInverse(robot).angles_rad_at_once(target_m)
    remembering = Remembering(robot)
    if not remembering.active:
        return mapped_rad
    moved = np.abs(np.diff(mapped_rad, axis=0)).max(axis=1, initial=0.0)
    t_s = np.concatenate([[0.0], np.cumsum(moved)]) / robot.drive.rad_per_step * TRAINED_T_PWM_S
    course = Course(t_s, mapped_rad)
    return remembering.angles_rad(course, remembering.before(course))


def with_feedback(
    machine: Machine, robot: RobotFile, target_m: FloatArray, counts: IntArray, t_pwm_s: float
) -> tuple[FloatArray, int]:
    """Where the platform truly was at each target, (n, 3) [m], and the passes that it took.

    As many as `PASSES`: the same steps did not come out again, and the run is not quite closed.
    """
    train, reached_s = train_through(counts, t_pwm_s)
    planned = _ticks(train)
    made = planned
    passes = 0
    while passes < PASSES:
        passes += 1
        path = _played(counts[0], made, reached_s, target_m, t_pwm_s)
        truth = run(machine.robot, cast(StepTrain, path))
        # The same noise every time: what differs is what the feedback did.
        rng = np.random.default_rng([SEED, 2])
        t_s = np.arange(0.0, path.seconds - 2.0 / READINGS_HZ, 1.0 / READINGS_HZ)
        ranges_m, status = read(machine.sensors, machine.noise, truth, t_s, rng)
        said = _trimmed(robot, counts[0], planned, t_s, ranges_m, good(ranges_m, status))
        if np.array_equal(said.due_ns, made.due_ns) and np.array_equal(said.steps, made.steps):
            break
        made = said
    return at_times(truth.t_s, truth.position_m, reached_s), passes


def _trimmed(
    robot: RobotFile,
    start: IntArray,
    planned: Ticks,
    t_s: FloatArray,
    ranges_m: FloatArray,
    fine: BoolArray,
) -> Ticks:
    """The planned ticks with what the feedback adds when it hears these readings."""
    feedback = Feedback(robot, FeedbackSettings(), cast(Counts, tuple(start.tolist())), 0)
    due, steps = [], []
    for begin_s in np.arange(0.0, planned.due_ns[-1] / NS_PER_S + BLOCK_S, BLOCK_S).tolist():
        first, last = (round(edge * NS_PER_S) for edge in (begin_s, begin_s + BLOCK_S))
        mine = (planned.due_ns >= first) & (planned.due_ns < last)
        block = feedback.trim(Ticks(planned.due_ns[mine], planned.steps[mine]), first)
        feedback.sent(block)
        due.append(block.due_ns)
        steps.append(block.steps)
        for row in np.flatnonzero((t_s >= begin_s) & (t_s < begin_s + BLOCK_S)).tolist():
            for column in np.flatnonzero(fine[row]).tolist():
                feedback.reading(_reading(column, t_s[row], ranges_m[row, column]))
    return Ticks(np.concatenate(due), np.concatenate(steps))


def _reading(column: int, t_s: float, range_m: float) -> Reading:
    t_ns = round(t_s * NS_PER_S)
    return Reading(AXES[column], t_ns, float(range_m), 0, 9, 10.0, 0.1, 0.003, 0, Gate.GOOD)


def _ticks(train: StepTrain) -> Ticks:
    steps = np.diff(train.counts, axis=0, prepend=train.counts[:1]).astype(np.int8)
    rows = np.flatnonzero(steps.any(axis=1))
    return Ticks(np.rint(rows * train.t_pwm_s * NS_PER_S).astype(np.int64), steps[rows])


def _played(
    start: IntArray, ticks: Ticks, reached_s: FloatArray, target_m: FloatArray, t_pwm_s: float
) -> Played:
    counts = start + np.cumsum(ticks.steps, axis=0, dtype=np.int64)
    return Played(
        due_s=np.concatenate([[0.0], ticks.due_ns / NS_PER_S]),
        counts=np.vstack([start[np.newaxis], counts]),
        target_s=reached_s,
        target_m=target_m,
        t_pwm_s=t_pwm_s,
    )
