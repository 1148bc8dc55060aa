"""Do columns of a chain belong to its model's joints?"""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from deltactl.diagnosis.admission.columns import refuse_mostly_empty
from deltactl.diagnosis.admission.options import ADMISSION
from deltactl.diagnosis.admission.refusal import Doubt, doubt, refuse
from deltactl.diagnosis.observations.options import OBSERVATIONS
from deltactl.diagnosis.observations.readings import FloatArray, bridged
from deltactl.diagnosis.plants.chain.joint_efforts import CHAIN
from deltactl.diagnosis.plants.chain.joint_motions import MEASURED, NEEDED, prepared
from deltactl.diagnosis.plants.chain.plant import ChainPlant
from deltactl.diagnosis.plants.chain.poses import PosePlant
from deltactl.diagnosis.plants.lone.forced_axis import FEWEST_IN_MOTION
from deltactl.diagnosis.plants.lone.options import FORCED_AXIS
from deltactl.foundation.printable import count
from deltactl.models.rigid_chain import RigidChain
from deltactl.models.robot import ChainRobot, RobotModel, ServoAxis
from deltactl.recording.tables.chain_tables import (
    QUATERNION,
    block,
    by_joint,
    columns_of,
    counted,
    in_angles,
    joint_columns,
    place_of,
    targets_in,
)
from deltactl.recording.tables.flat import FlatRecording

TURNS_RAD = 4.0 * np.pi
"""Two turns: few joints of arms go farther, and in degrees nearly all do."""
QUATERNION_OFF = 0.1
"""By which a quaternion's length may differ from 1: few decimals."""
FARTHER_THAN_REACH = 20.0
"""Times the reach of a model within which places move: in mm they move a thousand times as far."""
FOLLOWED = ("command", "theta")
"""What joints have that are compared with their commands."""
LEAST_ALIKE = 0.3
"""Share of the motion that no arm of this model leaves: joints in another order leave half."""


def angles_in(robot: ChainRobot, recording: FlatRecording) -> FlatRecording:
    """With counts of joints as angles. Raises RefusedRecording where one is no whole number."""
    own = counted(robot.joints, recording, robot.rad_per_count, robot.zero_counts)
    for name in own:
        counts = {**recording.columns, **recording.extra}[name]
        if "velocity" not in name and len(broken := np.flatnonzero(counts % 1.0 > 0.0)):
            refuse("joint_counts", recording.source, name, value=counts[broken[0]])
    return in_angles(recording, own)


def check_joints(robot: ChainRobot, chain: RigidChain, recording: FlatRecording) -> None:
    """Angle and effort of every joint, in SI units. Raises RefusedRecording."""
    source = recording.source
    (whole,) = prepared(robot, [recording])
    fewest = FORCED_AXIS.fewest_forced_rows
    if len(whole) < fewest:
        refuse("few_rows", source, rows=count(len(whole), "row"), fewest=fewest)
    for stem in NEEDED:
        for joint, (name, others) in zip(robot.joints, columns_of(robot.joints, stem), strict=True):
            if name not in whole.columns:
                refuse("joint_column", source, name, joint=joint, others=" or ".join(others[:2]))
    names = [name for stem in MEASURED for name, _ in columns_of(robot.joints, stem)]
    for name in names:
        if name in whole.columns:
            refuse_mostly_empty(whole, name, "mostly_empty")
    for slides, (name, _) in zip(chain.slides, columns_of(robot.joints, "theta"), strict=True):
        _check_unit(source, name, slides, whole.columns[name])


def only_follows(robot: ChainRobot, recording: FlatRecording) -> bool:
    """Whether a recording has a command and an angle of every joint, and no efforts."""
    read = {s: joint_columns(robot.joints, recording, s) for s in (*FOLLOWED, "effort")}
    return all(read["command"]) and all(read["theta"]) and not any(read["effort"])


def joints_alone(robot: ChainRobot, chain: RigidChain) -> list[ServoAxis]:
    """Each joint of a chain as an axis that follows its commands."""
    return [
        ServoAxis(
            kind="servo_axis", name=joint, motion="linear" if slides else "rotary", zero=robot.zero
        )
        for joint, slides in zip(robot.joints, chain.slides, strict=True)
    ]


