"""`deltactl diagnose` as a plain function."""

from __future__ import annotations

import json
from collections.abc import Callable, Sequence
from pathlib import Path

from deltactl.diagnosis.admission.admit import Progress, admit
from deltactl.diagnosis.admission.excerpt import most_rows, thinned
from deltactl.diagnosis.answer.assembly import known_of
from deltactl.diagnosis.answer.records import Diagnosis
from deltactl.diagnosis.pipelines.by_machine import diagnosed
from deltactl.diagnosis.plants.delta.safe_poses import MotionLimits
from deltactl.diagnosis.report.in_words import in_words
from deltactl.diagnosis.report.screen import sentences
from deltactl.diagnosis.report.sizes import with_units
from deltactl.foundation.errors import RecordingError
from deltactl.foundation.plain_file import write_whole
from deltactl.foundation.process import one_thread, rarely_collected
from deltactl.foundation.release import own_version
from deltactl.foundation.strict_yaml import Document
from deltactl.models.effects.units_in_use import said_in
from deltactl.models.robot import RobotModel
from deltactl.models.robot_files import with_effects_in
from deltactl.recording.tables.excerpt import excerpt
from deltactl.recording.tables.flat import FlatRecording
from deltactl.recording.tables.flat_files import read_flat


def diagnose(
    recordings: Sequence[Path | str],
    robot: Path | str | Document,
    holdout: Sequence[Path | str] = (),
    json_out: Path | None = None,
    progress: Progress = lambda _: None,
    read: Callable[[Path], FlatRecording] | None = None,
) -> Diagnosis:
    """Diagnose recordings of one robot; writes the contract's JSON when asked.

    robot: its file, or one that was read already.
    `read` turns a file into columns, for tables of others (`observations.column_mapping`). Of
    recordings too long to be worked on stretches are used (`recording.tables.excerpt`).
    A damaged file of several is left out, which the answer says; `recordings` are the others.
    Raises ConfigError, MissingFile or RecordingError, one line each.
    """
    document = robot if isinstance(robot, Document) else Document.read(Path(robot))
    accepted = with_effects_in(document)
    progress("reading")
    most = most_rows(accepted)

    def kept(path: Path) -> FlatRecording:
        return excerpt(read(path) if read else read_flat(path, progress), most)

    used, damaged = _readable(recordings, kept)
    held_out, damaged_too = _readable(holdout, kept)
    recorded, others = ([one for _, one in each] for each in (used, held_out))
    limits = MotionLimits.of(document.data)
    answer = diagnose_recordings(accepted, recorded, others, progress, limits)
    update: dict[str, object] = {
        "robot": accepted.name,
        "recordings": [str(path) for path, _ in used],
        "left_out": [*damaged, *damaged_too],
    }
    if (plan := answer.next_experiment) is not None:
        # The robot's name is that of no file: the job has to run as it stands.
        job = plan.job | {"robot": str(document.path.resolve())}
        update["next_experiment"] = plan.model_copy(update={"job": job})
    answer = answer.model_copy(update=update)
    answer = answer.model_copy(update={"says": sentences(answer, accepted)})
    if json_out is not None:
        write_whole(json_out, json.dumps(answer.to_json(), indent=1) + "\n")
    return answer


def _readable(
    paths: Sequence[Path | str], kept: Callable[[Path], FlatRecording]
) -> tuple[list[tuple[Path, FlatRecording]], list[str]]:
    """Those that can be read, and why the others cannot. Raises RecordingError where none can."""
    found, damaged = [], []
    for path in map(Path, paths):
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
    accepted: RobotModel,
    recordings: Sequence[FlatRecording],
    holdout: Sequence[FlatRecording] = (),
    progress: Progress = lambda _: None,
    motion_limits: MotionLimits | None = None,
) -> Diagnosis:
    """The same for recordings in memory. motion_limits: for the run that is proposed."""
    units = {name: unit for one in recordings for name, unit in one.units.items()}
    with said_in(units.values()):
        admission = admit(accepted, recordings, holdout, motion_limits, progress)
        answer = diagnosed(admission, progress, motion_limits)
        doubts = [doubt.says for doubt in admission.doubts]
        known = known_of(accepted, [Path(one.source) for one in admission.recordings])
        update = {"thinned": thinned(admission.recordings), "doubts": doubts, "known": known}
        update |= {"version": own_version(), "units": units}
        answer = in_words(with_units(answer.model_copy(update=update), accepted))
        return answer.model_copy(update={"says": sentences(answer, accepted)})
