"""What is known of a table's columns, and which of several that could be the same thing is an axis'
command, reading, velocity and effort.
"""

from __future__ import annotations

import itertools
import re
from collections.abc import Collection, Iterator, Mapping
from dataclasses import dataclass, replace
from typing import NamedTuple

import numpy as np

from deltactl.recording.foreign.names import (
    MEASURED,
    SEEN,
    TORQUES,
    Guess,
    Named,
    Taken,
    in_words,
    is_analogue,
    of_role,
    pulls,
)
from deltactl.recording.foreign.options import GUESSES
from deltactl.recording.foreign.shapes import (
    Table,
    asks,
    correlation,
    difference,
    follows_step,
    is_count,
    is_stepwise,
    is_whole,
    lead,
    never_falls,
    of_one_motion,
    rising,
)
from deltactl.recording.foreign.units import LONE
from deltactl.recording.reading.run import FloatArray

_D = re.compile(r"_d(?![A-Za-z])")
CURRENTS = frozenset(["current", "strom", "iq", "i_q", "courant", "corriente", "corrente", "amps"])
EARLIER = "smoother or earlier"
"""Why one of two columns that move alike is the command, where no name says it."""
LIKE = "moves like {}"


@dataclass(frozen=True, slots=True)
class Columns:
    """Columns of a table, what their names say, and what they are taken for so far."""

    table: Table
    said: Mapping[str, Named]
    found: dict[str, Guess]

    def of(self, *roles: str) -> list[str]:
        """Columns that are taken for one of the roles."""
        return of_role(self.found, *roles)

    def role(self, name: str) -> str | None:
        """What a column is taken for."""
        return self.found[name].role if name in self.found else None

    def taken(self, name: str, role: str, index: str | None, why: str) -> Guess:
        """A guess of a column, in the unit that its name says."""
        return Guess(name, role, index, self.said[name].unit, why)

    def time(self) -> FloatArray | None:
        """The column of times."""
        return next((self.table[name] for name in self.of("t")), None)

    def unknown(self) -> list[str]:
        """Columns with numbers in most rows of which nothing is known."""
        return [
            name
            for name, values in self.table.items()
            if name not in self.found and np.isfinite(values).mean() > GUESSES.least_filled
        ]

    def free(self) -> list[str]:
        """Columns that move, and of which nothing is known."""
        return [name for name in self.unknown() if np.nanstd(self.table[name]) > 0.0]

    def less(self, names: Collection[str]) -> Columns:
        """Return a copy that knows nothing of some columns."""
        return replace(self, found={n: one for n, one in self.found.items() if n not in names})

    def known(self, further: Taken) -> Columns:
        """Return a copy that knows more columns."""
        return replace(self, found={**self.found, **further})


def scored(columns: Columns) -> dict[str, Guess]:
    """The guesses of an axis, the likeliest command, reading, velocity and effort first.

    What a name says and what the values do are added up, for each pair of columns that move: a
    reading follows its command late and with noise. `why` says what the values do.
    """
    pair = _asked_and_read(columns)
    rest = columns.less(columns.of(*LONE)) if pair else columns
    places = of_role(pair | rest.found, "position")
    if not places:
        return rest.found
    speeds, asked = rest.of("velocity"), of_role(pair, "command")
    still = [n for n in rest.of("effort") if asked and not np.nanstd(columns.table[n])]
    known = rest.less([*speeds, *still]).known(pair)  # what rests moves nothing
    slope = _slope_of(known, places[0])
    named = [columns.found[name] for name in speeds[:1]]
    speed = [columns.found.get(slope.source, slope)] if slope else named
    first = pair | {one.source: one for one in speed}
    if effort := _best_effort(known.known(first), places[0]):
        first[effort.source] = effort
    return first | known.less(first).found


class _Pair(NamedTuple):
    """Two columns as a command and its reading, and how much speaks for it."""

    score: float
    asked: str
    read: str
    alike: float


def _asked_and_read(columns: Columns) -> dict[str, Guess]:
    """The command and the reading of an axis, of all pairs of columns that may be them the one
    that scores most; empty where none may.
    """
    if any(columns.found[name].index is not None for name in columns.of(*LONE)):
        return {}
    best = max(_pairs_of_an_axis(columns), key=lambda pair: pair.score, default=None)
    return {} if best is None else _as_pair(columns, best)


