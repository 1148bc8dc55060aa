"""The one entry for recordings: do they belong to the robot file, and can they show anything?

In: the robot and its recordings. Out: an `Admission`, with what is refused and what is doubted, and
the plants that the pipelines take apart. Every caller of the diagnosis passes through here once.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import TypeVar

from deltactl.diagnosis.admission import axis_match, chain_columns, columns
from deltactl.diagnosis.admission.another_kind import of_another_kind, refuse_several_motors
from deltactl.diagnosis.admission.arm_columns import (
    check_arm_angles,
    check_steps,
    refuse_exchanged_arms,
)
from deltactl.diagnosis.admission.doubts import doubts_of
from deltactl.diagnosis.admission.excerpt import excerpts, most_rows
from deltactl.diagnosis.admission.refusal import Doubt, Kind, Refusal, refusal
from deltactl.diagnosis.admission.robot_match import check_belongs, check_input
from deltactl.diagnosis.observations.servo_preprocessing import reads_disturbance, sensor_rounds
from deltactl.diagnosis.plants.chain.plant import ChainPlant
from deltactl.diagnosis.plants.chain.poses import PosePlant
from deltactl.diagnosis.plants.delta.model import DeltaModel
from deltactl.diagnosis.plants.delta.plant import DeltaPlant
from deltactl.diagnosis.plants.delta.recorded import Recorded
from deltactl.diagnosis.plants.delta.safe_poses import MotionLimits
from deltactl.diagnosis.plants.lone.commanded_axis import CommandedAxis
from deltactl.diagnosis.plants.lone.forced_axis import ForcedAxis
from deltactl.diagnosis.plants.lone.range_sensor import RangeSensorPlant
from deltactl.diagnosis.plants.lone.servo_delta import ServoDelta
from deltactl.foundation.errors import RefusedRecording
from deltactl.models.chain.servo_delta import ServoChain
from deltactl.models.effects.chain_joints import check_chain
from deltactl.models.rigid_chain import RigidChain
from deltactl.models.robot import (
    ChainRobot,
    DeltaRobot,
    RangeSensor,
    RobotModel,
    ServoAxis,
    StepperAxis,
)
from deltactl.models.servo_drive import ServoDrive
from deltactl.recording.column_measures import first_of
from deltactl.recording.tables.chain_tables import measures_poses
from deltactl.recording.tables.flat import FlatRecording

LoneRobot = StepperAxis | ServoAxis | RangeSensor
LonePlant = CommandedAxis | ForcedAxis | RangeSensorPlant
AnyPlant = LonePlant | DeltaPlant | ServoDelta | ChainPlant | PosePlant
Progress = Callable[[str], None]
P = TypeVar("P")


@dataclass(frozen=True, slots=True, eq=False)
class Machine:
    """What a machine is compared by."""

    plant: AnyPlant
    others: Sequence[AnyPlant] = ()
    """Plants of held-out recordings."""
    left_out: tuple[Refusal, ...] = ()
    """Why other held-out recordings say nothing."""
    singles: Sequence[AnyPlant] = ()
    """Plants of each of several recordings by itself."""


@dataclass(frozen=True, slots=True, eq=False)
class ServoRobot:
    """A servo delta that was looked at from outside too.

    torques: why not, where they say nothing.
    """

    outside: Machine
    torques: Machine | Refusal


ByJoint = dict[str, Machine]
"""An arm without efforts, which its commands are compared with: each joint by itself."""
Admitted = Machine | ServoRobot | ByJoint


@dataclass(frozen=True, slots=True, eq=False)
class Admission:
    """What the door says of recordings of a robot.

    recordings, holdout: as they are used, cut to what can be worked on. machine: what the pipelines
    take apart; None where a recording was refused.
    """

    robot: RobotModel
    recordings: Sequence[FlatRecording]
    holdout: Sequence[FlatRecording]
    refusals: tuple[Refusal, ...] = ()
    doubts: tuple[Doubt, ...] = ()
    machine: Admitted | None = None

    def passed(self) -> Admitted:
        """The machine. Raises RefusedRecording with the first refusal, where there is one."""
        if self.machine is None:
            raise self.refusals[0].error()
        return self.machine


def admit(
    robot: RobotModel,
    recordings: Sequence[FlatRecording],
    holdout: Sequence[FlatRecording] = (),
    limits: MotionLimits | None = None,
    progress: Progress = lambda _: None,
) -> Admission:
    """Hold recordings against their robot; see `Admission`.

    limits: of the robot file, for counts that lie beyond them. What is quickly seen comes first; of
    that, every recording has its own refusal. Raises nothing that is wrong with a recording.
    """
    try:
        if not recordings:
            raise refusal("no_recording").error()
        recordings = excerpts(recordings, most_rows(robot))
        holdout = excerpts(holdout, most_rows(robot))
    except RefusedRecording as error:
        return Admission(robot, recordings, holdout, (error.refusal,))
    every = [*recordings, *holdout]
    if refusals := tuple(_at_first_sight(robot, every, limits)):
        return Admission(robot, recordings, holdout, refusals)
    try:
        machine = _machine(robot, recordings, holdout, progress)
    except RefusedRecording as error:
        refused = _with_what_to_type(error.refusal, robot, every)
        return Admission(robot, recordings, holdout, (refused,))
    doubts = [doubts_of(robot, recording) for recording in recordings]
    if isinstance(machine, Machine) and isinstance(machine.plant, CommandedAxis):
        doubts.append(axis_match.ahead_of_command(machine.plant, recordings[0].source))
        recordings = machine.plant.recordings
    if isinstance(machine, Machine) and isinstance(machine.plant, ChainPlant):
        doubts.append(chain_columns.gain_measured(robot, machine.plant))
    kept = tuple(doubt for doubt in doubts if doubt is not None)
    return Admission(robot, recordings, holdout, (), kept, machine)


def _at_first_sight(
    robot: RobotModel, recordings: Iterable[FlatRecording], limits: MotionLimits | None
) -> Iterable[Refusal]:
    """The first refusal of each recording by its columns alone."""
    for recording in recordings:
        try:
            check_steps(robot, recording, limits)
            check_arm_angles(robot, recording)
            refuse_exchanged_arms(robot, recording)
            refuse_several_motors(robot, recording)
        except RefusedRecording as error:
            yield error.refusal


def _with_what_to_type(
    refusal: Refusal, robot: RobotModel, recordings: Sequence[FlatRecording]
) -> Refusal:
    """A refusal for want of columns, with the machine or the columns that the table looks like."""
    if refusal.kind is Kind.COLUMNS and not _by_poses(robot, recordings):
        for recording in recordings:
            if recording.source == refusal.source:
                return of_another_kind(refusal, robot, recording)
    return refusal


def _by_poses(robot: RobotModel, recordings: Sequence[FlatRecording]) -> bool:
    """Whether a chain was measured from outside, of which other names need no guess."""
    return isinstance(robot, ChainRobot) and any(
        measures_poses(robot.joints, r) for r in recordings
    )


def _machine(
    robot: RobotModel,
    recordings: Sequence[FlatRecording],
    holdout: Sequence[FlatRecording],
    progress: Progress,
) -> Admitted:
    """What the pipelines take apart. Raises RefusedRecording."""
    if isinstance(robot, ChainRobot):
        return _chain(robot, recordings, holdout)
    if not isinstance(robot, DeltaRobot):
        return _lone(robot, recordings, holdout)
    every = [*recordings, *holdout]
    servo = isinstance(robot.drive, ServoDrive) and robot.masses is not None
    if servo and all(map(reads_disturbance, every)):
        return _servo_robot(robot, recordings, holdout)
    try:
        return _delta(robot, recordings, holdout, progress)
    except RefusedRecording as error:
        sources = [recording.source for recording in every]
        if any(source in str(error) for source in sources):
            raise
        raise error.refusal.of(", ".join(sources)).error() from None


def _delta(
    robot: DeltaRobot,
    recordings: Sequence[FlatRecording],
    holdout: Sequence[FlatRecording],
    progress: Progress = lambda _: None,
) -> Machine:
    model = _model(robot, recordings)
    held_out = [_model(robot, [recording]) for recording in holdout]
    progress("do recording and robot file belong together")
    one = len(recordings) == 1
    for recording in recordings:
        check_belongs(model if one else _model(robot, [recording]), recording.source)
    for other, recording in zip(held_out, holdout, strict=True):
        check_belongs(other, recording.source)
    if not one:
        check_input(model)
    others = [DeltaPlant(Recorded(one)) for one in held_out]
    return Machine(DeltaPlant(Recorded(model)), others)


def _model(robot: DeltaRobot, recordings: Sequence[FlatRecording]) -> DeltaModel:
    columns.check_delta(robot, recordings)
    model = DeltaModel(robot, recordings)
    columns.check_assembled(model)
    return model


def _servo_robot(
    robot: DeltaRobot, recordings: Sequence[FlatRecording], holdout: Sequence[FlatRecording]
) -> Machine | ServoRobot:
    """Torques by the disturbances, geometry by the sensors; held-out recordings are used by a part
    that can use all of them.
    """
    rounds = [seen for seen in map(sensor_rounds, recordings) if seen is not None]
    if not rounds or (robot.sensors is None and not any(one.has("pos_x") for one in rounds)):
        return _joints(robot, recordings, holdout)
    others = [one for one in map(sensor_rounds, holdout) if one is not None]
    outside = _delta(robot, rounds, others)
    if len(others) < len(holdout):
        outside = Machine(outside.plant)
    try:
        return ServoRobot(outside, _joints(robot, recordings, holdout))
    except RefusedRecording as error:
        return ServoRobot(outside, error.refusal)


def _joints(
    robot: DeltaRobot, recordings: Sequence[FlatRecording], holdout: Sequence[FlatRecording]
) -> Machine:
    """The joints of a servo delta. Raises ConfigError where the robot file has no masses."""
    chain = ServoChain(robot)

    def plant(recordings: Sequence[FlatRecording]) -> ServoDelta:
        plant = ServoDelta(
            chain, [columns.servo_signals(recording, chain) for recording in recordings]
        )
        columns.check_disturbances(plant, recordings[0].source)
        return plant

    return Machine(plant(recordings), *_held_out(plant, holdout))


def _chain(
    robot: ChainRobot, recordings: Sequence[FlatRecording], holdout: Sequence[FlatRecording]
) -> Machine | ByJoint:
    """The joints of a chain, in motion or measured from outside.

    Raises ConfigError where its model does not hold them.
    """
    chain = RigidChain(Path(robot.model), robot.joints, robot.gravity)
    check_chain(robot, chain)

    def in_motion(recordings: Sequence[FlatRecording]) -> ChainPlant:
        recordings = [chain_columns.angles_in(robot, one) for one in recordings]
        for recording in recordings:
            axis_match.check_times(recording)
            chain_columns.check_joints(robot, chain, recording)
        plant = ChainPlant(robot, recordings, chain)
        chain_columns.check_motion(plant)
        return plant

    def from_outside(recordings: Sequence[FlatRecording]) -> PosePlant:
        recordings = [chain_columns.angles_in(robot, one) for one in recordings]
        for recording in recordings:
            chain_columns.check_poses(robot, chain, recording)
        plant = PosePlant(robot, recordings, chain)
        chain_columns.check_placed(plant)
        return plant

    by_poses = all(measures_poses(robot.joints, one) for one in recordings)
    if not by_poses and all(chain_columns.only_follows(robot, one) for one in recordings):
        return _followed(robot, chain, recordings, holdout)
    plant: Callable[[Sequence[FlatRecording]], AnyPlant] = from_outside if by_poses else in_motion
    if robot.effort_gain == "unknown" and not by_poses:
        robot = in_motion(recordings).of_measured_gain()
    others, left_out = _held_out(plant, holdout)
    singles = [plant([one]) for one in recordings] if len(recordings) > 1 else []
    return Machine(plant(recordings), others, left_out, singles)


def _followed(
    robot: ChainRobot, chain: RigidChain,
    recordings: Sequence[FlatRecording], holdout: Sequence[FlatRecording],
) -> ByJoint:  # fmt: skip
    """Each joint of a chain by its commands, under the weight that the model has there."""

    def alone(recordings: Sequence[FlatRecording]) -> list[list[FlatRecording]]:
        angles = [chain_columns.angles_in(robot, one) for one in recordings]
        return [chain_columns.followed(chain, one) for one in angles]

    seen, others = alone(recordings), alone(holdout)
    return {
        axis.name: _lone(axis, [one[j] for one in seen], [one[j] for one in others])
        for j, axis in enumerate(chain_columns.joints_alone(robot, chain))
    }


def _lone(
    robot: LoneRobot, recordings: Sequence[FlatRecording], holdout: Sequence[FlatRecording]
) -> Machine:
    forced = _judged_by_effort(robot, recordings)

    def plant(recordings: Sequence[FlatRecording]) -> LonePlant:
        return _plant(robot, recordings, forced)

    for recording in recordings:
        axis_match.check_times(recording)
    whole, source = plant(recordings), recordings[0].source
    others, left_out = _held_out(plant, holdout)
    if isinstance(whole, CommandedAxis):
        axis_match.check_direction(whole, source)
    if isinstance(whole, ForcedAxis):
        axis_match.check_velocity([*recordings, *holdout])
        axis_match.check_force(whole)
    singles = [plant([one]) for one in recordings] if len(recordings) > 1 else []
    if isinstance(whole, ForcedAxis):
        columns.check_clear_motion(whole.variant)
    return Machine(whole, others, left_out, singles)


def _judged_by_effort(robot: LoneRobot, recordings: Sequence[FlatRecording]) -> bool:
    """All recordings have an effort and the file an inertia; held-out ones are judged alike."""
    return (
        isinstance(robot, ServoAxis)
        and robot.inertia is not None
        and all(first_of(recording, ["effort"]) for recording in recordings)
    )


def _plant(robot: LoneRobot, recordings: Sequence[FlatRecording], forced: bool) -> LonePlant:
    """The plant of the robot's kind; of an axis by its effort or by its commands."""
    if isinstance(robot, RangeSensor):
        columns.check_ranged(recordings)
        sensor = RangeSensorPlant(robot, recordings)
        columns.check_ranges(sensor, recordings[0].source)
        return sensor
    if forced and isinstance(robot, ServoAxis):
        columns.check_forced(robot, recordings)
        axis = ForcedAxis(robot, recordings)
        columns.check_clear_motion(axis)
        return axis
    columns.check_followed(robot, recordings)
    return CommandedAxis(robot, recordings)


def _held_out(
    make: Callable[[Sequence[FlatRecording]], P], holdout: Sequence[FlatRecording]
) -> tuple[list[P], tuple[Refusal, ...]]:
    """Plants of held-out recordings, and why others, too short or broken, are left out."""
    others, left_out = [], []
    for recording in holdout:
        try:
            others.append(make([recording]))
        except RefusedRecording as error:
            left_out.append(error.refusal)
    return others, tuple(left_out)
