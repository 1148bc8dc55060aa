"""The columns of each kind of machine: are those there that its plant needs, and do they say
anything?

Asked before a plant is built, of the columns as the plant reads them. Every function refuses, as
`RefusedRecording`, what the plant could not be built of.
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from deltactl.diagnosis.admission.options import ADMISSION
from deltactl.diagnosis.admission.refusal import refuse
from deltactl.diagnosis.observations.options import OBSERVATIONS
from deltactl.diagnosis.observations.readings import FloatArray, bridged
from deltactl.diagnosis.observations.servo_preprocessing import (
    JOINTS,
    Signals,
    estimates_disturbance,
    signals_of,
)
from deltactl.diagnosis.plants.delta.model import DeltaModel
from deltactl.diagnosis.plants.lone import forced_axis, range_sensor, recorded_axis
from deltactl.diagnosis.plants.lone.forced_axis import ForcedAxis
from deltactl.diagnosis.plants.lone.options import COMMANDED_AXIS, FORCED_AXIS, RANGE_SENSOR
from deltactl.diagnosis.plants.lone.range_sensor import RangeSensorPlant
from deltactl.diagnosis.plants.lone.servo_delta import ServoDelta
from deltactl.foundation.printable import count
from deltactl.models.chain.servo_delta import ServoChain
from deltactl.models.effects.units_in_use import said
from deltactl.models.robot import DeltaRobot, ServoAxis, StepperAxis
from deltactl.recording.column_measures import first_of, travel
from deltactl.recording.foreign.units import IN_SI
from deltactl.recording.tables.flat import FlatRecording

COMMAND = "the command"
STANDS_IN = {
    "command_1": "command_1 [rad] or steps_1 [microsteps] with `drive` in the robot file",
    "theta_1": "theta_1 [rad], the angle measured at the output (position [rad] is taken too)",
    "position": "position [rad or m], the measured position (theta_1 [rad] is taken too)",
    "command": "command [rad or m], or effort with `inertia` in the robot file",
    "effort": "effort, or command [rad or m]",
    "distance": "distance [m], the true distance",
    "range": "range [m], what the sensor reported",
}


def check_followed(robot: StepperAxis | ServoAxis, recordings: Sequence[FlatRecording]) -> None:
    """Those of an axis that follows commands."""
    recordings = recorded_axis.prepared(recordings)
    order = recorded_axis.observed_in(robot)
    name = _need(recordings[0], order, order[0])
    _enough(recordings, COMMANDED_AXIS.fewest_followed_rows)
    for recording in recordings:
        _check_command(robot, recording)
    commanded = np.concatenate([recorded_axis.commanded(robot, one) for one in recordings])
    seen, source = _laid_end_to_end(recordings, name), recordings[0].source
    _refuse_still(commanded, COMMAND, source)
    _refuse_still(seen, name, source)
    _refuse_other_units(commanded, seen, (name, COMMAND), recorded_axis.unit_of(robot), source)
    _check_loads(recordings)


def check_forced(robot: ServoAxis, recordings: Sequence[FlatRecording]) -> None:
    """Those of an axis that is judged by its effort."""
    source = recordings[0].source
    recordings = forced_axis.prepared(recordings)
    name = _need(recordings[0], ("position", "theta_1"), "position")
    _enough(recordings, FORCED_AXIS.fewest_forced_rows)
    _refuse_still(_laid_end_to_end(recordings, name), name, source)
    for needed in (name, "effort"):
        for recording in recordings:
            refuse_mostly_empty(recording, _need(recording, (needed,), needed))
    force = robot.force_per_effort * np.concatenate([bridged(one, "effort") for one in recordings])
    if not float(np.ptp(force)) > 0.0 and robot.gravity is None:
        _refuse_still(force, "effort", source)
    if all(first_of(one, ["velocity"]) for one in recordings):
        for recording in recordings:
            refuse_mostly_empty(recording, "velocity")
    _check_loads(recordings)


def check_clear_motion(plant: ForcedAxis) -> None:
    """Enough of an axis that is judged by its effort must be in clear motion."""
    rows, fewest = len(plant.rows), forced_axis.FEWEST_IN_MOTION
    if rows < fewest:
        refuse("few_in_motion", plant.source, rows=rows, fewest=fewest)


def check_ranged(recordings: Sequence[FlatRecording]) -> None:
    """Those of a range sensor by itself."""
    for recording in recordings:
        for name in ("distance", "range"):
            _need(recording, (name,), name)
    recordings = range_sensor.averaged(recordings)
    _enough(recordings, RANGE_SENSOR.fewest_ranged_rows)
    for recording in recordings:
        refuse_mostly_empty(recording, "distance")


def check_ranges(plant: RangeSensorPlant, source: str) -> None:
    """Its readings, without those that are none, against the distances."""
    ranges, distances = plant.observed[plant.valid], plant.distance[plant.valid]
    _refuse_still(ranges, "range", source)
    _refuse_other_units(distances, ranges, ("range", "distance"), "m", source)


def servo_signals(recording: FlatRecording, chain: ServoChain) -> Signals:
    """Motions and disturbances of a servo delta, of a recording that has them."""
    _check_three(recording, "theta")
    step_s = float(np.median(np.diff(recording.t_s)))
    shortest_s, longest_s = OBSERVATIONS.servo_period_s
    if not shortest_s <= step_s <= longest_s:
        needed = {"fewest": 1 / longest_s, "most": 1 / shortest_s}
        refuse("servo_times", recording.source, "t", step=step_s, **needed)
    angle = np.stack([bridged(recording, f"theta_{joint}") for joint in JOINTS], axis=1)
    if not np.ptp(angle, axis=0).max() > OBSERVATIONS.least_turn_rad:
        refuse("joints_still", recording.source, "theta_1")
    _check_three(recording, "disturbance" if estimates_disturbance(recording) else "current")
    signals = signals_of(recording, chain)
    if not np.isfinite(angle).all() or signals.moving < OBSERVATIONS.least_usable:
        percent = 100 * OBSERVATIONS.least_usable
        refuse("joints_slow", recording.source, speed=signals.twitching_radps, percent=percent)
    return signals


def check_disturbances(plant: ServoDelta, source: str) -> None:
    """Enough of a servo delta's motion must be clear."""
    valid = int(plant.readings.valid.sum())
    if valid < plant.fewest:
        refuse("few_stretches", source, stretches=valid)


