"""What the legs of a way are drawn on: straight lines, level arcs, splines, each by length run.

All legs of a kind are worked out together: a file of a hundred thousand short moves takes no
longer than its targets do.
"""

from __future__ import annotations

import math
from collections.abc import Iterator

import numpy as np

from deltactl.firmware_py.paths.legs import Legs
from deltactl.firmware_py.paths.path import BoolArray, Int64Array
from deltactl.models.robot import FloatArray

TABLE = 200
"""Pieces in which a spline between two points is measured."""
MEASURED_AT_ONCE = 500
"""Pieces of splines measured together: a few MB."""
APART_M = 1.0
"""Between the tables of two pieces that are looked up together."""


class Courses:
    """The lines in space of n legs, one after another; their length_m: (n,).

    Straight: from a point to another. Arcs: about a vertical axis; a change of height makes a
    helix of one, and an end that is rounded, on a slightly other radius, is grown into. Splines:
    natural cubics through the ends of all smooth legs that follow each other; such ends differ.
    """

    def __init__(self, start_m: FloatArray, legs: Legs):
        self.end_m = legs.to_m
        self.begin_m = np.concatenate([np.asarray(start_m, dtype=np.float64)[None], legs.to_m[:-1]])
        self.is_arc, self.is_spline = legs.is_arc, legs.spline
        self.length_m = np.linalg.norm(self.end_m - self.begin_m, axis=1)
        arcs, pieces = np.flatnonzero(self.is_arc), np.flatnonzero(self.is_spline)
        self._of_kind = np.zeros(len(legs), dtype=np.int64)
        """For an arc, or a piece of a spline: its number among those."""
        self._of_kind[arcs] = np.arange(len(arcs))
        self._of_kind[pieces] = np.arange(len(pieces))
        self._arcs = _Arcs(self.begin_m[arcs], self.end_m[arcs], legs.rows(arcs))
        self._cubics = _Cubics(*_tangents(self.begin_m, self.end_m, self.is_spline))
        self.length_m[arcs] = self._arcs.length_m
        self.length_m[pieces] = self._cubics.length_m

    def __len__(self) -> int:
        return len(self.length_m)

    def at(self, rows: Int64Array, run_m: FloatArray) -> FloatArray:
        """Places [m], (k, 3), after lengths run [m], (k,), of legs, (k,); ends are met exactly."""
        length_m, end_m = self.length_m[rows], self.end_m[rows]
        begin_m = self.begin_m[rows]
        with np.errstate(divide="ignore", invalid="ignore"):
            part = np.where(length_m > 0.0, run_m / length_m, 0.0)[:, None]
        places: FloatArray = begin_m + part * (end_m - begin_m)
        for chosen, kind in self._others(rows):
            own = self._of_kind[rows[chosen]]
            places[chosen] = kind.at(own, run_m[chosen])
            before = chosen[run_m[chosen] <= 0.0]
            places[before] = begin_m[before]
        past = (run_m >= length_m) & (length_m > 0.0)
        places[past] = end_m[past]
        return places

    def headings(self, rows: Int64Array, run_m: FloatArray) -> FloatArray:
        """Unit vectors (k, 3) of the ways there; zeros where a leg has no length."""
        hop = self.end_m[rows] - self.begin_m[rows]
        for chosen, kind in self._others(rows):
            hop[chosen] = kind.along(self._of_kind[rows[chosen]], run_m[chosen])
        size = np.linalg.norm(hop, axis=1)
        unit: FloatArray = hop / np.where(size > 0.0, size, 1.0)[:, None]
        return unit

    def nearest_m(
        self, rows: Int64Array, points_m: FloatArray, low_m: FloatArray, high_m: FloatArray
    ) -> FloatArray:
        """Lengths run [m], (k, s), at which legs (k,) come near points (k, s, 3).

        Between low_m and high_m, (k,). For a helix and a growing arc it is the place in the
        same direction from the axis: the distance from there is no less than the smallest.
        """
        begin_m, along = self.begin_m[rows], self.headings(rows, np.zeros(len(rows)))
        run_m = np.einsum("ksi,ki->ks", points_m - begin_m[:, None], along)
        arcs = np.flatnonzero(self.is_arc[rows])
        middle_m = (low_m + high_m)[arcs] / 2.0
        run_m[arcs] = self._arcs.beside(self._of_kind[rows[arcs]], points_m[arcs], middle_m)
        found: FloatArray = np.clip(run_m, low_m[:, None], high_m[:, None])
        return found

    def _others(self, rows: Int64Array) -> Iterator[tuple[Int64Array, _Arcs | _Cubics]]:
        """Which of these legs are no straight ones, and what they are."""
        for is_kind, kind in ((self.is_arc, self._arcs), (self.is_spline, self._cubics)):
            chosen = np.flatnonzero(is_kind[rows])
            if len(chosen):
                yield chosen, kind


