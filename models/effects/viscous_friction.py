"""Friction in proportion to speed winds up a compliant shaft: the arm lags by c / k."""

from __future__ import annotations

from deltactl.models.effects.card import (
    Compensated,
    Coordinate,
    Drawing,
    EffectCard,
    Equal,
    Fit,
    Rule,
    Shape,
    Trait,
    Words,
)
from deltactl.models.effects.flow import Flow, effort_flow
from deltactl.models.effects.kind import (
    MOTORS,
    Discrepancy,
    EffectKind,
    Memory,
    Parameter,
    Port,
    Values,
    joints,
    scalar,
)


def _operate(flow: Flow, index: int, values: Values, memory: Memory) -> None:
    lag_s = scalar(values, "coefficient") / scalar(values, "stiffness")
    part = joints(index)
    flow.angles_rad[:, part] = flow.behind(flow.angles_rad[:, part], 0.0, lag_s, memory)


EFFECT = EffectKind(
    name="viscous_friction",
    port=Port.GEAR,
    components=MOTORS,
    parameters=(
        Parameter("coefficient", "N m s/rad", 0.0, 1e4, starts=(10.0,), step=1.0, typical=10),
        Parameter("stiffness", "N m/rad", 1.0, 1e7, starts=(1000.0,), default=1000.0),
    ),
    operate=_operate,
    says=lambda component, v: (
        f"viscous friction of {v['coefficient']:.3g} N m s/rad at {component} holds its arm back"
        f" (if the shaft has {v['stiffness']:.0f} N m/rad)"
    ),
    order=4,
    # acts through compliance
    discrepancy=Discrepancy(0.001, 0.012),
    # a first-order lag does the same, and is the commoner
    penalty=7.0,
)


def _on_axis(flow: Flow, index: int, values: Values, memory: Memory) -> None:
    flow.angles_rad -= scalar(values, "coefficient") * effort_flow(flow).velocity


ON_AXIS = EffectKind(
    name="viscous_friction",
    port=Port.GEAR,
    components=("axis",),
    parameters=(Parameter("coefficient", "N m s/rad", 0.0, 1e6, step=1e-3),),
    operate=_on_axis,
    says=lambda component, v: (
        f"friction of {v['coefficient']:.4g} N m s/rad grows with the speed of the axis"
    ),
    order=2,
)

CARD = EffectCard(
    name=EFFECT.name,
    kind=EFFECT,
    listed=4,
    on={"command": EFFECT, "effort": ON_AXIS},
    says={
        "": "friction of {coefficient} grows with the speed of the axis",
    },
    log_odds={
        # wears or is set by hand
        "effort/viscous": -1.0,
        # bearings and grease: by wear and warmth
        "joint": -1.0,
    },
    words=Words(
        noun="friction that grows with speed in {part}",
        axis="viscous friction in {part}",
        further="further viscous friction in {part}",
        regime="while {part} moves, in proportion to its speed",
        axis_regime="in motion, in proportion to speed",
    ),
    remedies={
        "": (
            "look at the grease and seals of {part} if {size} of viscous friction is more than its "
            "maker states; or enter it in the robot file"
        ),
        "slide/": (
            "look at the grease and seals of guides and screw of {part} if {size} of viscous "
            "friction is more than its maker states; or enter it in the robot file"
        ),
    },
    drawing=Drawing(motor="gear", axis=("bearing",)),
    traits=frozenset({Trait.ENTERED, Trait.FORCE, Trait.BEARING, Trait.WARMS}),
    rule=Rule.RATE,
    compensated=Compensated.AHEAD,
    fit=Fit(
        coordinates=(Coordinate("coefficient", step=2.0, low=0.0, high=1e4),),
        shapes=(Shape((0.0,), (0,), 20.0),),
        fixed={"stiffness": 1000.0},
    ),
    equals=(
        Equal(
            "following_lag",
            lambda drag, _: [{"time": drag["coefficient"] / drag["stiffness"], "dead_time": 0.0}],
        ),
    ),
)
