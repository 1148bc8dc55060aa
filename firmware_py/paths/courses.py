"""What legs of a way are drawn on: straight lines, level arcs, splines, each by length run.

A course knows its length, where it is after a length, and which way it goes there. That is
all that cutting a corner between any two of them needs.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import Protocol

import numpy as np

from deltactl.models.robot import FloatArray

TABLE = 200
"""Pieces in which a spline between two points is measured."""


class Course(Protocol):
    """One leg's line in space."""

    length_m: float

    def at(self, run_m: FloatArray) -> FloatArray:
        """Places [m], (n, 3), after lengths run [m], (n,)."""

    def heading(self, run_m: float) -> FloatArray:
        """Unit vector (3,) of the way there; zeros where the leg has no length."""


class Straight:
    """From a point to another."""

    def __init__(self, begin: FloatArray, end: FloatArray):
        self._begin, self._end = begin, end
        self.length_m = math.dist(begin, end)
        self._heading = (end - begin) / self.length_m if self.length_m else np.zeros(3)

    @property
    def end(self) -> FloatArray:
        """Where it ends, (3,) [m]."""
        return self._end

    def at(self, run_m: FloatArray) -> FloatArray:
        """See Course; the ends are met exactly."""
        part = (run_m / self.length_m if self.length_m else run_m * 0.0)[:, None]
        places: FloatArray = np.where(
            part < 1.0, self._begin + part * (self._end - self._begin), self._end
        )
        return places

    def heading(self, run_m: float) -> FloatArray:
        """See Course."""
        return self._heading


class Arc:
    """About a vertical axis; a change of height makes a helix of it.

    turns: positive counter-clockwise from above. An end that is rounded lies on a slightly other
    radius: the arc grows into it.
    """

    def __init__(self, begin: FloatArray, end: FloatArray, centre: FloatArray, turns: float):
        self._begin, self._end, self._centre = begin, end, centre
        self._first = math.atan2(begin[1] - centre[1], begin[0] - centre[0])
        self._swing = 2.0 * math.pi * turns
        self._radius = math.hypot(begin[0] - centre[0], begin[1] - centre[1])
        self._grows = math.hypot(end[0] - centre[0], end[1] - centre[1]) - self._radius
        self.length_m = math.hypot(self._radius * self._swing, float(end[2] - begin[2]))

    def at(self, run_m: FloatArray) -> FloatArray:
        """See Course; the ends are met exactly."""
        part = run_m / self.length_m
        angle = self._first + self._swing * part
        radius = self._radius + part * self._grows
        places: FloatArray = np.stack(
            [
                self._centre[0] + radius * np.cos(angle),
                self._centre[1] + radius * np.sin(angle),
                self._begin[2] + part * (self._end[2] - self._begin[2]),
            ],
            axis=-1,
        )
        places[run_m <= 0.0], places[run_m >= self.length_m] = self._begin, self._end
        return places

    def heading(self, run_m: float) -> FloatArray:
        """See Course."""
        part = run_m / self.length_m
        angle, radius = self._first + self._swing * part, self._radius + part * self._grows
        way = np.array(
            [
                self._grows * math.cos(angle) - radius * self._swing * math.sin(angle),
                self._grows * math.sin(angle) + radius * self._swing * math.cos(angle),
                self._end[2] - self._begin[2],
            ]
        )
        unit: FloatArray = way / np.linalg.norm(way)
        return unit


class Cubic:
    """One piece of a spline: start + w (slope + w (bend + w twist)), w from 0 to 1."""

    def __init__(self, begin: FloatArray, end: FloatArray, leaves: FloatArray, arrives: FloatArray):
        """`leaves` and `arrives`: dp/dw at both ends, (3,)."""
        hop = end - begin
        self._begin, self._end, self._slope = begin, end, leaves
        self._bend = 3.0 * hop - 2.0 * leaves - arrives
        self._twist = leaves + arrives - 2.0 * hop
        self._w = np.linspace(0.0, 1.0, TABLE + 1)
        hops = np.linalg.norm(np.diff(self._place(self._w), axis=0), axis=1)
        self._run_m = np.concatenate([[0.0], np.cumsum(hops)])
        self.length_m = float(self._run_m[-1])

    def at(self, run_m: FloatArray) -> FloatArray:
        """See Course; the ends are met exactly."""
        places = self._place(np.interp(run_m, self._run_m, self._w))
        places[run_m <= 0.0], places[run_m >= self.length_m] = self._begin, self._end
        return places

    def heading(self, run_m: float) -> FloatArray:
        """See Course."""
        w = float(np.interp(run_m, self._run_m, self._w))
        way = self._slope + w * (2.0 * self._bend + 3.0 * w * self._twist)
        size = float(np.linalg.norm(way))
        unit: FloatArray = way / size if size else way
        return unit

    def _place(self, w: FloatArray) -> FloatArray:
        w = w[:, None]
        places: FloatArray = self._begin + w * (self._slope + w * (self._bend + w * self._twist))
        return places


def spline(points_m: Sequence[FloatArray]) -> list[Cubic]:
    """The natural cubic spline through points [m], one piece for each two of them.

    Its parameter grows by the root of the distance (centripetal: Lee 1989), which keeps it from
    swinging out where near points follow far ones. Points that follow each other must differ.
    """
    places = np.asarray(points_m, dtype=np.float64)
    width = np.sqrt(np.linalg.norm(np.diff(places, axis=0), axis=1))
    slopes = _slopes(places, width)
    return [
        Cubic(places[n], places[n + 1], slopes[n] * width[n], slopes[n + 1] * width[n])
        for n in range(len(width))
    ]


def _slopes(places: FloatArray, width: FloatArray) -> FloatArray:
    """dp/dt at each point, (n, 3): a tridiagonal system, solved by elimination (Thomas)."""
    climb = np.diff(places, axis=0) / width[:, None]
    inverse = 1.0 / width
    left = np.concatenate([inverse, [0.0]])
    right = np.concatenate([[0.0], inverse])
    weighted = 3.0 * climb * inverse[:, None]
    wanted = np.zeros_like(places)
    wanted[:-1] += weighted
    wanted[1:] += weighted
    middle = 2.0 * (left + right)
    for n in range(1, len(places)):
        factor = right[n] / middle[n - 1]
        middle[n] -= factor * left[n - 1]
        wanted[n] -= factor * wanted[n - 1]
    slopes = np.empty_like(places)
    slopes[-1] = wanted[-1] / middle[-1]
    for n in range(len(places) - 2, -1, -1):
        slopes[n] = (wanted[n] - left[n] * slopes[n + 1]) / middle[n]
    return slopes
