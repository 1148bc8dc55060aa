"""The drive turns no faster than its limit, falls behind, and makes up for it at that speed.

A servo saturates, a stepper's controller holds back its pulses, a slicer's feed rate is capped
(Astrom and Hagglund 2006, Advanced PID Control, section 3.5).
"""

from __future__ import annotations

import numpy as np

from deltactl.models.effects.card import Drawing, EffectCard, Words
from deltactl.models.effects.flow import Flow
from deltactl.models.effects.kind import EffectKind, Memory, Parameter, Port, Values, scalar
from deltactl.models.robot import FloatArray

CHUNK = 64
"""Rows that are looked at in one go while the axis is behind."""


def rate_limited(
    asked: FloatArray, step_s: FloatArray, limit: float, before: float, speed: float = 0.0
) -> FloatArray:
    """Follow a motion (n,) no faster than `limit`; a step of 0 s starts afresh where it is asked.

    before: where the axis was at the row before the first. speed: of the motion until there.
    """
    most = limit * step_s
    late = most - _behind_within(asked, step_s, limit, before, speed)
    at, done = asked.copy(), 0
    too_fast = np.abs(np.diff(asked, prepend=before)) > late
    for first in np.flatnonzero(too_fast & (step_s > 0.0)).tolist():
        if first < done:
            continue
        done, here = first, float(at[first - 1]) if first else before
        ahead = np.append(late[first], most[first + 1 : first + CHUNK])
        done, here = _made_up(asked, at, ahead, done, here)
        while done < len(at) and step_s[done] > 0.0 and abs(asked[done] - here) > most[done]:
            done, here = _made_up(asked, at, most[done:], done, here)
    return at


def _behind_within(
    asked: FloatArray, step_s: FloatArray, limit: float, before: float, speed: float
) -> FloatArray:
    """How far the axis falls behind (n,) where the motion reaches the limit between two rows.

    The acceleration is steady there; it is that of the speeds at both rows, each between the mean
    speeds before and after it.
    """
    speeds = np.diff(asked, prepend=before) / np.where(step_s > 0.0, step_s, np.inf)
    mean, lasts_s = np.array([speed, *speeds, speeds[-1]]), np.pad(step_s, 1, "edge")
    both_s = np.maximum(lasts_s[:-1] + lasts_s[1:], 1e-300)
    at_rows = (mean[:-1] * lasts_s[1:] + mean[1:] * lasts_s[:-1]) / both_s
    gained = np.sign(speeds) * np.diff(at_rows)
    until = limit - np.abs(speeds) + 0.5 * gained
    within = (until > 0.0) & (until < gained)
    rise = np.where(within, gained, 1.0)
    behind: FloatArray = np.where(within, 0.5 * until**2 * step_s / rise, 0.0)
    return behind


def _made_up(
    asked: FloatArray, at: FloatArray, most: FloatArray, first: int, here: float
) -> tuple[int, float]:
    """Fill in `at` while the axis is behind; the row after, and where the axis is before it.

    most: how far it comes in each row from the first on.
    """
    part = slice(first, first + CHUNK)
    way = 1.0 if asked[first] > here else -1.0
    reached = here + way * np.cumsum(most[:CHUNK])
    ended = (way * (asked[part] - reached) <= 0.0) | (most[:CHUNK] <= 0.0)
    count = int(np.argmax(ended)) if ended.any() else len(reached)
    at[first : first + count] = reached[:count]
    return first + count, float(reached[count - 1])


def _operate(flow: Flow, index: int, values: Values, memory: Memory) -> None:
    asked = flow.angles_rad[:, 0]
    before, speed = memory.get("at", float(asked[0])), memory.get("speed", 0.0)
    limited = rate_limited(asked, flow.step_s, scalar(values, "limit"), before, speed)
    last, step_s = np.append(memory.get("asked", asked[0]), asked)[-2:], float(flow.step_s[-1])
    memory["speed"] = float(last[1] - last[0]) / step_s if step_s > 0.0 else 0.0
    memory["at"], memory["asked"] = float(limited[-1]), float(asked[-1])
    flow.angles_rad = limited[:, None]


EFFECT = EffectKind(
    name="speed_limit",
    port=Port.MOTOR,
    components=("axis",),
    parameters=(Parameter("limit", "rad/s", 1e-9, 1e6, step=1e-3),),
    operate=_operate,
    says=lambda component, v: f"the drive moves at {v['limit']:.4g} rad/s at most",
    order=1,
    smooth=False,
)

CARD = EffectCard(
    name="speed_limit",
    on={"command": EFFECT},
    says={"": "the drive moves at {limit} at most, however fast it is commanded"},
    log_odds={
        # commands are mostly planned within what the drive can do
        "command/speed": -3.0,
    },
    words=Words(
        noun="a limit of the speed of {part}",
        axis_regime="where the command is fastest, and while the axis makes up for it",
    ),
    remedies={
        "": (
            "command {part} more slowly, or raise the limit of its drive: it moves at {size} at "
            "most"
        ),
    },
    drawing=Drawing(axis=("motor",)),
)
