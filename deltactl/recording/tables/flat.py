"""A flat recording: one row a sample, the exchange format of `contracts/diagnosis.md`."""

from __future__ import annotations

import itertools
import re
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass, field, replace
from typing import Any

import numpy as np

from deltactl.foundation.errors import RecordingError
from deltactl.foundation.printable import count
from deltactl.recording.reading.run import FloatArray
from deltactl.recording.tables.cells import FAR_BACK, advice, not_increasing

AnyArray = np.ndarray[Any, np.dtype[Any]]

UNITS: dict[str, str] = {
    "t": "s",
    **{f"steps_{motor}": "microsteps" for motor in (1, 2, 3)},
    **{f"command_{motor}": "rad" for motor in (1, 2, 3)},
    **{f"range_{axis}": "m" for axis in "xyz"},
    **{f"status_{axis}": "" for axis in "xyz"},
    **{f"theta_{motor}": "rad" for motor in (1, 2, 3)},
    **{f"pos_{axis}": "m" for axis in "xyz"},
    "t_pwm": "s",
    **{f"current_{motor}": "A" for motor in (1, 2, 3)},
    **{f"disturbance_{motor}": "A" for motor in (1, 2, 3)},
    "temp_c": "deg C",
    "position": "rad or m",
    "command": "rad or m",
    "effort": "N m, N, or what effort_gain converts",
    "velocity": "rad/s or m/s",
    "load": "N m or N",
    "distance": "m",
    "range": "m",
    "segment": "",
}
"""Columns of the contract and their units. Any other column is kept beside them."""

OF_A_CHAIN = re.compile(
    r"(theta|command|velocity|effort)_\d+|pos\d*_[xyz](_mm)?|(quat|rotvec)_[wxyz]"
)
"""Columns of a chain of any number of joints, in rad and m; kept beside those of the contract."""

CALLED_BY_JOINT = re.compile(r"(theta|effort)_\w+|\w+_(theta|effort)")
"""Columns of a chain whose joints have names."""

TARGET = re.compile(r"(pos\d*)_x(?:_mm)?")
"""Column of a target on a chain, whose places were measured."""


def known_unit(name: str) -> str | None:
    """Unit of a column of the contract or of a chain; None of any other."""
    if name in UNITS or not OF_A_CHAIN.fullmatch(name):
        return UNITS.get(name)
    stem = re.split(r"\d*_", name)[0]
    return {"pos": "m", "quat": "", "velocity": UNITS["velocity"], "effort": UNITS["effort"]}.get(
        stem, "rad"
    )


BESIDE = frozenset(
    [f"t_{axis}" for axis in "xyz"]
    + [f"truth_{axis}_m" for axis in "xyz"]
    + [f"truth_theta_{motor}_rad" for motor in (1, 2, 3)]
)
"""Columns that an exported run has besides; the diagnosis reads none of them."""

MOST_COLUMNS = 1000
"""More are a matrix, not a recording."""
MOST_SPAN_S = 366 * 86400.0
"""A recording of more than a year has its times in another unit, or wrong."""
GAP_PERIODS = FAR_BACK
"""A gap in `t` longer than this many sample periods starts a new stretch (contract)."""


@dataclass(frozen=True, slots=True)
class FlatRecording:
    """A table of samples. NaN is an empty cell.

    t_s: shape (n,), strictly increasing. columns: contract name -> shape (n,), without `t`.
    extra: columns the contract does not know, numbers or texts. source: file it came from.
    taken_from: rows that the file has, where these are only some of them; else 0.
    units_given: columns whose unit somebody gave. units: by column, as it was recorded. timed:
    False where rows are only counted.
    """

    t_s: FloatArray
    columns: dict[str, FloatArray]
    extra: dict[str, AnyArray] = field(default_factory=dict)
    source: str = ""
    taken_from: int = 0
    units_given: frozenset[str] = frozenset()
    units: Mapping[str, str] = field(default_factory=dict)
    timed: bool = True

    def __len__(self) -> int:
        return len(self.t_s)

    def has(self, *names: str) -> bool:
        """Whether all these contract columns are there."""
        return all(name in self.columns for name in names)

    def require(self, *names: str) -> None:
        """Raise RecordingError, naming what is missing and what is there."""
        missing = [name for name in names if name not in self.columns]
        if missing:
            raise RecordingError(
                f"{self.source}: column {' and '.join(missing)} missing; "
                f"it has t, {', '.join(self.columns)}"
            )

    def column(self, name: str) -> FloatArray:
        """One column, shape (n,). Raises RecordingError when it is missing."""
        self.require(name)
        return self.columns[name]

    def side_by_side(self, names: Iterable[str]) -> FloatArray:
        """Several columns as shape (n, k). Raises RecordingError when one is missing."""
        names = tuple(names)
        self.require(*names)
        return np.stack([self.columns[name] for name in names], axis=1)

    def motors(self, stem: str) -> FloatArray | None:
        """`stem_1..3` as shape (n, 3), or None when not all are there."""
        return self._optional([f"{stem}_{motor}" for motor in (1, 2, 3)])

    def axes(self, stem: str) -> FloatArray | None:
        """`stem_x..z` as shape (n, 3), or None when not all are there."""
        return self._optional([f"{stem}_{axis}" for axis in "xyz"])

    def period_s(self) -> float:
        """The usual time between rows [s]; NaN with fewer than two."""
        return float(np.median(np.diff(self.t_s))) if len(self) > 1 else float("nan")

    def stretches(self) -> list[slice]:
        """Rows that belong together: cut at a change of `segment` and at long gaps."""
        if not len(self):
            return []
        cut = np.diff(self.t_s) > GAP_PERIODS * self.period_s()
        if "segment" in self.columns:
            cut |= np.diff(np.nan_to_num(self.columns["segment"], nan=-1.0)) != 0
        edges = [0, *(np.flatnonzero(cut) + 1).tolist(), len(self)]
        return [slice(start, end) for start, end in itertools.pairwise(edges)]

    def rows(self, which: slice | AnyArray) -> FlatRecording:
        """Some of the rows: a slice, a mask of shape (n,), or increasing indices."""
        return replace(
            self,
            t_s=self.t_s[which],
            columns={name: values[which] for name, values in self.columns.items()},
            extra={name: values[which] for name, values in self.extra.items()},
        )

    def _optional(self, names: list[str]) -> FloatArray | None:
        return self.side_by_side(names) if self.has(*names) else None


