"""The legs of a way in columns: a hundred thousand of them take a few megabytes.

A row is a leg as a job file has it: `to_m`, and where given `speed_mps`, `dwell_s`, `centre_m`
with `clockwise`, `spline`.
"""

from __future__ import annotations

import math
import struct
from array import array
from collections.abc import Callable, Iterable, Iterator, Sequence
from typing import Any

import numpy as np
from pydantic import GetCoreSchemaHandler
from pydantic_core import core_schema

from deltactl.firmware_py.paths.path import BoolArray
from deltactl.models.robot import FloatArray

MOST_LEGS = 100_000
AT_ONCE = 1000
"""Legs that are objects of their own at a time."""
COLUMNS = ("to_m", "speed_mps", "dwell_s", "centre_m", "clockwise", "spline")


class Legs:
    """Columns of n legs.

    to_m: (n, 3). speed_mps: (n,), inf for the job's. dwell_s: (n,), at the leg's end. centre_m:
    (n, 2), x and y of an arc's axis, NaN for other legs. clockwise: (n,), of arcs. spline: (n,).
    """

    __slots__ = COLUMNS

    def __init__(
        self,
        to_m: FloatArray,
        speed_mps: FloatArray,
        dwell_s: FloatArray,
        centre_m: FloatArray,
        clockwise: BoolArray,
        spline: BoolArray,
    ):
        self.to_m, self.speed_mps, self.dwell_s = to_m, speed_mps, dwell_s
        self.centre_m, self.clockwise, self.spline = centre_m, clockwise, spline

    @classmethod
    def of(cls, rows: Iterable[dict[str, Any]]) -> Legs:
        """Rows as a job file has them."""
        gathered = LegsGathered()
        for row in rows:
            gathered.add(**row)
        return gathered.legs()

    def __len__(self) -> int:
        return len(self.to_m)

    def __getitem__(self, number: int) -> dict[str, Any]:
        """A leg as a job file has it, without what it need not say."""
        return next(iter(self.rows(slice(number, number + 1))))

    def __iter__(self) -> Iterator[dict[str, Any]]:
        for first in range(0, len(self), AT_ONCE):
            some = slice(first, first + AT_ONCE)
            for row in zip(*(column[some].tolist() for column in self._columns()), strict=True):
                yield _as_said(*row)

    def __eq__(self, other: object) -> bool:
        if not isinstance(other, Legs):
            return NotImplemented
        pairs = zip(self._columns(), other._columns(), strict=True)
        return all(np.array_equal(own, others, equal_nan=True) for own, others in pairs)

    def __hash__(self) -> int:
        return hash(self.to_m.tobytes())

    @property
    def is_arc(self) -> BoolArray:
        """Which legs are arcs, (n,)."""
        found: BoolArray = ~np.isnan(self.centre_m[:, 0])
        return found

    def rows(self, chosen: Any) -> Legs:
        """Some of them: a slice, indices, or whether each is one of them."""
        return Legs(*(column[chosen] for column in self._columns()))

    def moved(self, shift_m: FloatArray) -> Legs:
        """All elsewhere; shift_m: (3,)."""
        _, speed_mps, dwell_s, _, clockwise, spline = self._columns()
        centre_m = self.centre_m + shift_m[:2]
        return Legs(self.to_m + shift_m, speed_mps, dwell_s, centre_m, clockwise, spline)

    def _columns(self) -> tuple[Any, ...]:
        return tuple(getattr(self, name) for name in COLUMNS)


class AsColumns:
    """Makes Legs of the list that a field is declared as; its legs are `packed` by then."""

    def __get_pydantic_core_schema__(
        self, source: Any, handler: GetCoreSchemaHandler
    ) -> core_schema.CoreSchema:
        """See pydantic. From Python, Legs may be given as they are."""
        listed = core_schema.no_info_after_validator_function(_unpacked, handler(source))
        return core_schema.json_or_python_schema(
            listed,
            core_schema.no_info_wrap_validator_function(_as_it_is, listed),
            serialization=core_schema.plain_serializer_function_ser_schema(list, when_used="json"),
        )


def _as_said(
    to_m: list[float],
    speed_mps: float,
    dwell_s: float,
    centre_m: list[float],
    clockwise: bool,
    spline: bool,
) -> dict[str, Any]:
    leg: dict[str, Any] = {"to_m": tuple(to_m)}
    if speed_mps != math.inf:
        leg["speed_mps"] = speed_mps
    if dwell_s:
        leg["dwell_s"] = dwell_s
    if centre_m[0] == centre_m[0]:  # NaN is no number
        leg |= {"centre_m": tuple(centre_m), "clockwise": clockwise}
    if spline:
        leg["spline"] = True
    return leg


_ROW = struct.Struct("<7d2?")


def packed(leg: Any) -> bytes:
    """A leg that was checked, small: a file has many, and all are there before the columns are."""
    x_m, y_m = leg.centre_m or (math.nan, math.nan)
    speed_mps = math.inf if leg.speed_mps is None else leg.speed_mps
    return _ROW.pack(*leg.to_m, speed_mps, leg.dwell_s, x_m, y_m, leg.clockwise, leg.spline)


def _unpacked(rows: Sequence[bytes]) -> Legs:
    numbers, marks = np.dtype(("<f8", 7)), np.dtype(("?", 2))
    whole = np.frombuffer(b"".join(rows), np.dtype([("numbers", numbers), ("marks", marks)]))
    to_m, speed_mps, dwell_s, centre_m = np.split(whole["numbers"].copy(), (3, 4, 5), axis=1)
    clockwise, spline = whole["marks"].T.copy()
    return Legs(to_m, speed_mps[:, 0], dwell_s[:, 0], centre_m, clockwise, spline)


def _as_it_is(value: Any, check: Callable[[Any], Legs]) -> Legs:
    return value if isinstance(value, Legs) else check(value)


class LegsGathered:
    """Legs one after another, while a file is read."""

    def __init__(self) -> None:
        self._to_m, self._speed_mps, self._dwell_s = array("d"), array("d"), array("d")
        self._centre_m, self._clockwise, self._spline = array("d"), array("b"), array("b")

    def __len__(self) -> int:
        return len(self._speed_mps)

    def add(
        self,
        to_m: Iterable[float],
        speed_mps: float | None = None,
        dwell_s: float = 0.0,
        centre_m: Iterable[float] | None = None,
        clockwise: bool = False,
        spline: bool = False,
    ) -> None:
        """One more, with the names of a job file."""
        self._to_m.extend(to_m)
        self._speed_mps.append(math.inf if speed_mps is None else speed_mps)
        self._dwell_s.append(dwell_s)
        self._centre_m.extend((math.nan, math.nan) if centre_m is None else centre_m)
        self._clockwise.append(clockwise)
        self._spline.append(spline)

    @property
    def end_m(self) -> tuple[float, float, float]:
        """Where the last one ends."""
        x_m, y_m, z_m = self._to_m[-3:]
        return x_m, y_m, z_m

    def wait(self, number: int, seconds: float) -> float:
        """Wait longer at the end of a leg; how long that is then."""
        self._dwell_s[number] = round(self._dwell_s[number] + seconds, 6)
        return self._dwell_s[number]

    def legs(self) -> Legs:
        """All of them; none may be added afterwards."""
        return Legs(
            np.frombuffer(self._to_m).reshape(-1, 3),
            np.frombuffer(self._speed_mps),
            np.frombuffer(self._dwell_s),
            np.frombuffer(self._centre_m).reshape(-1, 2),
            np.frombuffer(self._clockwise, dtype=np.bool_),
            np.frombuffer(self._spline, dtype=np.bool_),
        )
