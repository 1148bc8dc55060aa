"""A lone machine's recordings: which plant they are of, what is refused, and the words of it."""

from __future__ import annotations

from collections.abc import Callable, Sequence

import numpy as np

from deltactl.diagnosis.admission.regression_plausibility import (
    check_direction,
    check_force,
    check_order,
    check_times,
)
from deltactl.diagnosis.admission.together import check_together
from deltactl.diagnosis.answer.records import Channel, Diagnosis, Finding, Picture
from deltactl.diagnosis.evidence.detection import Progress
from deltactl.diagnosis.pipelines.regression import diagnose_plant
from deltactl.diagnosis.plants.lone.commanded_axis import CommandedAxis
from deltactl.diagnosis.plants.lone.forced_axis import ForcedAxis
from deltactl.diagnosis.plants.lone.range_sensor import RangeSensorPlant
from deltactl.diagnosis.plants.lone.servo_delta import CHANNEL, ServoDelta
from deltactl.diagnosis.report.summary import kinds_of, spoken
from deltactl.foundation.errors import RecordingError
from deltactl.models.effects.kind import MOTORS
from deltactl.models.effects.servo_joints import SERVO_EFFECTS
from deltactl.models.robot import DeltaRobot, RangeSensor, ServoAxis, StepperAxis
from deltactl.recording.foreign.slope import check_velocity
from deltactl.recording.tables.flat import FlatRecording

LoneRobot = StepperAxis | ServoAxis | RangeSensor
LonePlant = CommandedAxis | ForcedAxis | RangeSensorPlant
Plant = LonePlant | ServoDelta


def plant_of(robot: LoneRobot, recordings: Sequence[FlatRecording]) -> LonePlant:
    """The plant that fits robot and columns. Raises RecordingError for bad input."""
    if not recordings:
        raise RecordingError("no recording was given")
    if isinstance(robot, RangeSensor):
        return RangeSensorPlant(robot, recordings)
    forced = all(r.has("effort") and np.isfinite(r.columns["effort"]).any() for r in recordings)
    if forced and isinstance(robot, ServoAxis) and robot.inertia is not None:
        return ForcedAxis(robot, recordings)
    return CommandedAxis(robot, recordings)


def diagnose_axis(
    robot: LoneRobot,
    recordings: Sequence[FlatRecording],
    holdout: Sequence[FlatRecording] = (),
    progress: Progress = lambda _: None,
) -> Diagnosis:
    """Diagnose one or several recordings of a lone machine. Raises RecordingError."""
    for recording in recordings:
        check_times(recording)
    plant = plant_of(robot, recordings)
    others, left_out = _held_out(lambda r: plant_of(robot, [r]), holdout)
    source = recordings[0].source
    if isinstance(plant, CommandedAxis):
        check_direction(plant, source)
        check_order(plant, source)
    if isinstance(plant, ForcedAxis):
        check_velocity([*recordings, *holdout])
        check_force(plant)
    several = len(recordings) > 1
    singles = [plant_of(robot, [one]) for one in recordings if several]
    answer = diagnose_plant(plant, others, progress, singles)
    if isinstance(plant, CommandedAxis):
        check_together(plant, answer.fit, answer.findings, recordings[0])
    answer = answer.model_copy(update={"pull_said": _pull_said(robot)})
    return spoken(answer, kinds_of(robot, answer), left_out, robot.effects)


def _pull_said(robot: LoneRobot) -> bool:
    """Whether nobody need be asked to enter in the robot file what pulls at it."""
    return not isinstance(robot, ServoAxis) or robot.gravity is not None


def diagnose_servo(
    robot: DeltaRobot,
    recordings: Sequence[FlatRecording],
    holdout: Sequence[FlatRecording] = (),
    progress: Progress = lambda _: None,
) -> Diagnosis:
    """Diagnose a servo delta by its disturbance estimates. Raises RecordingError, ConfigError."""
    plant = ServoDelta(robot, recordings)
    others, left_out = _held_out(lambda r: ServoDelta(robot, [r]), holdout)
    answer = diagnose_plant(plant, others, progress)
    first = float(plant.readings.t_s[0])
    found = [_of_joint(one, first, plant.span_s) for one in answer.findings]
    pictured = answer.model_copy(update={"findings": found, "picture": joint_channels(answer)})
    return spoken(pictured, SERVO_EFFECTS, left_out)


def _of_joint(finding: Finding, first_s: float, span_s: float) -> Finding:
    """Its place in the recording's own time, on the channels of its joint."""
    joints = finding.component[-1] if finding.component in MOTORS else "123"
    axes = [f"{CHANNEL}_{joint}" for joint in joints]
    where = finding.where.model_copy(
        update={"axes": axes, "times_s": [(first_s, first_s + span_s)], "recordings": [1]}
    )
    return finding.model_copy(update={"where": where})


def _held_out(
    make: Callable[[FlatRecording], Plant], holdout: Sequence[FlatRecording]
) -> tuple[list[Plant], list[str]]:
    """Plants of the held-out recordings; those too short or broken to tell are left out, named."""
    others: list[Plant] = []
    left_out: list[str] = []
    for recording in holdout:
        try:
            others.append(make(recording))
        except RecordingError as error:
            left_out.append(str(error))
    return others, left_out


def joint_channels(answer: Diagnosis) -> Picture | None:
    """One channel a joint, in the recording's own time, of three that stood end to end."""
    picture = answer.picture
    if picture is None:
        return None
    (whole,) = picture.channels
    third = len(picture.t_s) // 3
    parts = [slice(third * j, third * (j + 1)) for j in range(3)]
    channels = [
        Channel(
            name=f"{CHANNEL}_{j + 1}", unit=whole.unit, observed=whole.observed[rows],
            before=whole.before[rows], after=whole.after[rows], noise=whole.noise,
        )
        for j, rows in enumerate(parts)
    ]  # fmt: skip
    names = {"position": "theta", "velocity": "speed"}
    covariates = {
        f"{new}_{j + 1}": picture.covariates[old][rows]
        for old, new in names.items()
        for j, rows in enumerate(parts)
    }
    return Picture(t_s=picture.t_s[:third], channels=channels, covariates=covariates)