def followed(chain: RigidChain, recording: FlatRecording) -> list[FlatRecording]:
    """Command and position of each joint, and how the weight of the chain pulls at it."""
    whole = by_joint(chain.joints, recording, FOLLOWED)
    numbers = range(1, len(chain.joints) + 1)
    at = np.stack([bridged(whole, f"theta_{n}") for n in numbers], axis=1)
    names = [{"command": f"command_{n}", "position": f"theta_{n}"} for n in numbers]
    each = [{axis: whole.columns[name] for axis, name in own.items()} for own in names]
    pulls = -chain.efforts(at, 0.0 * at, 0.0 * at).T
    return [
        replace(recording, columns={**columns, "load": pull}, extra={})
        for columns, pull in zip(each, pulls, strict=True)
    ]


def check_poses(robot: ChainRobot, chain: RigidChain, recording: FlatRecording) -> None:
    """Angles of every joint and places of a target, in SI units. Raises RefusedRecording."""
    source = recording.source
    if len(recording) < CHAIN.fewest_poses:
        poses = count(len(recording), "pose")
        refuse("few_poses", source, poses=poses, fewest=CHAIN.fewest_poses)
    read = [joint_columns(robot.joints, recording, stem) for stem in ("theta", "command")]
    names = max(read, key=lambda found: sum(name is not None for name in found))
    for number, (joint, name) in enumerate(zip(robot.joints, names, strict=True), 1):
        if name is None:
            refuse("joint_unknown", source, f"theta_{number}", joint=joint, number=number)
        (values,) = np.asarray(block(recording, [name])).T
        _check_unit(source, name, chain.slides[number - 1], values)
    for target in targets_in(recording):
        _check_place(chain, recording, target)
    if (quaternion := block(recording, QUATERNION)) is not None:
        length = float(np.nanmedian(np.linalg.norm(quaternion, axis=1)))
        if not abs(length - 1.0) < QUATERNION_OFF:
            refuse("no_rotation", source, length=length)


def _check_place(chain: RigidChain, recording: FlatRecording, target: str) -> None:
    """A place has three columns, and moves as far as such a chain reaches."""
    source, place = recording.source, place_of(recording, target)
    if place is None:
        there = [a for a in "xyz" if block(recording, [f"{target}_{a}"]) is None]
        refuse("place_missing", source, missing=f"{target}_{there[0]}")
    if np.isfinite(place).all(axis=1).mean() < OBSERVATIONS.least_known:
        refuse("place_empty", source, f"{target}_x", target=target)
    wide = float(np.max(np.nanquantile(place, 0.95, axis=0) - np.nanquantile(place, 0.05, axis=0)))
    if wide > FARTHER_THAN_REACH * chain.reach_m:
        far = {"wide": wide, "reach": chain.reach_m}
        refuse("place_far", source, f"{target}_x", target=target, **far)


def check_placed(plant: PosePlant) -> None:
    """Some placement of base and target must fit the model. Raises RefusedRecording."""
    own = plant.poses.places - np.nanmean(plant.poses.places, axis=0)
    left, moved = (float(np.sqrt(np.nanmean(x**2))) for x in (plant.placed_only, own))
    if left > LEAST_ALIKE * moved:
        refuse("misplaced", plant.source, left=1e3 * left, moved=1e3 * moved)


def _check_unit(source: str, name: str, slides: bool, values: FloatArray) -> None:
    """An angle of more than two turns is in degrees, a slide of more than 10 m in mm."""
    farthest = float(np.nanquantile(np.abs(values), ADMISSION.most_of_arms))
    in_mm = ADMISSION.farthest_ranged_m, "m", "mm"
    most, read, unit = in_mm if slides else (TURNS_RAD, "rad", "deg")
    if farthest > most:
        refuse("joint_unit", source, name, farthest=farthest, read=read, unit=unit)


def gain_measured(robot: RobotModel, plant: ChainPlant) -> Doubt | None:
    """What was measured of gains that the robot file does not know."""
    gains = ", ".join(f"{one:.3g}" for one in plant.robot.effort_per_unit / plant.robot.gear)
    unknown = isinstance(robot, ChainRobot) and robot.effort_gain == "unknown"
    return doubt("gain_measured", plant.source, "effort", gains=gains) if unknown else None


def check_motion(plant: ChainPlant) -> None:
    """Some joint must be in clear motion. Raises RefusedRecording."""
    most = max(len(plant.rows_of(j)) for j in range(len(plant.joints)))
    if most < FEWEST_IN_MOTION:
        samples = count(most, "sample")
        refuse("few_of_joint", plant.source, samples=samples, fewest=FEWEST_IN_MOTION)
