"""The survey on the as-built robot: pose after pose, at rest, through its sensors; resumable."""

from __future__ import annotations

import json
from collections.abc import Callable, Iterator
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from deltactl.firmware_py.collecting.survey import DWELL_S, at_rest, settings_of, survey_counts
from deltactl.firmware_py.robot_file import RobotFile
from deltactl.foundation.errors import RecordingError, UnreachablePoint
from deltactl.foundation.plain_file import write_whole
from deltactl.models.robot import FloatArray, Sensors
from deltactl.models.training.dataset import DataSetWriter, IntArray, Sample
from deltactl.proof.ranging import read
from deltactl.proof.recorded import RATE_HZ, Machine
from deltactl.proof.robot.run import Truth
from deltactl.reproduction.zhao_2023.as_built import AsBuiltFile, machine_of
from deltactl.reproduction.zhao_2023.settling import SettlingRobot

STATE = "state.json"
BLOCK = 100
"""Samples between two writes."""
SPARE = 1.1
"""Poses drawn for each sample wanted: in a few the robot as it was built jams."""
SENSOR_STREAM = 1
Progress = Callable[[int], None]


@dataclass
class Survey:
    """The robot somewhere in its survey; `drawn` poses were tried."""

    machine: Machine
    robot: SettlingRobot
    sensors: Sensors
    counts: IntArray
    seed: int
    drawn: int = 0

    def take(self) -> Iterator[Sample]:
        """Samples, one pose after another; poses in which the robot jams are left out."""
        while self.drawn < len(self.counts):
            counts = self.counts[self.drawn]
            rng = np.random.default_rng([self.seed, SENSOR_STREAM, self.drawn])
            self.drawn += 1
            try:
                position_m = self.robot.move(counts)
            except UnreachablePoint:
                continue
            seen_m = measure(self.machine, self.sensors, position_m, rng)
            if seen_m is not None:
                yield counts, seen_m


def collect(
    folder: Path,
    robot: RobotFile,
    built: AsBuiltFile,
    samples: int,
    seed: int,
    progress: Progress,
    block: int = BLOCK,
) -> int:
    """Take samples until the data set has so many; how many poses jammed.

    Goes on with a data set that was begun; the same samples come out whether or not it was
    interrupted. Raises RecordingError when they cannot be written.
    """
    settings = settings_of(robot, "as-built", seed, built.mark)
    assert robot.sensors is not None
    machine = machine_of(built, robot)
    counts = survey_counts(robot, int(SPARE * samples) + 20, seed)
    home = np.rint(np.radians(robot.homing.angle_deg) / robot.drive.rad_per_step).astype(int)
    survey = Survey(machine, SettlingRobot(machine.robot, home), robot.sensors, counts, seed)
    with DataSetWriter(folder, settings) as writer:
        _resume(folder, survey, writer)
        source = survey.take()
        while writer.count < samples:
            progress(writer.count)
            wanted = min(block, samples - writer.count)
            taken = [sample for _, sample in zip(range(wanted), source, strict=False)]
            if not taken:
                raise RecordingError(f"{folder}: only {writer.count} poses could be taken")
            writer.append(taken)
            _save(folder, survey, writer.count)
        progress(writer.count)
        return survey.drawn - writer.count


def measure(
    machine: Machine, sensors: Sensors, position_m: FloatArray, rng: np.random.Generator
) -> FloatArray | None:
    """What the sensors make of a platform at rest for DWELL_S, (3,) [m] in the robot's frame."""
    t_s = np.arange(0.0, DWELL_S, 1.0 / RATE_HZ)
    grid_s = np.array([0.0, 0.5 * DWELL_S, DWELL_S])
    still = Truth(grid_s, np.repeat(position_m[None], 3, axis=0), np.zeros((3, 3)), 0.0)
    ranges_m, status = read(machine.sensors, machine.noise, still, t_s, rng)
    return at_rest(sensors, [ranges_m[status[:, k] == 0, k] for k in range(3)])


def _save(folder: Path, survey: Survey, samples: int) -> None:
    state = {"samples": samples, "drawn": survey.drawn, "robot": survey.robot.state()}
    try:
        write_whole(folder / STATE, json.dumps(state))
    except OSError as error:
        raise RecordingError(
            f"{folder}: cannot be written ({error.strerror}); what was taken before is kept, "
            "the same command goes on from there"
        ) from error


def _resume(folder: Path, survey: Survey, writer: DataSetWriter) -> None:
    """Samples behind the last saved state are taken again: their robot is not known.

    Without a state (power cut before the first, a copy of the two files of the data set) the
    survey is gone through from its beginning, and what is there already is left as it is.
    """
    path = folder / STATE
    if not path.exists():
        for _ in zip(range(writer.count), survey.take(), strict=False):
            pass
        return
    try:
        state = json.loads(path.read_text(encoding="utf-8"))
        samples, survey.drawn = int(state["samples"]), int(state["drawn"])
        survey.robot.restore(state["robot"])
    except (ValueError, KeyError, IndexError, OSError) as error:
        raise RecordingError(
            f"{path}: cannot be read ({error}); delete it, and the same command goes through the "
            "survey again to where it was"
        ) from error
    if samples > writer.count:
        raise RecordingError(
            f"{writer.path}: has {writer.count} whole samples where {samples} were written; "
            "it was changed, collect into another folder"
        )
    writer.keep(samples)