class _Arcs:
    def __init__(self, begin_m: FloatArray, end_m: FloatArray, legs: Legs):
        self._centre = legs.centre_m
        out, last = begin_m[:, :2] - self._centre, end_m[:, :2] - self._centre
        self._first = np.arctan2(out[:, 1], out[:, 0])
        turn = (np.arctan2(last[:, 1], last[:, 0]) - self._first) / (2.0 * math.pi) % 1.0
        turn[(turn < 1e-9) | (turn > 1.0 - 1e-9)] = 0.0
        turn = np.where(legs.clockwise, turn - 1.0, np.where(turn > 0.0, turn, 1.0))
        self._swing = 2.0 * math.pi * turn
        self._radius = np.hypot(*out.T)
        self._grows = np.hypot(*last.T) - self._radius
        self._z, self._climb = begin_m[:, 2], end_m[:, 2] - begin_m[:, 2]
        self.length_m = np.hypot(self._radius * self._swing, self._climb)

    def _polar(self, own: Int64Array, run_m: FloatArray) -> tuple[FloatArray, ...]:
        part = run_m / self.length_m[own]
        radius = self._radius[own] + part * self._grows[own]
        return part, self._first[own] + self._swing[own] * part, radius

    def at(self, own: Int64Array, run_m: FloatArray) -> FloatArray:
        part, angle, radius = self._polar(own, run_m)
        x_m, y_m = self._centre[own].T
        z_m = self._z[own] + part * self._climb[own]
        return np.stack([x_m + radius * np.cos(angle), y_m + radius * np.sin(angle), z_m], axis=-1)

    def along(self, own: Int64Array, run_m: FloatArray) -> FloatArray:
        _, angle, radius = self._polar(own, run_m)
        around, grows = radius * self._swing[own], self._grows[own]
        cos, sin = np.cos(angle), np.sin(angle)
        return np.stack(
            [grows * cos - around * sin, grows * sin + around * cos, self._climb[own]], axis=-1
        )

    def beside(self, own: Int64Array, points_m: FloatArray, about_m: FloatArray) -> FloatArray:
        """Lengths run [m], (k, s), in the direction of points (k, s, 3), near about_m, (k,)."""
        out = points_m[:, :, :2] - self._centre[own][:, None]
        _, middle, _ = self._polar(own, about_m)
        off = np.arctan2(out[:, :, 1], out[:, :, 0]) - middle[:, None]
        off = (off + math.pi) % (2.0 * math.pi) - math.pi
        per_rad_m = self.length_m[own] / self._swing[own]
        beside: FloatArray = about_m[:, None] + off * per_rad_m[:, None]
        return beside


