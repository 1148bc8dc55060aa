"""What can be wrong with the efforts of a chain of joints: effects of the vocabulary, at each joint
and at the link that carries a load; what can be wrong with its poses is in `chain_poses`.

Sizes are at the joint's output and beyond what the model of the chain says.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

import numpy as np

from deltactl.foundation.errors import ConfigError
from deltactl.models.effects import card_of, column_of
from deltactl.models.effects.chain_poses import pose_effects
from deltactl.models.effects.kind import EffectKind, Parameter, Port
from deltactl.models.effects.lone_axis import LINEAR_UNIT
from deltactl.models.effects.payload import EFFECT as PAYLOAD
from deltactl.models.effects.servo_joints import SERVO_EFFECTS
from deltactl.models.effects.units_in_use import said
from deltactl.models.robot import ChainRobot, FloatArray

if TYPE_CHECKING:
    from deltactl.models.rigid_chain import RigidChain

LOAD = PAYLOAD.name
"""The effect that is at the last link, and at no joint."""


@dataclass(frozen=True, slots=True)
class JointEffect:
    """One effect at a joint: the unit of its size, its text with {size}, {part} and {besides}."""

    key: str
    """What it is called among the regressors of a chain."""
    column: str
    """Column of a single axis with effort: its prior odds are those of a joint."""
    parameter: str
    unit: str
    text: str
    nothing: float = 0.0
    besides: str = ""
    """A second size,"""
    besides_unit: str = ""
    default: float | None = None
    """What a robot file means that leaves a size out; None where it may not."""

    @property
    def name(self) -> str:
        """The effect."""
        return column_of(f"effort/{self.column}")[0]

    @property
    def log_odds(self) -> float:
        """That a joint has it."""
        return column_of(f"effort/{self.column}")[1]

    @property
    def units(self) -> dict[str, str]:
        """Units of all its sizes at a joint that turns, by their names."""
        more = {self.besides: self.besides_unit} if self.besides else {}
        return {self.parameter: self.unit} | more

    def unit_of(self, slides: bool, name: str = "") -> str:
        """Unit of a size, or of the first, at a joint that turns or slides."""
        unit = self.units[name or self.parameter]
        return LINEAR_UNIT.get(unit, unit) if slides else unit


JOINT_EFFECTS = {
    row[0]: JointEffect(*row)
    for row in (
        ("dry", "friction", "torque", "N m", "dry (Coulomb) friction of {size} brakes {part}"),
        (
            *("viscous", "viscous", "coefficient", "N m s/rad"),
            "friction that grows with speed brakes {part} by {size}",
        ),
        ("rotor", "inertia", "inertia", "kg m2", "rotor and gear of {part} have {size}"),
        ("offset", "offset", "offset", "N m", "a constant effort of {size} is at {part}"),
        ("gain", "gain", "scale", "1", "{part} gives {size} times the effort of its column", 1.0),
        (
            *("lag", "lag", "time", "s"),
            "the effort of {part} acts late, with a time constant of {size} after a dead time of"
            " {besides}",
            *(0.0, "dead_time", "s", 0.0),
        ),
        ("dead", "lag", "dead_time", "s", "the effort of {part} acts {size} late"),
        (
            *("stribeck", "stribeck", "torque", "N m"),
            "friction of {part} is {size} higher near standstill and falls off within {besides}",
            *(0.0, "speed", "rad/s"),
        ),
        (
            *("limit", "limit", "limit", "N m"),
            *("{part} gives {size} at most, however much is asked of it", np.inf),
        ),
    )
}


def rotor_log_odds(stated: bool) -> float:
    """That a joint has a rotor that its model does not have; stated: whether that has one."""
    one = JOINT_EFFECTS["rotor"]
    return one.log_odds if stated else card_of(one.name).log_odds["unstated"]


def known_gains(robot: ChainRobot) -> FloatArray:
    """What each joint's drive gives of the effort of its column by the robot file, (joints,)."""
    one, made = JOINT_EFFECTS["gain"], np.ones(len(robot.joints))
    for entry in robot.effects:
        if entry.effect == one.name and entry.component in robot.joints:
            scale = float(np.mean(entry.parameters[one.parameter]))
            made[robot.joints.index(entry.component)] *= scale
    return made


def load_log_odds() -> float:
    """That the last link carries what the model does not have."""
    return card_of(LOAD).log_odds["joint"]


def load_moments(given: Mapping[str, float]) -> FloatArray:
    """Moments (10,) of a load by the parameters of a robot file: its mass is at its centre."""
    x, y, z = (given.get(f"centre_{axis}", 0.0) for axis in "xyz")
    moments = [1.0, x, y, z, x * x, y * y, z * z, x * y, x * z, y * z]
    return given.get("mass", 0.0) * np.array(moments)


def chain_effects(slides: Mapping[str, bool], tip: str) -> dict[str, EffectKind]:
    """Kinds by name, with their sentences; slides: of each joint whether it does. tip: the link
    that carries a load.
    """
    made: dict[str, EffectKind] = {}
    for one in JOINT_EFFECTS.values():
        made.setdefault(one.name, _kind(one, slides))
    parameters = (
        Parameter("mass", "kg", -1e4, 1e4),
        *(Parameter(f"centre_{axis}", "m", -10.0, 10.0, default=0.0) for axis in "xyz"),
    )
    made[LOAD] = EffectKind(
        LOAD, Port.PLATFORM, (tip,), parameters, SERVO_EFFECTS[LOAD].operate, _load_said
    )
    return pose_effects(slides) | made


def check_chain(robot: ChainRobot, chain: RigidChain) -> None:
    """What a robot file says of joints must be so of its model's. Raises ConfigError."""
    for joint, slides, rad in zip(chain.joints, chain.slides, robot.rad_per_count, strict=True):
        if slides and rad is not None:
            raise ConfigError(
                f"drive: joint '{joint}' slides, and a drive turns; give it null, and read its"
                " counts with --set NAME=COLUMN*METRES_A_COUNT"
            )
    kinds = chain_effects(dict.fromkeys(chain.joints, False), chain.tip)
    for entry in robot.effects:
        what, among = f"effect '{entry.effect}'", sorted(kinds)
        if entry.effect in kinds:
            what = f"component '{entry.component}' of {entry.effect}"
            among = list(kinds[entry.effect].components)
            if entry.component in among:
                continue
        raise ConfigError(f"effects: {what} must be one of {', '.join(among)}")


def _kind(one: JointEffect, slides: Mapping[str, bool]) -> EffectKind:
    def says(component: str, values: Mapping[str, Any]) -> str:
        slide = slides.get(component, False)
        shown = {name: said(float(values[name]), one.unit_of(slide, name)) for name in one.units}
        besides = shown.get(one.besides, "")
        return one.text.format(size=shown[one.parameter], part=component, besides=besides)

    parameters = tuple(
        Parameter(name, unit, -1e6, 1e6, default=one.default) for name, unit in one.units.items()
    )
    operate = next(iter(SERVO_EFFECTS.values())).operate
    return EffectKind(
        one.name, Port.GEAR, tuple(slides), parameters, operate, says, nothing=one.nothing
    )


def _load_said(component: str, values: Mapping[str, Any]) -> str:
    """The centre is that of the load, in the axes of the link's own frame."""
    mass = float(values["mass"])
    at = ", ".join(f"{float(values[f'centre_{axis}']):.2f}" for axis in "xyz")
    return (
        f"{component} carries {said(abs(mass), 'kg')} {'more' if mass > 0 else 'less'} than the"
        f" model says, centred at {at} m in its frame"
    )
