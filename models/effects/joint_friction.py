"""Bearing friction that winds up a compliant shaft before the arm moves.

In slow motion this is the play operator, its width twice the friction torque over the stiffness
(al-Bender 2005 on pre-sliding; reference sheet of the diagnosis). The shaft that friction winds up
also yields to gravity, by `stiffness`. `overshoot`: the arm swings on when its motor stops, by
speed times this, and leaves less of the shaft wound up.
"""

from __future__ import annotations

import numpy as np

from deltactl.models.effects import axis_play
from deltactl.models.effects.card import (
    Compensated,
    Confusion,
    Coordinate,
    Defect,
    Drawing,
    EffectCard,
    Fit,
    Rule,
    Shape,
    Trait,
    Words,
)
from deltactl.models.effects.flow import Flow, effort_flow, rub
from deltactl.models.effects.gear_backlash import PLAYS_RAD
from deltactl.models.effects.kind import (
    MOTORS,
    Discrepancy,
    EffectKind,
    Memory,
    Parameter,
    Port,
    Values,
    scalar,
)
from deltactl.models.effects.units_in_use import said
from deltactl.models.robot import EffectEntry, FloatArray
from deltactl.models.signals import clipped

FRICTION_OFF = 0.05
"""Share by which friction of a joint differs from what its model states: two days differ by 5 to
10 % with the warmth (UR10e)."""
OF_LOAD = 0.1
"""Friction that a gear has for each unit of its load, beside what it has at the usual load.
Measured: 0.063 and 0.148 (strain wave gears eRob80, 50:1 and 100:1), 0.108 (Dynamixel MX-106; all
three: parameters m3 of github.com/Rhoban/bam), 0.06 (joints 2 and 3 of a UR10e, by a fit to its
recording). Their root mean square is 0.095."""
YIELDS_OVER = (1e-4, 3e-4, 1e-3)
"""Ways over which bearings yield before they slide, as shares of the travel (a harmonic drive:
minutes of arc). What one way alone misses passes for inertia,"""
YIELDING = 0.1
"""and the friction that does, as a share of all effort; what the model states does, too."""


def _brake(flow: Flow, index: int, values: Values, memory: Memory) -> None:
    flow = effort_flow(flow)
    torque, asymmetry = scalar(values, "torque"), scalar(values, "asymmetry")
    rub(flow, torque * (flow.direction + asymmetry), torque)


BY_EFFORT = EffectKind(
    name="joint_friction",
    port=Port.GEAR,
    components=("axis",),
    parameters=(
        Parameter("torque", "N m", 0.0, 1e5, step=1e-3),
        Parameter("asymmetry", "1", -1.0, 1.0, step=0.01, default=0.0),
    ),
    operate=_brake,
    says=lambda component, v: f"dry (Coulomb) friction of {v['torque']:.4g} N m brakes the axis",
    order=3,
    smooth=False,
)


def without_swing(entry: EffectEntry) -> EffectEntry:
    """The same effect of arms whose motors do not stop dead.

    The swing is found from stops, in readings 20 ms apart. In samples as near as single steps, or
    timed by whole ticks, a slow motor seems to stop at every one.
    """
    kept = {name: size for name, size in entry.parameters.items() if name != "overshoot"}
    return entry.model_copy(update={"parameters": kept})


def _operate(flow: Flow, index: int, values: Values, memory: Memory) -> None:
    driven = flow.angles_rad[:, index] + _overshoot(flow, index, scalar(values, "overshoot"))
    half, asymmetry = 0.5 * scalar(values, "width"), scalar(values, "asymmetry")
    low, high = driven - half * (1.0 + asymmetry), driven + half * (1.0 - asymmetry)
    start = driven + half * scalar(values, "start")
    low[flow.fresh] = high[flow.fresh] = start[flow.fresh]
    arm = clipped(np.zeros_like(driven), low, high, float(memory.get("arm", start[0])))
    memory["arm"] = arm[-1]
    flow.angles_rad[:, index] = arm + flow.load.torque_nm[:, index] / scalar(values, "stiffness")


def _overshoot(flow: Flow, index: int, time_s: float) -> FloatArray:
    """How far a free arm would swing past a motor that slows down, shape (n,).

    At steady speed the wound shaft balances the friction: when the motor stops, the arm goes on
    until the shaft has taken up its energy, speed x sqrt(inertia / stiffness) further.
    """
    driven = flow.angles_rad[:, index]
    if time_s <= 0.0:
        return np.zeros_like(driven)
    speed = np.diff(driven, prepend=driven[0]) / np.maximum(flow.step_s, 1e-12)
    speed[flow.step_s <= 0.0] = 0.0
    before, after = np.roll(speed, 1), np.append(speed[1:], 0.0)
    before[0] = 0.0
    # A motor that stops within a sample seems to slow down over two.
    peak = np.maximum(np.abs(speed), np.where(speed * before > 0.0, np.abs(before), 0.0))
    swung: FloatArray = time_s * np.sign(speed) * np.maximum(peak - np.sign(speed) * after, 0.0)
    return np.where(np.abs(after) < 0.5 * peak, swung, 0.0)


