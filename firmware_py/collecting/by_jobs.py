"""The survey on a robot that runs jobs: the real one through its daemon, or the simulated chain.

Poses go out in jobs of some dozens with a rest at each; of the recording the rests are read.
"""

from __future__ import annotations

import json
from collections.abc import Callable
from pathlib import Path

import numpy as np

from deltactl.firmware_py.collecting.survey import DWELL_S, at_rest, survey_counts
from deltactl.firmware_py.controller.contract import JobResult
from deltactl.firmware_py.robot_file import RobotFile
from deltactl.foundation.errors import MotionError, RecordingError
from deltactl.foundation.plain_file import write_whole
from deltactl.models.training.dataset import (
    DataSettings,
    DataSetWriter,
    IntArray,
    Sample,
    load_dataset,
)
from deltactl.recording.reading.reader import read_run
from deltactl.recording.reading.run import Run

CHUNK = 50
JOB = "poses.yaml"
SETTLE_NS = 100_000_000
"""Readings of the first tenth of a second of a rest are left out."""
SPARE = 1.1
"""Poses drawn for each sample wanted: a sensor may not see some."""
RunJob = Callable[[Path], JobResult]
"""Runs a job file and records it; how it ended. A daemon keeps the recording in its own folder."""
Progress = Callable[[int], None]


def collect(
    folder: Path,
    robot: RobotFile,
    robot_path: Path,
    settings: DataSettings,
    samples: int,
    run: RunJob,
    progress: Progress,
) -> None:
    """Take samples until the data set has so many; goes on with one that was begun.

    Raises RecordingError or MotionError; what was taken before is kept.
    """
    counts = survey_counts(robot, int(SPARE * samples) + CHUNK, settings.seed)
    with DataSetWriter(folder, settings) as writer:
        next_pose = _after_last(folder, writer, counts) if writer.count < samples else 0
        while writer.count < samples and next_pose < len(counts):
            progress(writer.count)
            wanted = counts[next_pose : next_pose + min(CHUNK, samples - writer.count)]
            next_pose += len(wanted)
            job = folder / JOB
            _write_job(job, robot, robot_path, settings, wanted)
            result = run(job)
            if result.outcome != "done" or result.recording_error or result.recording is None:
                why = result.recording_error or result.why or result.outcome
                raise MotionError(
                    f"{job}: did not run to its end ({why}); the {writer.count} samples before "
                    "are kept, the same command goes on from there"
                )
            recording = Path(result.recording)
            writer.append(rests(read_run(recording), robot, wanted))
            if recording.parent.resolve() == folder.resolve():
                recording.unlink()
        progress(writer.count)
        if writer.count < samples:
            raise RecordingError(
                f"{folder}: the sensors saw only {writer.count} of {next_pose} poses; "
                "see 'deltactl status sensors'"
            )
    (folder / JOB).unlink(missing_ok=True)


def _after_last(folder: Path, writer: DataSetWriter, counts: IntArray) -> int:
    """Number of the pose after the last one kept. Raises RecordingError for a foreign one."""
    if not writer.count:
        return 0
    last = load_dataset(folder).counts[-1]
    found = np.flatnonzero((counts == last).all(axis=1))
    if not len(found):
        raise RecordingError(
            f"{writer.path}: its last sample is no pose of this survey; the file was changed, "
            "restore it or collect into another folder"
        )
    return int(found[-1]) + 1


def rests(run: Run, robot: RobotFile, counts: IntArray) -> list[Sample]:
    """One sample for each pose (n, 3) that all sensors saw, from the readings of its rest.

    Raises RecordingError for a pose that was not reached.
    """
    assert robot.sensors is not None
    t_ns = run.edges.t_ns
    starts = np.append(t_ns, run.end_ns)
    long = np.flatnonzero(np.diff(starts) >= int(0.8 * DWELL_S * 1e9))
    samples: list[Sample] = []
    for pose in counts:
        at = [i for i in long if (run.edges.counts[i] == pose).all()]
        if not at:
            raise RecordingError(
                f"{run.path}: pose {pose.tolist()} was not reached; look at the recording"
            )
        # A pose may be met twice; the later rest is the one that was asked for.
        low, high = starts[at[-1]] + SETTLE_NS, starts[at[-1] + 1]
        ranges_m = [
            sensor.distance_m[sensor.good & (sensor.t_ns >= low) & (sensor.t_ns < high)]
            for sensor in run.readings.values()
        ]
        position_m = at_rest(robot.sensors, ranges_m)
        if position_m is not None:
            samples.append((pose, position_m))
    return samples


def _write_job(
    path: Path, robot: RobotFile, robot_path: Path, settings: DataSettings, counts: IntArray
) -> None:
    angles_deg = np.degrees(counts * robot.drive.rad_per_step)
    # JSON is YAML too; the angles are those of whole steps.
    job = {
        "name": "survey",
        "robot": str(robot_path.resolve()),
        "path": {
            "shape": "joints",
            "angles_deg": np.round(angles_deg, 6).tolist(),
            "dwell_s": DWELL_S + SETTLE_NS * 1e-9,
        },
        "timing": {"mode": "together", "t_pwm_s": settings.t_pwm_s},
        "inverse_kinematics": {"kind": "geometry"},
    }
    try:
        write_whole(path, json.dumps(job, indent=1))
    except OSError as error:
        raise RecordingError(f"{path}: cannot be written ({error.strerror})") from error
