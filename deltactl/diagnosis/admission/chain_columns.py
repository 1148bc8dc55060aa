"""The columns of a chain of joints, and the effects that its robot file states: do they belong to
the joints of its model?
"""

from __future__ import annotations

import numpy as np

from deltactl.diagnosis.admission.options import ADMISSION
from deltactl.diagnosis.admission.refusal import Kind, refuse
from deltactl.diagnosis.observations.options import OBSERVATIONS
from deltactl.diagnosis.plants.chain.joint_motions import MEASURED, NEEDED, columns_of, prepared
from deltactl.diagnosis.plants.chain.plant import CHAIN, ChainPlant
from deltactl.diagnosis.plants.lone.options import FORCED_AXIS
from deltactl.foundation.errors import ConfigError
from deltactl.foundation.printable import count
from deltactl.models.effects.chain_joints import chain_effects
from deltactl.models.rigid_chain import RigidChain
from deltactl.models.robot import ChainRobot
from deltactl.recording.tables.flat import FlatRecording

TURNS_RAD = 4.0 * np.pi
"""Two turns: few joints of arms go farther, and in degrees nearly all do."""


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
        for joint, (name, others) in zip(robot.joints, columns_of(robot, stem), strict=True):
            if name not in whole.columns:
                refuse(
                    Kind.COLUMNS,
                    source,
                    f"column {name} of joint '{joint}' is missing",
                    f"name it {' or '.join(others[:2])}, or take the joint out of `joints`",
                    column=name,
                )
    for name in (n for stem in MEASURED for n, _ in columns_of(robot, stem) if n in whole.columns):
        if np.isfinite(whole.columns[name]).mean() < OBSERVATIONS.least_known:
            refuse(Kind.EMPTY, source, f"{name} is mostly empty", column=name)
    for slides, (name, _) in zip(chain.slides, columns_of(robot, "theta"), strict=True):
        _check_unit(whole, name, slides)


def _check_unit(recording: FlatRecording, name: str, slides: bool) -> None:
    """An angle of more than two turns is in degrees, a slide of more than 10 m in mm."""
    known = np.abs(recording.columns[name])
    farthest = float(np.nanquantile(known, ADMISSION.most_of_arms))
    if slides and farthest > ADMISSION.farthest_ranged_m:
        says, unit = f"{name} goes up to {farthest:.4g} m", "mm"
    elif not slides and farthest > TURNS_RAD:
        says, unit = f"{name} goes up to {farthest:.4g} rad", "deg"
    else:
        return
    remedy = f'if it is in {unit}, convert the column, or type --set "{name}={name}[{unit}]"'
    refuse(Kind.UNITS, recording.source, says, remedy, column=name)


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
