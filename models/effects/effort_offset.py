"""The effort holds a constant that moves nothing.

inertia * acceleration = effort - friction - offset, the sign in which identification papers give
it (Janot, Gautier and Brunot 2019, EMPS: equation 1).
"""

from __future__ import annotations

from deltactl.models.effects.card import Confusion, Drawing, EffectCard, StandIn, Trait, Words
from deltactl.models.effects.flow import Flow
from deltactl.models.effects.kind import EffectKind, Memory, Parameter, Port, Values, scalar

ZERO_OFF = 0.01
"""Share of the usual effort by which a current sensor's zero is off: its total error is 1.5 %
(ACS712, data sheet, at 25 degrees)."""


def _operate(flow: Flow, index: int, values: Values, memory: Memory) -> None:
    flow.angles_rad -= scalar(values, "offset")


EFFECT = EffectKind(
    name="effort_offset",
    port=Port.MOTOR,
    components=("axis",),
    parameters=(Parameter("offset", "N m", -1e5, 1e5, step=1e-3),),
    operate=_operate,
    says=lambda component, v: f"{v['offset']:+.4g} N m of the effort move nothing",
    order=2,
)

CARD = EffectCard(
    name="effort_offset",
    on={"effort": EFFECT},
    says={
        "": (
            "a constant {offset} of the effort is there whichever way the axis moves: it holds "
            "against a weight or a slope, or the effort's zero is off"
        ),
    },
    log_odds={
        # an amplifier's zero, or a weight that the file leaves out
        "effort/offset": -2.0,
        # drives are calibrated where they are made
        "joint": -3.0,
    },
    words=Words(
        noun="a constant force or torque on {part}",
        axis_regime="everywhere, as a constant force",
    ),
    remedies={
        "": (
            "balance {part}, enter the load in the robot file (`gravity`), or correct the zero of "
            "its effort: the same {size} is there whichever way it moves"
        ),
        "beside": (
            "find out first what of the effort follows the speed, at slow speeds both ways; balance"
            " {part}, or correct the zero of its effort, only by what stays there: the {size} found"
            " are what the speeds of this recording have in common"
        ),
    },
    drawing=Drawing(axis=("load",)),
    traits=frozenset({Trait.FORCE, Trait.CONSTANT_FORCE, Trait.SIGNED}),
    confusions=(
        Confusion(
            "joint_friction",
            stands_in={
                # friction that differs between both ways by as much: rare
                "effort/offset": StandIn(-2.5),
            },
            axis=(
                "pull the resting axis either way with a spring balance: friction that differs by "
                "direction shows there, an offset of the effort does not"
            ),
            called="{phrase} that is stronger one way",
        ),
    ),
)