def _pairs_of_an_axis(columns: Columns) -> Iterator[_Pair]:
    """All pairs of columns that may be command and reading, each both ways round."""
    named = columns.of(*LONE)
    free = [] if not named or _settled(columns) else columns.free()
    moving = [n for n in [*named, *free] if np.nanstd(columns.table[n]) > 0.0]
    if not all(never_falls(columns.table[n]) for n in named):  # what adds up is no motion then
        moving = [n for n in moving if n in named or not never_falls(columns.table[n])]
    for one, other in itertools.combinations(moving, 2):
        if _may_be_one_axis(columns, one, other):
            yield from _both_ways(columns, one, other)


def _settled(columns: Columns) -> bool:
    """Whether a command and a reading that are called so move alike."""
    table, both = columns.table, itertools.product(columns.of("command"), columns.of("position"))
    return any(correlation(table[one], table[other]) >= GUESSES.alike for one, other in both)


def _may_be_one_axis(columns: Columns, one: str, other: str) -> bool:
    """Whether two columns that differ are named as command and reading, or move alike."""
    a, b, roles = columns.table[one], columns.table[other], {*map(columns.role, (one, other))}
    alike = follows_step(a, b)
    one_motion = None not in roles or of_one_motion(a, b)
    fits = roles == set(LONE) or bool(alike >= GUESSES.alike and one_motion)
    return fits and not np.array_equal(a, b, equal_nan=True)


def _both_ways(columns: Columns, one: str, other: str) -> Iterator[_Pair]:
    """Two columns as command and reading, and the other way round.

    Beside an effort and without a name that says so, only one that comes first was asked for.
    """
    a, b = columns.table[one], columns.table[other]
    ahead, alike = lead(a, b)
    fits = min(-float(np.log10(max(1.0 - alike**2, 1e-9))), GUESSES.surest_fit)
    near = GUESSES.own_name * (_begins(one) == _begins(other))
    first, open_ = asks(a, b), columns.of("command") or not columns.of("effort")
    for asked, read, leads in ((one, other, first), (other, one, not first)):
        if is_analogue(asked) and not is_analogue(read):
            continue
        if open_ or (leads and ahead):
            says = _says_asked(columns, asked) - _says_asked(columns, read)
            came_first = GUESSES.came_first if leads else -GUESSES.came_first
            yield _Pair(says + fits + near + came_first, asked, read, alike)


def _as_pair(columns: Columns, pair: _Pair) -> dict[str, Guess]:
    """Guesses of two columns, with what speaks for them."""
    _, asked, read, alike = pair
    table, found = columns.table, columns.found
    role, index, why = "command", None, f"{LIKE.format(read)}, {EARLIER}"
    if columns.role(asked) == "command":
        says = found[asked].why.removesuffix(f", {EARLIER}")
        follows_it = f"{read} follows it ({alike**2:.0%})"
        why = f"{says}, {follows_it}" if alike**2 >= GUESSES.least_share else says
    elif _desired(asked, [*columns.of(*LONE), read]):
        why = f"by its name, {read} follows it ({alike**2:.0%})"
    elif read in found and is_count(table[asked]) and not is_count(table[read]):
        role, index = "steps", "1"
    seen = found[read].why if columns.role(read) == "position" else LIKE.format(asked)
    return {
        asked: columns.taken(asked, role, index, why),
        read: columns.taken(read, "position", None, seen),
    }


def _says_asked(columns: Columns, name: str) -> float:
    """1 where a name says that a column was asked for, -1 where it says that it was read."""
    if name not in columns.found:
        return 0.0
    if columns.role(name) == "command" or _desired(name, columns.of(*LONE)):
        return 1.0
    return -1.0 if (MEASURED | SEEN).intersection(in_words(name)) else -GUESSES.plainly_named


def _desired(name: str, names: Collection[str]) -> bool:
    """Whether a name is another's with a d for desired: q_d_0 beside q_0."""
    return (plain := _D.sub("", name)) != name and plain in names


def _begins(name: str) -> str:
    """The first word of a name, which columns of one joint share: X_Position, X_Current."""
    return re.split(r"[^0-9A-Za-z]+", name)[0]


