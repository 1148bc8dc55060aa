"""What can be wrong with where a chain of joints is: effects of the vocabulary, at each joint.

Angles are at the joint's output, true less read (or commanded, where nothing is read). Each effect
has sizes in which the angle is linear, and parameters that people know.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass
from typing import Any

import numpy as np

from deltactl.models.effects import column_of
from deltactl.models.effects.kind import EffectKind, Parameter, Port
from deltactl.models.effects.link_geometry import OFF
from deltactl.models.effects.link_geometry import says as geometry_says
from deltactl.models.effects.lone_axis import LINEAR_UNIT
from deltactl.models.effects.servo_joints import SERVO_EFFECTS
from deltactl.models.effects.units_in_use import said
from deltactl.models.robot import FloatArray

SENSORS, MISSING, LATE = "sensors", "share_of_last_move", "time"
"""The component of what is wrong with the poses that were read, and with no joint."""
Given = Mapping[str, Any]
WAVE = (("amplitude", "rad"), ("period", "rad"), ("phase", "rad"))


@dataclass(frozen=True, slots=True)
class PoseEffect:
    """One effect: its parameters with their units, its text with {size} and {part}, and the sizes
    (k,) of its columns by the parameters of a robot file.
    """

    key: str
    parameters: tuple[tuple[str, str], ...]
    text: str
    from_file: Callable[[Given], FloatArray]
    spread: float
    """Usual size [rad or m]; of what yields, at the largest weight."""
    positive: bool = False
    """Whether no joint has less than none of it."""
    nothing: float = 0.0

    def of_size(self, size: FloatArray) -> FloatArray:
        """The parameter by the size of its column; of what yields, by its reciprocal."""
        if np.isinf(self.nothing):
            return 1.0 / np.where(size == 0.0, 1e-300, size)
        return np.asarray(self.nothing + size)

    @property
    def name(self) -> str:
        """The effect."""
        return column_of(f"pose/{self.key}")[0]

    @property
    def log_odds(self) -> float:
        """That a joint has it."""
        return column_of(f"pose/{self.key}")[1]


def _plain(name: str) -> Callable[[Given], FloatArray]:
    return lambda given: np.array([float(given.get(name, 0.0))])


def _phasor(given: Given) -> FloatArray:
    """Sine and cosine part of a wave."""
    size, phase = float(given["amplitude"]), float(given.get("phase", 0.0))
    return size * np.array([np.cos(phase), np.sin(phase)])


def _ratio(given: Given) -> FloatArray:
    return np.array([float(given.get("scale", 1.0)) - 1.0])


def _yielding(given: Given) -> FloatArray:
    return np.array([1.0 / float(given["stiffness"])])


def _off(given: Given) -> FloatArray:
    """Shift and turn."""
    return np.array([float(given.get(name, 0.0)) for name in OFF])


GEAR_WAVE = "the gear or encoder of {part} has a periodic error of {size} every {period}"
YIELDS = "{part} yields under weight, with a stiffness of {size}"
PLAYS = "{part} has play of {size}: where it rests depends on the way it came"
HANGS = "{part} has play of {size}: it hangs to the side that its weight pulls"
BENDS = "the bearing or link at {part} bends under weight by {size}"
WINDS = "{part} is nearer its command than its encoder says, by {size} of what is between them"
LATE_BY = "places are read {time} later than angles"
SWINGS = "poses are read when {size} of the last move is yet to come"
OFFS = tuple((name, "m" if name.startswith("d") else "rad") for name in OFF)
ZERO, RATIO = "the zero of {part} is off by {size}", "{part} moves {size} times as far as it should"
POSE_EFFECTS = {
    one.key: one
    for one in (
        # a mark on a joint, set by eye
        PoseEffect("home", (("angle", "rad"),), ZERO, _plain("angle"), 1e-2),
        # castings that were bolted together
        PoseEffect("geometry", OFFS, "", _off, 2e-3),
        PoseEffect("droop", (("stiffness", "N m/rad"),), YIELDS, _yielding, 2e-3, True, np.inf),
        PoseEffect("windup", (("share", "1"),), WINDS, _plain("share"), 1.0),
        # an encoder's disc or a gear's ring that runs out of centre
        PoseEffect("wave", WAVE, GEAR_WAVE, _phasor, 1e-3),
        PoseEffect("second", WAVE, GEAR_WAVE, _phasor, 1e-3),
        # gears that are not preloaded
        PoseEffect("play", (("width", "rad"),), PLAYS, _plain("width"), 1e-3, True),
        PoseEffect("rest", ((MISSING, "1"), (LATE, "s")), SWINGS, _plain(MISSING), 0.05, True),
        PoseEffect("ratio", (("scale", "1"),), RATIO, _ratio, 1e-3, nothing=1.0),
        # a strain wave gear
        PoseEffect("gear", WAVE, GEAR_WAVE, _phasor, 3e-4),
        PoseEffect("bend", (("compliance", "rad/(N m)"),), BENDS, _plain("compliance"), 2e-3, True),
        PoseEffect("hang", (("width", "rad"),), HANGS, _plain("width"), 1e-3, True),
    )
}
"""By key, the commonest first: of few poses only these are part of the set that shows the noise."""


def pose_effects(slides: Mapping[str, bool]) -> dict[str, EffectKind]:
    """Kinds by name, with their sentences; slides: of each joint whether it does."""
    made: dict[str, EffectKind] = {}
    for one in POSE_EFFECTS.values():
        made.setdefault(one.name, _kind(one, slides))
    return made


def _kind(one: PoseEffect, slides: Mapping[str, bool]) -> EffectKind:
    def says(component: str, values: Given) -> str:
        if one.key == "geometry":
            return geometry_says(component, values)
        shown = {}
        for name, unit in one.parameters:
            unit = LINEAR_UNIT.get(unit, unit) if slides.get(component, False) else unit
            shown[name] = said(float(values.get(name, np.nan)), unit)
        text = LATE_BY if one.key == "rest" and values.get(LATE) else one.text
        return text.format(size=shown[one.parameters[0][0]], part=component, **shown)

    parameters = tuple(
        Parameter(name, unit, -1e12, 1e12, default=0.0 if place else None)
        for place, (name, unit) in enumerate(one.parameters)
    )
    operate = next(iter(SERVO_EFFECTS.values())).operate
    components = (SENSORS,) if one.key == "rest" else tuple(slides)
    return EffectKind(
        one.name, Port.ARM, components, parameters, operate, says, nothing=one.nothing
    )
