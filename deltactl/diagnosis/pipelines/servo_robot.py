"""A servo delta's recording in two parts: torques by the disturbances, geometry by the sensors.

The encoders say where the arms were, so sensors are compared with the measured angles, not with
what was asked for; what following costs is the torques' business.
"""

from __future__ import annotations

from collections.abc import Sequence
from functools import partial

import numpy as np

from deltactl.diagnosis.admission.robot_match import check_belongs
from deltactl.diagnosis.answer.records import Diagnosis, NotTestable, Verdict
from deltactl.diagnosis.evidence.detection import Progress
from deltactl.diagnosis.observations.readings import BoolArray, FloatArray, IntArray
from deltactl.diagnosis.observations.servo_preprocessing import JOINTS, reads_disturbance
from deltactl.diagnosis.pipelines.lone_machine import diagnose_servo
from deltactl.diagnosis.pipelines.nonlinear import diagnose_model
from deltactl.diagnosis.pipelines.options import REGRESSION
from deltactl.diagnosis.plants.delta.model import DeltaModel
from deltactl.diagnosis.plants.delta.next_runs import next_runs
from deltactl.diagnosis.plants.delta.safe_poses import MotionLimits
from deltactl.diagnosis.report.summary import told
from deltactl.foundation.errors import RecordingError
from deltactl.models.effects.servo_joints import SERVO_EFFECTS
from deltactl.models.robot import DeltaRobot
from deltactl.models.servo_drive import ServoDrive
from deltactl.recording.tables.flat import FlatRecording

OUTSIDE = [f"{stem}_{axis}" for stem in ("range", "pos") for axis in "xyz"]
INSIDE = ("theta_", "steps_", "command_", "current_", "disturbance_")
STATUS = ("status_",)


def is_servo_run(robot: DeltaRobot, recordings: Sequence[FlatRecording]) -> bool:
    """Whether robot file and recordings are those of servo drives with known masses."""
    return (
        isinstance(robot.drive, ServoDrive)
        and robot.masses is not None
        and all(map(reads_disturbance, recordings))
    )


def diagnose_servo_robot(
    robot: DeltaRobot,
    recordings: Sequence[FlatRecording],
    holdout: Sequence[FlatRecording] = (),
    progress: Progress = lambda _: None,
    motion_limits: MotionLimits | None = None,
    thorough: bool = False,
) -> Diagnosis:
    """Both parts, as far as the recordings allow. Raises RecordingError when neither is possible.

    Held-out recordings are used by a part that can use all of them.
    """
    geometry = [one for one in map(sensor_rounds, recordings) if one is not None]
    if not geometry or (robot.sensors is None and not any(r.has("pos_x") for r in geometry)):
        return diagnose_servo(robot, recordings, holdout, progress)
    others = [one for one in map(sensor_rounds, holdout) if one is not None]
    model = DeltaModel(robot, geometry)
    held_out = [DeltaModel(robot, [one]) for one in others] if len(others) == len(holdout) else []
    for recording in (*geometry, *others):
        check_belongs(robot, recording)
    runs = partial(next_runs, model, motion_limits)
    outside = diagnose_model(model, 0.0, held_out, progress, runs, thorough)
    try:
        torques = diagnose_servo(robot, recordings, holdout, progress)
    except RecordingError as error:
        return _alone(outside, str(error))
    return joined(torques, told(outside))


def sensor_rounds(recording: FlatRecording) -> FlatRecording | None:
    """Rounds of the sensors, with measured angles in place of commands.

    Between two readings of a sensor come many samples of the loop, and each sensor's readings
    stand in rows of their own: they are brought to the rows of the one that was read most.
    """
    columns = recording.columns
    seen = {name: np.flatnonzero(np.isfinite(columns[name])) for name in OUTSIDE if name in columns}
    seen = {name: rows for name, rows in seen.items() if len(rows) >= REGRESSION.fewest_rows}
    if not seen:
        return None
    base = max(seen.values(), key=len)
    table = {
        name: values[base]
        for name, values in columns.items()
        if not name.startswith((*OUTSIDE, *INSIDE, *STATUS))
    }
    extra = {name: values[base] for name, values in recording.extra.items()}
    half_s = 0.5 * float(np.median(np.diff(recording.t_s[base])))
    for name, rows in seen.items():
        chosen, near = _nearest(recording.t_s, base, rows, half_s)
        beside = {name: table, name.replace("range_", "status_"): table}
        beside[name.replace("range_", "t_")] = extra
        for other, into in beside.items():
            source = columns.get(other, recording.extra.get(other))
            if source is not None:
                into[other] = np.where(near, source[chosen], np.nan)
    for joint in JOINTS:
        table[f"command_{joint}"] = columns[f"theta_{joint}"][base]
    return FlatRecording(recording.t_s[base], table, extra, recording.source)


def _nearest(
    t_s: FloatArray, base: IntArray, rows: IntArray, most_s: float
) -> tuple[IntArray, BoolArray]:
    """For each of the `base` rows the nearest of `rows`, and whether it is near enough."""
    after = np.clip(np.searchsorted(rows, base), 1, len(rows) - 1)
    before_s = np.abs(t_s[rows[after - 1]] - t_s[base])
    chosen = np.where(before_s <= np.abs(t_s[rows[after]] - t_s[base]), after - 1, after)
    nearest: IntArray = rows[chosen]
    return nearest, np.abs(t_s[nearest] - t_s[base]) <= most_s


def _alone(outside: Diagnosis, why: str) -> Diagnosis:
    """Geometry only: the torques could not be read, and the answer says why."""
    untested = [
        NotTestable(effect=kind.name, component=component, why=why)
        for kind in SERVO_EFFECTS.values()
        for component in kind.components
    ]
    return outside.model_copy(
        update={
            "not_testable": [*outside.not_testable, *untested],
            "not_read": [why],
        }
    )


def joined(torques: Diagnosis, outside: Diagnosis) -> Diagnosis:
    """Findings of both; figures and pictures are those of the part that found more."""
    first, second = (
        (torques, outside) if _weight(torques) >= _weight(outside) else (outside, torques)
    )
    untested = [one for one in outside.not_testable if one.effect not in SERVO_EFFECTS]
    return first.model_copy(
        update={
            "verdict": _verdict([torques.verdict, outside.verdict]),
            # Two looks at one machine: the smaller p by chance is likelier.
            "false_alarm_p": min(1.0, 2.0 * min(torques.false_alarm_p, outside.false_alarm_p)),
            "findings": [*first.findings, *second.findings],
            "not_testable": [*torques.not_testable, *untested],
            "smallest_detectable": [*torques.smallest_detectable, *outside.smallest_detectable],
            "loosely_built": outside.loosely_built,
            "allowed_for": outside.allowed_for,
            "next_experiment": outside.next_experiment,
            "says": [*first.says, *second.says],
        }
    )


def _weight(answer: Diagnosis) -> tuple[bool, float]:
    return bool(answer.findings), sum(one.evidence.delta_chi2 for one in answer.findings)


def _verdict(both: Sequence[Verdict]) -> Verdict:
    told = {one for one in both if one != "nothing_missing"}
    if not told:
        return "nothing_missing"
    return told.pop() if len(told) == 1 else "partly_explained"