class _Cubics:
    """Pieces begin + w (slope + w (bend + w twist)), w from 0 to 1; tangents are dp/dw."""

    def __init__(
        self, begin_m: FloatArray, end_m: FloatArray, leaves: FloatArray, arrives: FloatArray
    ):
        hop = end_m - begin_m
        self._begin, self._slope = begin_m, leaves
        self._bend = 3.0 * hop - 2.0 * leaves - arrives
        self._twist = leaves + arrives - 2.0 * hop
        self._w = np.linspace(0.0, 1.0, TABLE + 1)
        self.length_m = np.zeros(len(begin_m))
        for first in range(0, len(begin_m), MEASURED_AT_ONCE):
            some = np.arange(first, min(first + MEASURED_AT_ONCE, len(begin_m)))
            self.length_m[some] = self._runs(some)[:, -1]

    def at(self, own: Int64Array, run_m: FloatArray) -> FloatArray:
        return self._places(own, self._parameter(own, run_m)[:, None])

    def along(self, own: Int64Array, run_m: FloatArray) -> FloatArray:
        w = self._parameter(own, run_m)[:, None]
        along: FloatArray = self._slope[own] + w * (
            2.0 * self._bend[own] + 3.0 * w * self._twist[own]
        )
        return along

    def _runs(self, own: Int64Array) -> FloatArray:
        """Lengths run [m], (k, TABLE + 1), at the parameters of the table."""
        wide = (len(own), TABLE + 1, 3)
        w = np.broadcast_to(self._w[None, :, None], (*wide[:2], 1))
        places = self._places(np.repeat(own, TABLE + 1), w.reshape(-1, 1)).reshape(wide)
        return runs_of(places)

    def _parameter(self, own: Int64Array, run_m: FloatArray) -> FloatArray:
        """w, (k,), at which pieces (k,) have run so far."""
        found = np.empty(len(own))
        pieces, of_piece = np.unique(own, return_inverse=True)
        order = np.argsort(of_piece, kind="stable")
        until = np.searchsorted(of_piece[order], np.arange(0, len(pieces), MEASURED_AT_ONCE))
        for first, some in zip(
            range(0, len(pieces), MEASURED_AT_ONCE), np.split(order, until[1:]), strict=True
        ):
            runs_m = self._runs(pieces[first : first + MEASURED_AT_ONCE])
            found[some] = interpolated(runs_m, of_piece[some] - first, run_m[some])
        return found / TABLE

    def _places(self, own: Int64Array, w: FloatArray) -> FloatArray:
        places: FloatArray = self._begin[own] + w * (
            self._slope[own] + w * (self._bend[own] + w * self._twist[own])
        )
        return places


def runs_of(places_m: FloatArray) -> FloatArray:
    """Lengths run [m], (k, s), along k lines of s places (k, s, 3)."""
    runs_m = np.zeros(places_m.shape[:2])
    np.cumsum(np.linalg.norm(np.diff(places_m, axis=1), axis=2), axis=1, out=runs_m[:, 1:])
    return runs_m


def interpolated(runs_m: FloatArray, rows: Int64Array, wanted_m: FloatArray) -> FloatArray:
    """Where in its row (k, s) of lengths run, counted in columns, each wanted length is, (n,)."""
    count, width = runs_m.shape
    begins_m = np.concatenate([[0.0], np.cumsum(runs_m[:-1, -1] + APART_M)])
    column = np.tile(np.arange(width, dtype=np.float64), count)
    wanted_m = np.clip(wanted_m, 0.0, runs_m[rows, -1])
    return np.interp(wanted_m + begins_m[rows], (runs_m + begins_m[:, None]).ravel(), column)


def _tangents(
    begin_m: FloatArray, end_m: FloatArray, smooth: BoolArray
) -> tuple[FloatArray, FloatArray, FloatArray, FloatArray]:
    """Begins, ends, and dp/dw at both, of all smooth legs, (k, 3) each."""
    leaves, arrives = np.zeros_like(begin_m), np.zeros_like(begin_m)
    edges = np.flatnonzero(np.diff(smooth, prepend=False, append=False))
    for first, behind in edges.reshape(-1, 2).tolist():
        places = np.concatenate([begin_m[first : first + 1], end_m[first:behind]])
        width = np.sqrt(np.linalg.norm(np.diff(places, axis=0), axis=1))
        slopes = _slopes(places, width)
        leaves[first:behind] = slopes[:-1] * width[:, None]
        arrives[first:behind] = slopes[1:] * width[:, None]
    return begin_m[smooth], end_m[smooth], leaves[smooth], arrives[smooth]


def _slopes(places: FloatArray, width: FloatArray) -> FloatArray:
    """dp/dt at each point, (n, 3), of the natural cubic spline through all.

    Its parameter grows by the root of the distance (centripetal: Lee 1989), which keeps it from
    swinging out where near points follow far ones. A tridiagonal system, solved by elimination
    (Thomas).
    """
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
