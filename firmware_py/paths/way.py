"""Legs from point to point, straight, on arcs or on splines, with corners cut by no more than
is allowed.

At a corner that may not be cut, and at every dwell, the arms come to a stand. Legs that go on
straight into each other (a spline always does) are passed without a stop.
"""

from __future__ import annotations

import math
from collections.abc import Iterator, Sequence
from dataclasses import dataclass

import numpy as np

from deltactl.firmware_py.paths.corner import STRAIGHT_RAD, cut, turn_rad
from deltactl.firmware_py.paths.courses import Arc, Course, Straight, spline
from deltactl.firmware_py.paths.merging import LONGEST_RUN, longest, pairs_in_line
from deltactl.firmware_py.paths.path import Path, Space, intervals, line
from deltactl.models.robot import FloatArray

MERGED = 0.05
"""Share of the corner distance for making short legs one: of 0.5 mm it takes up points that are
rounded to 0.01 mm, and stays below a microstep of most robots."""
NOTHING = 1e-3
"""Share of the spacing: less is what rounding leaves of a leg that two corners have used up."""


@dataclass(frozen=True, slots=True)
class Leg:
    """One leg: to a point [m], straight, or on an arc about a vertical axis through `centre_m`.

    turns: of an arc, whole turns and the part of one, positive counter-clockwise from above; None
    for another leg. smooth: on a spline, one with the smooth legs before and after it.
    speed_mps: inf for the job's. dwell_s: at its end.
    """

    to_m: FloatArray
    speed_mps: float = math.inf
    dwell_s: float = 0.0
    centre_m: FloatArray | None = None
    turns: float | None = None
    smooth: bool = False
    number: int = 0
    """Its place among the legs that were given."""


def way(start_m: FloatArray, legs: Sequence[Leg], corner_m: float, spacing_m: float) -> Path:
    """All legs one after another, sampled at most `spacing_m` apart."""
    legs = merged(start_m, legs, MERGED * corner_m)
    corner_m *= 1.0 - MERGED
    courses = courses_of(start_m, legs)  # made as they are needed: a long way has many
    following: Course | None = next(courses, None)
    parts: list[FloatArray] = [np.asarray(start_m, dtype=np.float64)[None, :]]
    sizes, speeds, of_leg = [1], [math.inf], [0]
    rests, dwells, left_m, count = [0], [0.0], 0.0, 1

    def add(points: FloatArray, leg: Leg, speed_mps: float) -> int:
        parts.append(points[1:])
        sizes.append(len(points) - 1)
        of_leg.append(leg.number)
        speeds.append(speed_mps)
        return sizes[-1]

    for number, leg in enumerate(legs):
        course, following = following, next(courses, None)
        assert course is not None
        bend = None
        if following is not None and leg.dwell_s == 0.0:
            bend = cut(course, left_m, following, corner_m, spacing_m)
        until_m = bend.leaves_m if bend else course.length_m
        count += add(_sampled(course, left_m, until_m, spacing_m), leg, leg.speed_mps)
        left_m = 0.0
        if bend is not None:
            count += add(bend.points, leg, min(leg.speed_mps, legs[number + 1].speed_mps))
            left_m = bend.meets_m
        elif following is None or leg.dwell_s or turn_rad(course, following) > STRAIGHT_RAD:
            rests.append(count - 1)
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
        speed_mps=np.repeat(speeds, sizes),
        leg=np.repeat(np.array(of_leg, dtype=np.int64), sizes),
    )


def merged(start_m: FloatArray, legs: Sequence[Leg], within_m: float) -> list[Leg]:
    """The legs, with runs of short straight ones made one where that is near to all of them.

    Points in between are then no further from it than `within_m`; a dwell, another speed, and a
    turn back end a run. So a curve given by many points is not bent at each by their rounding,
    and a corner may reach over more than the last of the points before it.
    """
    if within_m <= 0.0:
        return list(legs)
    kept: list[Leg] = []
    places = np.array([start_m, *(leg.to_m for leg in legs)], dtype=np.float64)
    ends, pairs = _plain_runs(legs), pairs_in_line(places, within_m)
    number = 0
    while number < len(legs):
        run = min(ends[number] - number, LONGEST_RUN)
        if run > 1 and pairs[number]:
            number += longest(places[number : number + run + 1], within_m)
        else:
            number += 1
        kept.append(legs[number - 1])
    return kept


def _plain_runs(legs: Sequence[Leg]) -> list[int]:
    """For each leg, the one behind the last that is straight and as fast, without a rest before."""
    ends = list(range(1, len(legs) + 1))
    for number in range(len(legs) - 2, -1, -1):
        leg, after = legs[number], legs[number + 1]
        plain = leg.centre_m is None and after.centre_m is None
        plain = plain and not (leg.smooth or after.smooth or leg.dwell_s)
        if plain and leg.speed_mps == after.speed_mps:
            ends[number] = ends[number + 1]
    return ends


def target_count(start_m: FloatArray, legs: Sequence[Leg], spacing_m: float) -> int:
    """About how many targets there are; corners that are cut make it a few fewer."""
    return 1 + sum(intervals(course.length_m, spacing_m) for course in courses_of(start_m, legs))


def courses_of(start_m: FloatArray, legs: Sequence[Leg]) -> Iterator[Course]:
    """What each leg is drawn on."""
    begin, waiting = start_m, 0
    for number, leg in enumerate(legs):
        if leg.smooth:
            waiting += 1
            if number + 1 == len(legs) or not legs[number + 1].smooth:
                run = legs[number + 1 - waiting : number + 1]
                yield from spline([begin, *(one.to_m for one in run)])
                begin, waiting = leg.to_m, 0
            continue
        if leg.centre_m is not None and leg.turns is not None:
            yield Arc(begin, leg.to_m, leg.centre_m, leg.turns)
        else:
            yield Straight(begin, leg.to_m)
        begin = leg.to_m


def _sampled(course: Course, from_m: float, to_m: float, spacing_m: float) -> FloatArray:
    """Points of a stretch of a leg, both ends included; only one where nothing is left of it."""
    if to_m - from_m <= NOTHING * spacing_m and from_m > 0.0:
        return course.at(np.array([from_m]))
    pieces = intervals(to_m - from_m, spacing_m)
    if pieces == 1:
        return course.at(np.array([from_m, to_m]))
    return course.at(np.linspace(from_m, to_m, pieces + 1))