def _slope_of(columns: Columns, position: str) -> Guess | None:
    """The column that is the slope of the reading, where none is called a velocity."""
    table, time, free = columns.table, columns.time(), columns.free()
    if time is None or not free or is_stepwise(table[position]):
        return None
    slope = np.gradient(table[position], *([time] if rising(time) else []))
    alike = {name: correlation(table[name], slope) for name in free}
    called = [n for n in free if columns.said[n].role == "velocity" and alike[n] > 0.5]
    best = max(called or free, key=lambda name: alike[name])
    among = [best, *columns.of(*LONE)]
    if alike[best] < GUESSES.alike_slope or difference(table, among) == best:
        return None
    return columns.taken(best, "velocity", None, f"it is the slope of {position}")


def _best_effort(columns: Columns, position: str) -> Guess | None:
    """The effort that scores most by its name and by how it goes with the motion; of columns that
    are not called so, one that goes with acceleration and the sign of speed alike.
    """
    table, at = columns.table, columns.table[position]
    called = [n for n in columns.of("effort") if columns.found[n].index is None]
    shares = {name: _share_of_motion(table[name], at) for name in called}
    shares = shares or dict(_as_an_effort_goes(columns, at))
    lone = len(called) == 1
    if not shares or (lone and shares[called[0]] == 0.0):
        return None
    own = {n for n in shares if _begins(n) == _begins(position)} or set(shares)
    best = max(shares, key=lambda name: _score_of_effort(columns.said, shares, name, name in own))
    goes = f"it goes with the motion ({shares[best]:.0%})"
    if called:
        tells = not lone and shares[best] >= GUESSES.least_share
        goes = f"by its name; {goes}" if tells else "by its name"
    return columns.taken(best, "effort", None, goes)


def _as_an_effort_goes(columns: Columns, position: FloatArray) -> Iterator[tuple[str, float]]:
    """Columns that nothing is known of and that go as an effort would, and how much they do."""
    table, movers = columns.table, columns.of(*LONE)
    for name in columns.free():
        if is_whole(table[name]) or pulls(name):  # a weight pulls too: it is asked
            continue
        share = share_of_both(table[name], position)
        if share > GUESSES.alike**2 and difference(table, [name, *movers]) != name:
            yield name, share


def _score_of_effort(
    said: Mapping[str, Named], shares: Mapping[str, float], name: str, own: bool
) -> float:
    """How likely a column is the effort of an axis; own: it is called as the reading is."""
    words = set(in_words(name))
    direct = 2.0 if words & TORQUES else 1.0 if words & CURRENTS else 0.0
    likely = 4.0 * (shares[name] >= GUESSES.least_share) + 8.0 * (direct > 0.0)
    measured = 0.5 * bool(words & MEASURED) - 2.5 * (said[name].asked or _desired(name, shares))
    return 16.0 * own + likely + direct + measured + 0.4 * shares[name]


def share_of_both(effort: FloatArray, position: FloatArray) -> float:
    """The share of an effort's variance that goes with the motion, 0 where acceleration alone or
    speed alone explains as much: the column is then one of these.

    That of the half of the rows where it is less: a few rows that fit by chance lie in one.
    """
    halves = zip(np.array_split(effort, 2), np.array_split(position, 2), strict=True)
    whole = min(_share_of_motion(*half) for half in halves)
    alone = max(_share_of_motion(effort, position, only) for only in ((0,), (1,)))
    return whole if whole - alone > GUESSES.more_than_alone else 0.0


def _share_of_motion(
    effort: FloatArray, position: FloatArray, only: tuple[int, ...] = (0, 1, 2)
) -> float:
    """Share of an effort's variance that acceleration, speed and its sign explain (`only` those).

    Over several spans of rows, of which the best counts: noise of a position rules over few.
    """
    shares = [0.0]
    for rows in GUESSES.slope_rows:
        if len(position) < GUESSES.fewest_in_common * rows:
            break
        at = np.nan_to_num(position[::rows], nan=float(np.nanmean(position)))
        seen = effort[::rows]
        speed = np.gradient(at)
        motion = (np.gradient(speed), speed, np.sign(speed))
        shapes = np.stack([*(motion[n] for n in only), np.ones(len(at))], axis=1)
        known = np.isfinite(seen)
        left = len(seen[known]) - shapes.shape[1]
        spread = float(np.var(seen[known])) if left > 0 else 0.0
        if spread > 0.0:
            size = np.linalg.lstsq(shapes[known], seen[known], rcond=None)[0]
            missed = float(np.sum((seen[known] - shapes[known] @ size) ** 2)) / left
            shares.append(1.0 - missed / spread)
    return max(shares)
