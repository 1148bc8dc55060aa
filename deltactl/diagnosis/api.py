"""`deltactl diagnose` as a plain function."""

from __future__ import annotations

import json
from collections.abc import Callable, Sequence
from functools import partial
from pathlib import Path

from deltactl.diagnosis.admission.another_kind import of_another_kind, refuse_several_motors
from deltactl.diagnosis.admission.excerpt import excerpt, excerpts, most_rows, thinned
from deltactl.diagnosis.admission.exchanged_arms import refuse_exchanged_arms
from deltactl.diagnosis.admission.joint_ranges import (
    check_arm_angles,
    far_for_a_joint,
    steps_of_degrees,
)
from deltactl.diagnosis.admission.robot_match import check_belongs
from deltactl.diagnosis.admission.sensor_ranges import far_for_a_sensor
from deltactl.diagnosis.admission.step_counts import check_steps
from deltactl.diagnosis.answer.known import known_of
from deltactl.diagnosis.answer.records import Diagnosis
from deltactl.diagnosis.estimation.side_by_side import only_here
from deltactl.diagnosis.pipelines.lone_machine import diagnose_axis
from deltactl.diagnosis.pipelines.nonlinear import diagnose_model
from deltactl.diagnosis.pipelines.servo_robot import diagnose_servo_robot, is_servo_run
from deltactl.diagnosis.plants.delta.model import DeltaModel
from deltactl.diagnosis.plants.delta.next_runs import next_runs
from deltactl.diagnosis.plants.delta.safe_poses import MotionLimits
from deltactl.diagnosis.report.sizes import with_units
from deltactl.diagnosis.report.summary import left_out_line, told
from deltactl.foundation.errors import MissingColumns, RecordingError
from deltactl.foundation.plain_file import write_whole
from deltactl.foundation.process import one_thread, rarely_collected
from deltactl.foundation.strict_yaml import Document
from deltactl.models.robot import DeltaRobot, RobotModel
from deltactl.models.robot_files import load_with_effects
from deltactl.recording.tables.flat import FlatRecording
from deltactl.recording.tables.flat_files import read_flat

Progress = Callable[[str], None]


def diagnose(
    recordings: Sequence[Path],
    robot: Path,
    holdout: Sequence[Path] = (),
    json_out: Path | None = None,
    progress: Progress = lambda _: None,
    read: Callable[[Path], FlatRecording] | None = None,
    thorough: bool = False,
) -> Diagnosis:
    """Diagnose recordings of one robot; writes the contract's JSON when asked.

    `read` turns a file into columns, for tables of others (`observations.column_mapping`). Of
    recordings too long to be worked on stretches are used (`admission.excerpt`).
    thorough: go on beyond the limit of work (`estimation.budget`).
    A damaged file of several is left out, which the answer says; `recordings` are the others.
    Raises ConfigError, MissingFile or RecordingError, one line each.
    """
    belief = load_with_effects(robot)
    progress("reading")
    most = most_rows(belief)

    def kept(path: Path) -> FlatRecording:
        return excerpt(read(path) if read else read_flat(path, progress), most)

    used, damaged = _readable(recordings, kept)
    held_out, damaged_too = _readable(holdout, kept)
    answer = diagnose_recordings(
        belief, [one for _, one in used], [one for _, one in held_out], progress,
        MotionLimits.of(Document.read(robot).data), thorough,
    )  # fmt: skip
    left_out = [*damaged, *damaged_too]
    update: dict[str, object] = {
        "robot": belief.name,
        "recordings": [str(path) for path, _ in used],
        "left_out": left_out,
        "says": [*answer.says, *map(left_out_line, left_out)],
    }
    if (plan := answer.next_experiment) is not None:
        # The robot's name is that of no file: the job has to run as it stands.
        job = plan.job | {"robot": str(robot.resolve())}
        update["next_experiment"] = plan.model_copy(update={"job": job})
    answer = answer.model_copy(update=update)
    if json_out is not None:
        write_whole(json_out, json.dumps(answer.to_json(), indent=1) + "\n")
    return answer