EFFECT = EffectKind(
    name="joint_friction",
    port=Port.GEAR,
    components=MOTORS,
    parameters=(
        Parameter("width", "rad", 0.0, 0.2, starts=(0.004,), typical=0.003),
        Parameter("asymmetry", "1", -1.0, 1.0, step=0.05, default=0.0),
        Parameter("start", "1", -1.0, 1.0, step=0.1, default=0.0),
        Parameter("overshoot", "s", 0.0, 0.1, step=5e-4, default=0.0, spread=0.01),
        Parameter("stiffness", "N m/rad", 1e3, float("inf"), default=float("inf"), spread=0.0003),
    ),
    operate=_operate,
    says=lambda component, v: (
        f"friction in the bearing of {component} winds its shaft up by "
        f"{said(v['width'], 'rad')} between the two directions"
    ),
    order=3,
    smooth=False,
    # Breaks loose, creeps, changes with load and speed
    discrepancy=Discrepancy(0.001, 0.012),
    # How far a friction-bound arm swings on comes free: where play and friction fit
    # alike, the play would have to stick like friction
    penalty=-4.0,
)

CARD = EffectCard(
    name=EFFECT.name,
    kind=EFFECT,
    listed=3,
    on={"command": axis_play.FRICTION, "effort": BY_EFFORT},
    says={
        "": "friction holds the axis back by {width} in all between its two directions",
        "effort": "dry (Coulomb) friction of {torque} brakes the axis, always against its motion",
    },
    log_odds={
        # wears or is set by hand; without a known load, stiction is what a servo's loop leaves
        "pulled/friction": -1.0,
        "pulled/rubbing": -1.0,
        "servo/play": -1.0,
        "effort/friction": -1.0,
        # bearings and grease: by wear and warmth
        "joint": -1.0,
    },
    words=Words(
        noun="bearing friction in {part}",
        axis="dry friction in {part}",
        further="further dry friction in {part}",
        regime="after reversals of {part}",
        axis_regime="in motion and after reversals",
        gap="the gap that friction leaves between its two directions",
        sizes={"width": "difference between the two directions"},
    ),
    remedies={
        "": (
            "free the bearings of {part} (look for what rubs, clean, grease) if {size} of friction "
            "is more than its maker states; or enter it in the robot file"
        ),
        "width": (
            "free the bearings of {part} (look for what rubs, clean, grease): friction keeps its "
            "two directions {size} apart; or enter it in the robot file"
        ),
        "servo_axis/width": (
            "look for what rubs at {part}, raise the gain of its position control, or come to each "
            "place from the same side: its two directions end {size} apart"
        ),
        "slide/": (
            "free the guides and the screw or belt of {part} (look for what rubs, clean, grease) if"
            " {size} of friction is more than its maker states; or enter it in the robot file"
        ),
        "slide/width": (
            "free the guides of {part} (clean, grease), tension the belt, or come to each place "
            "from the same side; where a servo drives it, raise its gain: its two directions end "
            "{size} apart"
        ),
    },
    drawing=Drawing(motor="gear", axis=("bearing",)),
    traits=frozenset({Trait.HYSTERESIS, Trait.ENTERED, Trait.FORCE, Trait.BEARING, Trait.WARMS}),
    rule=Rule.SUM,
    compensated=Compensated.AT_REVERSALS,
    confusions=(
        Confusion(
            "stribeck_friction",
            axis="move at several steady speeds, the slowest just above standstill",
        ),
        Confusion(
            "viscous_friction",
            axis="move at several steady speeds, slow and fast",
        ),
    ),
    fit=Fit(
        coordinates=(
            Coordinate("width", step=3e-4, low=0.0, high=0.2),
            Coordinate("stiffness", "reciprocal", step=2e-5, low=0.0, high=1e-3),
            Coordinate("overshoot", step=5e-4, low=0.0, high=0.02),
        ),
        shapes=tuple(Shape((0.0, 0.0, 0.0), (0,), width) for width in PLAYS_RAD),
        fixed={"asymmetry": 0.0, "start": 0.0},
    ),
    defect=Defect("friction in the bearings of motor 1", "motor1", {"width": 0.02}, 2),
    slide_names={"torque": "force"},
)