def are_poses(names: Iterable[str]) -> bool:
    """Whether a table has angles of joints and places of a reflector, and nothing that moves."""
    stems = {re.split(r"\d*_", name)[0] for name in names if OF_A_CHAIN.fullmatch(name)}
    return "pos" in stems and bool(stems & {"theta", "command"}) and "effort" not in stems


def from_columns(
    named: dict[str, AnyArray], source: str, lines: Sequence[int] | None = None
) -> FlatRecording:
    """Check a table and sort its columns into contract and extra.

    `lines` are the lines of the file with the rows, for messages; without them rows are
    counted from 1. Raises RecordingError, naming the line or the row.
    """
    counted = "t" not in named and are_poses(named)
    if counted:  # measured at rest, each by itself
        named = {"t": np.arange(len(next(iter(named.values()))), dtype=float), **named}
    if "t" not in named:
        raise RecordingError(f"{source}: has no column 't'; it has {_listed(named)}")
    if len(named) > MOST_COLUMNS:
        raise RecordingError(f"{source}: has {len(named)} columns, at most {MOST_COLUMNS} are read")
    known = _of_contract(named, source)
    t_s = known.pop("t")
    where = _Where(source, lines)
    if not len(t_s):
        raise RecordingError(f"{source}: has a heading but no rows")
    _check_time(t_s, where)
    _check_finite(known, where)
    extra = {name: values for name, values in named.items() if name not in UNITS}
    return FlatRecording(t_s, known, extra, source, timed=not counted)


def _of_contract(named: Mapping[str, AnyArray], source: str) -> dict[str, FloatArray]:
    """The columns of the contract. Raises RecordingError where there is none beside the times."""
    known = {
        name: _numbers(values, name, source) for name, values in named.items() if name in UNITS
    }
    of_chains = (OF_A_CHAIN, CALLED_BY_JOINT)
    if len(known) == 1 and not any(one.fullmatch(name) for one in of_chains for name in named):
        raise RecordingError(
            f"{source}: none of its columns {_listed(name for name in named if name != 't')} "
            "is one that the program knows (steps_1, range_x, position, ...; all of them are in"
            " docs/reference/columns.md)"
        ).with_typed(f"; type: deltactl inspect {source}")
    return known


def _listed(names: Iterable[str]) -> str:
    return ", ".join(names)[:200] or "none"


@dataclass(frozen=True, slots=True)
class _Where:
    source: str
    lines: Sequence[int] | None

    def fail(self, row: int, message: str) -> RecordingError:
        if self.lines is None:
            return RecordingError(f"{self.source}: row {row + 1}: {message}")
        return RecordingError(f"{self.source}:{self.lines[row]}: {message}")


def _numbers(values: AnyArray, name: str, source: str) -> FloatArray:
    try:
        if values.dtype.kind in "mMc":
            raise TypeError(f"it holds {values.dtype}")
        return np.asarray(values, dtype=np.float64)
    except (TypeError, ValueError) as error:
        raise RecordingError(f"{source}: column '{name}' must hold numbers ({error})") from error


def _check_finite(columns: Mapping[str, FloatArray], where: _Where) -> None:
    for name, values in columns.items():
        if np.isinf(values).any():
            row = int(np.flatnonzero(np.isinf(values))[0])
            raise where.fail(row, f"{name} is infinite; leave the cell empty instead")


def _check_time(t_s: FloatArray, where: _Where) -> None:
    missing = np.flatnonzero(~np.isfinite(t_s))
    if len(missing):
        raise where.fail(int(missing[0]), "t is empty; every row needs its time")
    late = not_increasing(t_s)
    if len(late):
        row = int(late[0])
        more = f", nor in {count(len(late) - 1, 'more row')}" if len(late) > 1 else ""
        raise where.fail(
            row,
            f"t does not increase ({t_s[row]:.10g} after {t_s[row - 1]:.10g}){more}; {advice(t_s)}",
        )
    if float(t_s[-1]) - float(t_s[0]) > MOST_SPAN_S:
        raise where.fail(
            len(t_s) - 1, f"t ends {t_s[-1] - t_s[0]:g} s after it began; it must be in seconds"
        )