def _readable(
    paths: Sequence[Path], kept: Callable[[Path], FlatRecording]
) -> tuple[list[tuple[Path, FlatRecording]], list[str]]:
    """Those that can be read, and why the others cannot. Raises RecordingError where none can."""
    found, damaged = [], []
    for path in paths:
        try:
            found.append((path, kept(path)))
        except RecordingError as error:
            if len(paths) == 1:
                raise
            damaged.append(error)
    if damaged and not found:
        raise damaged[0]
    return found, [" ".join(str(error).split()) for error in damaged]


@one_thread
@rarely_collected
def diagnose_recordings(
    belief: RobotModel,
    recordings: Sequence[FlatRecording],
    holdout: Sequence[FlatRecording] = (),
    progress: Progress = lambda _: None,
    motion_limits: MotionLimits | None = None,
    thorough: bool = False,
) -> Diagnosis:
    """The same for recordings in memory. motion_limits: for the run that is proposed."""
    if not recordings:
        raise RecordingError("no recording was given")
    recordings = excerpts(recordings, most_rows(belief))
    holdout = excerpts(holdout, most_rows(belief))
    for recording in (*recordings, *holdout):
        check_steps(belief, recording, motion_limits)
        check_arm_angles(belief, recording)
        refuse_exchanged_arms(belief, recording)
        refuse_several_motors(belief, recording)
    try:
        answer = _diagnosed(
            belief, recordings, holdout, only_here(progress), motion_limits, thorough
        )
    except MissingColumns as error:
        raise _of_another_kind(error, belief, [*recordings, *holdout]) from None
    doubts = [
        one
        for recording in recordings
        for one in (
            steps_of_degrees(belief, recording)
            or far_for_a_joint(belief, recording)
            or far_for_a_sensor(belief, recording)
        )
    ]
    says = [*doubts, *answer.says] if answer.says else []
    known = known_of(belief, [Path(recording.source) for recording in recordings])
    update = {"thinned": thinned(recordings), "doubts": doubts, "says": says, "known": known}
    return told(with_units(answer.model_copy(update=update), belief))


def _diagnosed(
    belief: RobotModel,
    recordings: Sequence[FlatRecording],
    holdout: Sequence[FlatRecording],
    progress: Progress,
    motion_limits: MotionLimits | None,
    thorough: bool,
) -> Diagnosis:
    """The answer without words, by the kind of robot."""
    if not isinstance(belief, DeltaRobot):
        return diagnose_axis(belief, recordings, holdout, progress)
    if is_servo_run(belief, [*recordings, *holdout]):
        return diagnose_servo_robot(belief, recordings, holdout, progress, motion_limits, thorough)
    try:
        model = DeltaModel(belief, recordings)
        held_out = [DeltaModel(belief, [recording]) for recording in holdout]
        progress("do recording and robot file belong together")
        for recording in (*recordings, *holdout):
            check_belongs(belief, recording)
        rad_per_step = belief.drive.rad_per_step if belief.drive else 0.0
        runs = partial(next_runs, model, motion_limits)
        return diagnose_model(model, rad_per_step, held_out, progress, runs, thorough)
    except RecordingError as error:
        raise _with_source(error, [*recordings, *holdout]) from None


def _of_another_kind(
    error: MissingColumns, belief: RobotModel, recordings: Sequence[FlatRecording]
) -> MissingColumns:
    """The same, saying which kind of machine the recording that it is about looks like."""
    for recording in recordings:
        if recording.source == error.source:
            return of_another_kind(error, belief, recording)
    return error


def _with_source(error: RecordingError, recordings: Sequence[FlatRecording]) -> RecordingError:
    """The same, saying which recordings it is about."""
    sources = [recording.source for recording in recordings]
    if any(source in str(error) for source in sources):
        return error
    return RecordingError(f"{', '.join(sources)}: {error}")
