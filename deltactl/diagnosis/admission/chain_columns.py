"""The columns of a chain of joints, by efforts or by poses, and the effects that its robot file
states: do they belong to the joints of its model?
"""

from __future__ import annotations

import numpy as np

from deltactl.diagnosis.admission.options import ADMISSION
from deltactl.diagnosis.admission.refusal import Kind, refuse
from deltactl.diagnosis.observations.options import OBSERVATIONS
from deltactl.diagnosis.observations.readings import FloatArray
from deltactl.diagnosis.plants.chain.joint_efforts import CHAIN
from deltactl.diagnosis.plants.chain.joint_motions import MEASURED, NEEDED, prepared
from deltactl.diagnosis.plants.chain.plant import ChainPlant
from deltactl.diagnosis.plants.chain.poses import PosePlant
from deltactl.diagnosis.plants.lone.options import FORCED_AXIS
from deltactl.foundation.errors import ConfigError
from deltactl.foundation.printable import count
from deltactl.models.effects.chain_joints import chain_effects
from deltactl.models.rigid_chain import RigidChain
from deltactl.models.robot import ChainRobot
from deltactl.recording.tables.chain_tables import (
    QUATERNION,
    block,
    columns_of,
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
LEAST_ALIKE = 0.3
"""Share of the motion that no arm of this model leaves: joints in another order leave half."""


def check_effects(robot: ChainRobot, chain: RigidChain) -> None:
    """Effects and places of the robot file must be some of such a chain. Raises ConfigError."""
    kinds = chain_effects(dict.fromkeys(chain.joints, False), chain.tip)
    for entry in robot.effects:
        if entry.effect not in kinds:
            names = ", ".join(sorted(kinds))
            raise ConfigError(f"effects: effect '{entry.effect}' must be one of {names}")
        if entry.component not in kinds[entry.effect].components:
            names = ", ".join(kinds[entry.effect].components)
            raise ConfigError(
                f"effects: component '{entry.component}' of {entry.effect} must be one of {names}"
            )


def check_joints(robot: ChainRobot, chain: RigidChain, recording: FlatRecording) -> None:
    """Angle and effort of every joint, in SI units. Raises RefusedRecording."""
    source = recording.source
    (whole,) = prepared(robot, [recording])
    fewest = FORCED_AXIS.fewest_forced_rows
    if len(whole) < fewest:
        refuse(Kind.SHORT, source, f"has {count(len(whole), 'row')}", f"at least {fewest}")
    for stem in NEEDED:
        for joint, (name, others) in zip(robot.joints, columns_of(robot.joints, stem), strict=True):
            if name not in whole.columns:
                refuse(
                    Kind.COLUMNS,
                    source,
                    f"column {name} of joint '{joint}' is missing",
                    f"name it {' or '.join(others[:2])}, or take the joint out of `joints`",
                    column=name,
                )
    for name in (
        n for stem in MEASURED for n, _ in columns_of(robot.joints, stem) if n in whole.columns
    ):
        if np.isfinite(whole.columns[name]).mean() < OBSERVATIONS.least_known:
            refuse(Kind.EMPTY, source, f"{name} is mostly empty", column=name)
    for slides, (name, _) in zip(chain.slides, columns_of(robot.joints, "theta"), strict=True):
        _check_unit(source, name, slides, whole.columns[name])


def check_poses(robot: ChainRobot, chain: RigidChain, recording: FlatRecording) -> None:
    """Angles of every joint and places of a target, in SI units. Raises RefusedRecording."""
    source = recording.source
    if len(recording) < CHAIN.fewest_poses:
        why = f"has {count(len(recording), 'pose')}"
        refuse(Kind.SHORT, source, why, f"at least {CHAIN.fewest_poses}, far apart")
    read = [joint_columns(robot.joints, recording, stem) for stem in ("theta", "command")]
    names = max(read, key=lambda found: sum(name is not None for name in found))
    for joint, name, number in zip(robot.joints, names, range(1, len(names) + 1), strict=True):
        if name is None:
            refuse(
                Kind.COLUMNS,
                source,
                f"neither angle nor command of joint '{joint}' is there",
                f"name it theta_{number}, command_{number} or {joint}",
                column=f"theta_{number}",
            )
    for slides, name in zip(chain.slides, names, strict=True):
        (values,) = np.asarray(block(recording, [str(name)])).T
        _check_unit(source, str(name), slides, values)
    for target in targets_in(recording):
        _check_place(chain, recording, target)
    quaternion = block(recording, QUATERNION)
    if quaternion is not None:
        length = float(np.nanmedian(np.linalg.norm(quaternion, axis=1)))
        if not abs(length - 1.0) < QUATERNION_OFF:
            says = f"quat_w..z have a length of {length:.3g}, and a rotation has 1"
            refuse(Kind.UNITS, source, says, "give quaternions, or rotvec_x..z [rad]")


def _check_place(chain: RigidChain, recording: FlatRecording, target: str) -> None:
    """A place has three columns, and moves as far as such a chain reaches."""
    source, place = recording.source, place_of(recording, target)
    if place is None:
        there = [a for a in "xyz" if block(recording, [f"{target}_{a}"]) is None]
        missing = f"{target}_{there[0]}"
        refuse(Kind.COLUMNS, source, f"column {missing} is missing", "a place has three of them")
    if np.isfinite(place).all(axis=1).mean() < OBSERVATIONS.least_known:
        refuse(Kind.EMPTY, source, f"{target}_x..z is mostly empty", column=f"{target}_x")
    wide = float(np.max(np.nanquantile(place, 0.95, axis=0) - np.nanquantile(place, 0.05, axis=0)))
    if wide > FARTHER_THAN_REACH * chain.reach_m:
        says = f"{target}_x..z moves by {wide:.4g} m, and the model reaches {chain.reach_m:.3g} m"
        remedy = f"if it is in mm, call the columns {target}_x_mm, {target}_y_mm and {target}_z_mm"
        refuse(Kind.UNITS, source, says, remedy, column=f"{target}_x")


def check_placed(plant: PosePlant) -> None:
    """Some placement of base and target must bring places and model together. Raises
    RefusedRecording.
    """
    own = plant.poses.places - np.nanmean(plant.poses.places, axis=0)
    left, moved = (
        float(np.sqrt(np.nanmean(plant.placed_only**2))),
        float(np.sqrt(np.nanmean(own**2))),
    )
    if left > LEAST_ALIKE * moved:
        refuse(
            Kind.ANOTHER_MACHINE,
            plant.source,
            f"wherever its base is, the model is {1e3 * left:.3g} mm off places that move by"
            f" {1e3 * moved:.3g} mm",
            "are the joints in the order of `joints`, and is it this robot's model?",
        )


def _check_unit(source: str, name: str, slides: bool, values: FloatArray) -> None:
    """An angle of more than two turns is in degrees, a slide of more than 10 m in mm."""
    farthest = float(np.nanquantile(np.abs(values), ADMISSION.most_of_arms))
    if slides and farthest > ADMISSION.farthest_ranged_m:
        says, unit = f"{name} goes up to {farthest:.4g} m", "mm"
    elif not slides and farthest > TURNS_RAD:
        says, unit = f"{name} goes up to {farthest:.4g} rad", "deg"
    else:
        return
    remedy = f'if it is in {unit}, convert the column, or type --set "{name}={name}[{unit}]"'
    refuse(Kind.UNITS, source, says, remedy, column=name)


def check_motion(plant: ChainPlant) -> None:
    """Some joint must be in clear motion. Raises RefusedRecording."""
    most = max(len(plant.rows_of(j)) for j in range(len(plant.joints)))
    if most < CHAIN.fewest_rows:
        refuse(
            Kind.SHORT,
            plant.source,
            f"no joint has more than {count(most, 'sample')} in clear motion, a filter's memory"
            " apart",
            f"at least {CHAIN.fewest_rows} are needed: record longer, or faster",
        )