def check_delta(robot: DeltaRobot, recordings: Sequence[FlatRecording]) -> None:
    """Commands of all motors, and something that looks at the platform or the arms."""
    if not DeltaModel.channels(robot, recordings):
        refuse("nothing_observed", recordings[0].source)
    _enough(recordings, OBSERVATIONS.fewest_samples)
    for recording in recordings:
        _check_commands(robot, recording)


def check_assembled(model: DeltaModel) -> None:
    """The commanded angles must be those of a machine that can be assembled there."""
    if model.unassembled > ADMISSION.most_unassembled:
        refuse("unassembled", robot=model.robot.name, percent=100 * model.unassembled)


def _check_commands(robot: DeltaRobot, recording: FlatRecording) -> None:
    """Commands of three motors, as angles or as counts with a drive."""
    stem = DeltaModel.commands_in(recording)
    if stem is None:
        refuse("no_commands", recording.source, there=", ".join(recording.columns))
    for motor in JOINTS:
        refuse_mostly_empty(recording, f"{stem}{motor}", "mostly_empty")
    if stem == "steps_" and robot.drive is None:
        refuse("steps_without_drive", recording.source, "steps_1")


def _check_command(robot: StepperAxis | ServoAxis, recording: FlatRecording) -> None:
    """A command of an axis, as a motion or as counts with a drive."""
    order = recorded_axis.commanded_in(robot)
    name = first_of(recording, order)
    if name is None and isinstance(robot, StepperAxis) and first_of(recording, ["steps_1"]):
        name = "steps_1"
        if robot.drive is None:
            refuse("steps_without_drive", recording.source, name)
    if name is None and isinstance(robot, ServoAxis) and first_of(recording, ["effort"]):
        refuse("effort_without_inertia", recording.source, robot=robot.name)
    refuse_mostly_empty(recording, name or _need(recording, (), order[0]))


def _check_three(recording: FlatRecording, stem: str) -> None:
    """Columns of all joints that are known for most of the time."""
    names = [f"{stem}_{joint}" for joint in JOINTS]
    missing = next((name for name in names if name not in recording.columns), None)
    if missing:
        refuse("joint_missing", recording.source, missing)
    for name in names:
        refuse_mostly_empty(recording, name)


def _check_loads(recordings: Sequence[FlatRecording]) -> None:
    """A known load must be known for most of the time."""
    for recording in recordings:
        if first_of(recording, ["load"]):
            refuse_mostly_empty(recording, "load")


def _need(recording: FlatRecording, names: Sequence[str], wanted: str) -> str:
    """The first of the columns that holds anything; refuses where none does."""
    name = first_of(recording, names)
    if name is None:
        there = ", ".join([*recording.columns, *recording.extra])
        refuse("missing", recording.source, wanted, needs=STANDS_IN[wanted], there=there)
    return name


def _enough(recordings: Sequence[FlatRecording], fewest: int) -> None:
    for recording in recordings:
        if len(recording) < fewest:
            samples = count(len(recording), "sample")
            refuse("few_samples", recording.source, samples=samples, fewest=fewest)


def refuse_mostly_empty(recording: FlatRecording, name: str, case: str = "half_empty") -> None:
    """A column must be known for most of the time. case: which sentence says so."""
    if np.isfinite(recording.columns[name]).mean() < OBSERVATIONS.least_known:
        refuse(case, recording.source, name)


def _refuse_still(values: FloatArray, name: str, source: str) -> None:
    """Nothing can be learned from a machine that was not moved."""
    spread = float(np.nanmax(values) - np.nanmin(values))
    if not spread > 1e-12 * max(1.0, float(np.nanmax(np.abs(values)))):
        refuse("never_changes", source, name)


def _refuse_other_units(
    asked: FloatArray, seen: FloatArray, names: tuple[str, str], unit: str, source: str
) -> None:
    """Motions that differ by a factor of fifty and more are units, not physics.

    names: of what was seen and asked, both in `unit`.
    """
    wide, told = travel(asked), travel(seen)
    if wide <= 0.0 or told <= 0.0:
        return
    ratio = max(told, wide) / min(told, wide)
    if not ratio > OBSERVATIONS.largest_ratio:
        return
    larger = names[0] if told > wide else names[1]
    units = ("deg",) if unit == "rad" else ("mm", "cm")
    meant = [one for one in units if abs(ratio * IN_SI[one] - 1.0) < OBSERVATIONS.near_unit]
    refuse(
        "other_units_meant" if meant else "other_units", source, names[0], asked=names[1],
        told=said(told, unit), wide=said(wide, unit), ratio=ratio, larger=larger,
        unit=meant[0] if meant else "",
    )  # fmt: skip


def _laid_end_to_end(recordings: Sequence[FlatRecording], name: str) -> FloatArray:
    """A column of all recordings, (n,); NaN where one has none."""
    nothing = {len(recording): np.full(len(recording), np.nan) for recording in recordings}
    return np.concatenate([one.columns.get(name, nothing[len(one)]) for one in recordings])
