"""The drive pushes no harder than its limit: what is asked beyond it moves nothing."""

from __future__ import annotations

import numpy as np

from deltactl.models.effects.card import ByOperator, Confusion, Drawing, EffectCard, Words
from deltactl.models.effects.flow import Flow
from deltactl.models.effects.kind import (
    Discrepancy,
    EffectKind,
    Memory,
    Parameter,
    Port,
    Values,
    scalar,
)


def _operate(flow: Flow, index: int, values: Values, memory: Memory) -> None:
    limit = scalar(values, "limit")
    flow.angles_rad = np.clip(flow.angles_rad, -limit, limit)


def _ends(flow: Flow) -> tuple[float, float]:
    """From the largest force that is asked to its median: of a limit that cuts off most of the
    effort, what is left says nothing of the motion, and a mass and a weight of none fit it.
    """
    asked = np.abs(flow.angles_rad)
    return float(asked.max()), float(np.median(asked))


EFFECT = EffectKind(
    name="effort_limit",
    port=Port.MOTOR,
    components=("axis",),
    parameters=(Parameter("limit", "N m", 1e-9, 1e6, reciprocal=True),),
    operate=_operate,
    says=lambda component, v: f"the drive pushes no harder than {v['limit']:.4g} N m",
    # A motor's limit is one of the current; what gain it has comes after.
    order=0,
    smooth=False,
    nothing=float("inf"),
    # a limit of the current gives way with the motor's heat
    discrepancy=Discrepancy(0.001, 0.003),
)

CARD = EffectCard(
    name=EFFECT.name,
    on={"effort": EFFECT},
    says={"": "the drive pushes no harder than {limit}: effort beyond it moves nothing"},
    log_odds={
        # most logs hold the effort behind the limit, which shows nothing of it
        "effort/effort_limit": -3.0,
    },
    by_operator={"effort": ByOperator(_ends)},
    words=Words(
        noun="a limit of the force or torque of {part}",
        axis_regime="where more effort than the limit is asked",
    ),
    remedies={
        "": (
            "ask no more than {size} of {part} (accelerate more gently, carry less), or raise the "
            "limit in its drive: effort beyond it moves nothing"
        ),
    },
    drawing=Drawing(axis=("motor",)),
    left="gentler commands stay within it",
    confusions=(
        Confusion(
            "effort_gain",
            axis=(
                "make the same move at half the acceleration: a limit of the effort is gone there, "
                "a wrong scale of the effort is as large as before"
            ),
        ),
        Confusion(
            "inertia",
            axis=(
                "make the same move at half the acceleration: a limit of the effort is gone there, "
                "more inertia is not"
            ),
        ),
    ),
)
