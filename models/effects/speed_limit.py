"""The drive goes no faster than its limit: what is asked beyond that, it makes up for afterwards.

The axis is as near to its command as the limit lets it come. A command that is straight between
samples is followed exactly.
"""

from __future__ import annotations

import numpy as np

from deltactl.models.effects.card import ByOperator, Confusion, Drawing, EffectCard, Words
from deltactl.models.effects.flow import BoolArray, Flow
from deltactl.models.effects.kind import (
    Discrepancy,
    EffectKind,
    Memory,
    Parameter,
    Port,
    Values,
    joints,
    scalar,
)
from deltactl.models.robot import FloatArray


def _operate(flow: Flow, index: int, values: Values, memory: Memory) -> None:
    part, limit = joints(index), scalar(values, "limit")
    asked = flow.angles_rad[:, part]
    before = memory.get("at", asked[0])
    reach = limit * flow.step_s
    starts = flow.fresh
    followed = [
        _within_reach(column, reach, starts, float(last))
        for column, last in zip(asked.T, before, strict=True)
    ]
    flow.angles_rad[:, part] = np.stack(followed, axis=1)
    memory["at"] = flow.angles_rad[-1, part].copy()


def _within_reach(
    asked: FloatArray, reach: FloatArray, fresh: BoolArray, before: float
) -> FloatArray:
    """As near to what is asked (n,) as a way of `reach` (n,) from row to row allows."""
    if not (np.abs(np.diff(asked, prepend=before)) > reach)[~fresh].any():
        return asked
    at, out = before, []
    for target, most, begins in zip(asked.tolist(), reach.tolist(), fresh.tolist(), strict=True):
        missing = target - at
        at = target if begins or -most <= missing <= most else at + (most if missing > 0 else -most)
        out.append(at)
    return np.array(out)


SLOWEST = 0.2
"""Share of the top speed: a command in steps asks for any speed, and there a lag is simpler."""


def _ends(flow: Flow) -> tuple[float, float]:
    """From the top speed of what is asked."""
    moves = flow.step_s > 0.0
    ways = np.abs(np.diff(flow.angles_rad[:, 0], prepend=flow.angles_rad[0, 0]))
    fastest = float(np.max(ways[moves] / flow.step_s[moves], initial=0.0))
    return fastest, SLOWEST * fastest


EFFECT = EffectKind(
    name="speed_limit",
    port=Port.MOTOR,
    components=("axis",),
    parameters=(Parameter("limit", "rad/s", 1e-9, 1e6, reciprocal=True),),
    operate=_operate,
    says=lambda component, v: f"{component} goes no faster than {v['limit']:.4g} rad/s",
    order=1,
    smooth=False,
    nothing=float("inf"),
    # a loop eases off before it has caught up
    discrepancy=Discrepancy(0.001, 0.003),
)

CARD = EffectCard(
    name=EFFECT.name,
    on={"command": EFFECT},
    says={"": "the axis goes no faster than {limit}, and falls behind where more is asked"},
    log_odds={
        # most commands are planned within what the maker of the drive states
        "command/speed_limit": -3.0,
    },
    by_operator={"command": ByOperator(_ends)},
    words=Words(
        noun="a limit of the speed of {part}",
        axis_regime="in fast motion, and until it has caught up",
    ),
    remedies={
        "": (
            "command {part} no faster than {size}, or raise the limit in its drive (its voltage "
            "bounds it as well): where more is asked it falls behind"
        ),
    },
    drawing=Drawing(axis=("motor",)),
    left="slower commands stay within it",
    confusions=(
        Confusion(
            "following_lag",
            axis=(
                "make the same move at a quarter of the speed: a limit of the speed is gone there, "
                "a lag is as long as before"
            ),
        ),
        Confusion(
            "gear_ratio",
            axis="make the same move at a quarter of the speed: a ratio stays as it is",
        ),
    ),
)
