"""Backlash in the gearbox.

Inside the play the arm is held by nothing but its bearing: gravity pulls it towards one flank,
drag (proportional to speed) and friction keep it back. A slow arm therefore hangs on one flank
all the time and the play looks like an offset; a fast motor runs ahead of the falling arm to
the other flank, and the arm falls back once the motor rests. With more friction than gravity
the arm stays where it was pushed: the pure play operator. The flanks yield to what they carry,
gravity less drag, by `stiffness`. The arm's inertia is not modelled.
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
    Equal,
    Fit,
    Rule,
    Shape,
    StandIn,
    Trait,
    Words,
)
from deltactl.models.effects.flow import Flow
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
from deltactl.models.robot import FloatArray
from deltactl.models.signals import clipped

STAYS = 1e4
"""Drag at which the arm stays in the play wherever it was left."""
PLAYS_RAD = (0.0025, 0.006, 0.015)
"""Widths of play and of friction that a fit starts at: from what a good gear has to what one sees
by eye, apart by a factor of two and a half."""
STICKS = 200.0
"""A drag from here on [N m s/rad] only represents an arm that stays where it is pushed."""


def _operate(flow: Flow, index: int, values: Values, memory: Memory) -> None:
    driven = flow.angles_rad[:, index]
    half = 0.5 * scalar(values, "width")
    torque = flow.load.torque_nm[:, index]
    pull = np.sign(torque) * np.maximum(np.abs(torque) - scalar(values, "friction"), 0.0)
    drag = max(scalar(values, "drag"), 1e-6)
    low, high = driven - half, driven + half
    fresh = flow.fresh
    low[fresh] = high[fresh] = driven[fresh] + half * np.sign(pull[fresh])
    before = memory.get("arm", driven[0] + half * np.sign(pull[0]))
    arm = clipped(pull / drag * flow.step_s, low, high, float(before))
    speed = np.diff(arm, prepend=before) / np.maximum(flow.step_s, 1e-12)
    speed[flow.step_s <= 0.0] = 0.0
    memory["arm"] = arm[-1]
    flow.angles_rad[:, index] = arm + (torque - drag_on_teeth(drag, speed)) / scalar(
        values, "stiffness"
    )


def drag_on_teeth(drag: float, speed: FloatArray) -> FloatArray:
    """Torque that the drag of a moving arm puts on the teeth; none where drag means 'sticks'."""
    return drag * speed if drag < STICKS else np.zeros_like(speed)


EFFECT = EffectKind(
    name="gear_backlash",
    port=Port.GEAR,
    components=MOTORS,
    parameters=(
        Parameter("width", "rad", 0.0, 0.2, starts=(0.004,), typical=0.005),
        Parameter(
            "drag",
            "N m s/rad",
            1e-3,
            1e4,
            starts=(8.0, 20.0, 1e4),
            step=1.0,
            default=10.0,
            spread=1.5,
        ),
        Parameter("friction", "N m", 0.0, 100.0, step=0.05, default=0.0),
        Parameter("stiffness", "N m/rad", 1e3, float("inf"), default=float("inf"), spread=0.0003),
    ),
    operate=_operate,
    says=lambda component, v: (
        f"the gear or coupling of {component} has {said(v['width'], 'rad')} of backlash at the arm"
    ),
    order=2,
    smooth=False,
    # inside the play, friction and inertia decide
    discrepancy=Discrepancy(0.001, 0.012),
    itself={"width": (3e-4, float("inf"))},  # with less play it only yields
)

CARD = EffectCard(
    name=EFFECT.name,
    kind=EFFECT,
    listed=2,
    on={"command": axis_play.BACKLASH},
    says={
        "": "between drive and axis there is backlash of {width} in all",
    },
    log_odds={
        # wears or is set by hand; without a known load, tooth play is what a geared stepper has
        "pulled/play": -1.0,
        "stepper/play": -1.0,
        # arms are preloaded
        "pose/play": -2.5,
        "pose/hang": -4.0,
    },
    words=Words(
        noun="backlash in the gear or coupling of {part}",
        axis="backlash between drive and load of {part}",
        several="backlash in the gears or couplings of {part}",
        further="further play of {part}",
        regime="after reversals and stops of {part}",
        axis_regime="after reversals",
        gap="the play",
    ),
    remedies={
        "": (
            "take up the play of {part} ({size} at its output): tighten coupling and set screws; if"
            " it stays, replace the gear"
        ),
        "axis/": (
            "take up the play of {part} ({size} at its output) at coupling, set screws and gear; or"
            " come to each place from the same side"
        ),
        "chain/": (
            "take up the play of {part} ({size} at its output) at its gear, or come to each place "
            "from the same side"
        ),
        "servo_axis/": (
            "see first whether the drive of {part} has a dead zone, and narrow it, or raise its P "
            "gain: within a dead zone a servo does not correct, which looks the same as play "
            "({size}). What stays is play: take it up at horn, coupling, set screws and gear; or "
            "come to each place from the same side"
        ),
        "slide/": (
            "take up the play of {part} ({size}): preload or replace the nut of the screw, tension "
            "the belt, tighten coupling and pulleys; or set it as the backlash of the controller, "
            "or come to each place from the same side"
        ),
    },
    drawing=Drawing(motor="gear", axis=("gear",)),
    traits=frozenset({Trait.BEHIND_READING, Trait.HYSTERESIS}),
    rule=Rule.SUM,
    compensated=Compensated.AT_REVERSALS,
    confusions=(
        Confusion(
            "joint_friction",
            stands_in={
                # tooth play is what a geared stepper has
                "stepper/play": StandIn(-1.4),
                # what stiction leaves a servo's loop is a little more frequent
                "servo/play": StandIn(-0.2),
            },
            exactly=True,  # where the arm stays in the play where it is pushed
            axis=(
                "repeat the motion with a weight that always pulls one way (play closes, friction "
                "stays){or_effort}"
            ),
            delta=(
                "A rest after approaching from both sides, another payload, or the motor "
                "current would distinguish play from friction."
            ),
            by_hand=(
                "record the motor current (friction draws more of it, play does not), or hang 0.5 "
                "kg on the platform and repeat the run: a load that always pulls one way hides "
                "play, friction stays"
            ),
            effort=0,
        ),
        Confusion(
            "home_offset",
            axis="come to the same places from both sides: play shows twice, an offset once",
            by_hand=(
                "turn the arm by hand while its motor holds: play can be felt, a wrong home cannot"
            ),
            effort=5,
        ),
    ),
    fit=Fit(
        coordinates=(
            Coordinate("width", step=3e-4, low=0.0, high=0.2),
            Coordinate("drag", "log", step=0.05, low=np.log(0.1), high=np.log(STAYS)),
            Coordinate("stiffness", "reciprocal", step=2e-5, low=0.0, high=1e-3),
        ),
        # Drags [N m s/rad] against which the load pulls the arm through its play.
        shapes=tuple(
            Shape((0.0, float(np.log(drag)), 0.0), (0,), width)
            for drag in (5.0, 10.0, 25.0, STAYS)
            for width in PLAYS_RAD
        ),
        fixed={"friction": 0.0},
    ),
    defect=Defect("backlash in the gearbox of motor 1", "motor1", {"width": 0.02}, 1),
    equals=(
        # play that always hangs on the same flank
        Equal(
            "home_offset",
            lambda play, _: [{"angle": side * (0.5 * play["width"])} for side in (1.0, -1.0)],
        ),
    ),
)
