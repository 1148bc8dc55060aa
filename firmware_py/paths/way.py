"""Straight legs and level arcs from point to point, with corners cut by no more than is allowed.

A corner is replaced by a parabola that leaves one leg and meets the next one at the same distance
from it. Its middle is nearest to the corner: that distance is `corner_m`, or less where the legs
are short. Without it, and at every dwell, the arms come to a stand at the corner.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from firmware_py.paths.path import Path, Space, intervals, line
from models.robot import FloatArray

STRAIGHT_RAD = math.radians(0.5)
"""Legs that meet at less than this go on into each other without a stop."""


@dataclass(frozen=True, slots=True)
class Leg:
    """One leg: to a point [m], straight or on an arc about a vertical axis through `centre_m`.

    turns: of an arc, whole turns and the part of one, positive counter-clockwise from above; None
    for a straight leg. speed_mps: inf for the job's. dwell_s: at its end.
    """

    to_m: FloatArray
    speed_mps: float = math.inf
    dwell_s: float = 0.0
    centre_m: FloatArray | None = None
    turns: float | None = None


def way(start_m: FloatArray, legs: Sequence[Leg], corner_m: float, spacing_m: float) -> Path:
    """All legs one after another, sampled at most `spacing_m` apart."""
    starts = [start_m, *(leg.to_m for leg in legs[:-1])]
    ways = [_sampled(begin, leg, spacing_m) for begin, leg in zip(starts, legs, strict=True)]
    parts: list[FloatArray] = [ways[0][:1]]
    speeds: list[FloatArray] = [np.full(1, np.inf)]
    rests, dwells = [0], [0.0]
    for number, leg in enumerate(legs):
        own = ways[number]
        following = ways[number + 1] if number + 1 < len(legs) else None
        cut = _cut(own, leg, following, legs[number + 1 : number + 2], corner_m, spacing_m)
        if cut is not None:
            own, bend, rest_of_next = cut
            assert following is not None
            ways[number + 1] = rest_of_next
            slower = min(leg.speed_mps, legs[number + 1].speed_mps)
        parts.append(own[1:])
        speeds.append(np.full(len(own) - 1, leg.speed_mps))
        if cut is not None:
            parts.append(bend[1:])
            speeds.append(np.full(len(bend) - 1, slower))
        elif following is None or leg.dwell_s > 0.0 or _turn(own, following) > STRAIGHT_RAD:
            rests.append(sum(map(len, parts)) - 1)
            dwells.append(leg.dwell_s)
    targets = np.concatenate(parts)
    rest = np.zeros(len(targets), dtype=np.bool_)
    rest[rests] = True
    dwell_s = np.zeros(len(targets))
    dwell_s[rests] = dwells
    return Path(
        space=Space.CARTESIAN,
        targets=targets,
        dwell_s=dwell_s,
        rest=rest,
        way_back=line(targets[-1], targets[0], spacing_m)[1:-1],
        speed_mps=np.concatenate(speeds),
    )


def target_count(start_m: FloatArray, legs: Sequence[Leg], spacing_m: float) -> int:
    """At most how many targets there are."""
    total, begin = 1, start_m
    for leg in legs:
        total += intervals(_length_m(begin, leg), spacing_m)
        begin = leg.to_m
    return total


def _length_m(begin: FloatArray, leg: Leg) -> float:
    if leg.centre_m is None or leg.turns is None:
        return math.dist(begin, leg.to_m)
    radius = math.hypot(*(begin - leg.centre_m)[:2])
    return math.hypot(2.0 * math.pi * radius * leg.turns, float(leg.to_m[2] - begin[2]))


def _sampled(begin: FloatArray, leg: Leg, spacing_m: float) -> FloatArray:
    if leg.centre_m is None or leg.turns is None:
        return line(begin, leg.to_m, spacing_m)
    part = np.linspace(0.0, 1.0, intervals(_length_m(begin, leg), spacing_m) + 1)
    out, home = begin - leg.centre_m, leg.to_m - leg.centre_m
    angle = math.atan2(out[1], out[0]) + 2.0 * math.pi * leg.turns * part
    # An end that is rounded lies on a slightly other radius: the arc grows into it.
    radius = np.hypot(*out[:2]) + part * (np.hypot(*home[:2]) - np.hypot(*out[:2]))
    points: FloatArray = np.stack(
        [
            leg.centre_m[0] + radius * np.cos(angle),
            leg.centre_m[1] + radius * np.sin(angle),
            begin[2] + part * (leg.to_m[2] - begin[2]),
        ],
        axis=-1,
    )
    points[0], points[-1] = begin, leg.to_m
    return points


def _cut(
    own: FloatArray,
    leg: Leg,
    following: FloatArray | None,
    after: Sequence[Leg],
    corner_m: float,
    spacing_m: float,
) -> tuple[FloatArray, FloatArray, FloatArray] | None:
    """The leg up to the corner's parabola, the parabola, and the next leg after it."""
    if following is None or corner_m <= 0.0 or leg.dwell_s > 0.0:
        return None
    if leg.turns is not None or after[0].turns is not None:
        return None
    turn = _turn(own, following)
    if turn <= STRAIGHT_RAD:
        return None
    corner, end = own[-1], following[-1]
    back, on = math.dist(own[0], corner), math.dist(corner, end)
    away = min(2.0 * corner_m / math.sin(turn / 2.0), back, 0.5 * on)
    if away <= 0.0:
        return None
    leaves = corner + (own[0] - corner) * (away / back)
    meets = corner + (end - corner) * (away / on)
    part = np.linspace(0.0, 1.0, intervals(2.0 * away, spacing_m) + 1)[:, None]
    bend = (1 - part) ** 2 * leaves + 2 * part * (1 - part) * corner + part**2 * meets
    until = line(own[0], leaves, spacing_m) if away < back else own[:1]
    return until, bend, line(meets, end, spacing_m)


def _turn(own: FloatArray, following: FloatArray) -> float:
    """By how much the way turns between two legs [rad]."""
    if len(own) < 2 or len(following) < 2:
        return math.pi
    one, other = own[-1] - own[-2], following[1] - following[0]
    sizes = float(np.linalg.norm(one) * np.linalg.norm(other))
    if sizes == 0.0:
        return math.pi
    return math.acos(max(-1.0, min(1.0, float(one @ other) / sizes)))
