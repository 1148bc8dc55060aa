"""What columns are by their numbers, where names say nothing, or not all of it; and which of
several columns it is that could be the same thing.
"""

from __future__ import annotations

import itertools
import re
from collections.abc import Collection, Iterator, Mapping, Sequence

import numpy as np

from deltactl.recording.foreign.names import MEASURED, SEEN, TORQUES, Guess, Named, in_words, pulls
from deltactl.recording.foreign.options import GUESSES
from deltactl.recording.foreign.shapes import (
    asks,
    correlation,
    difference,
    follows,
    follows_step,
    is_count,
    is_flag,
    is_label,
    is_stepwise,
    is_whole,
    lead,
    of_one_motion,
    pairs_alike,
    rising,
    roughness,
    slopes,
)
from deltactl.recording.format.messages import MOTORS
from deltactl.recording.reading.run import FloatArray

_D = re.compile(r"_d(?![A-Za-z])")
CURRENTS = frozenset(["current", "strom", "iq", "i_q", "courant", "corriente", "corrente", "amps"])


def scored(
    table: Mapping[str, FloatArray], said: Mapping[str, Named], found: Mapping[str, Guess]
) -> dict[str, Guess]:
    """The guesses of an axis, the likeliest command, reading, velocity and effort first.

    What a name says and what the values do are added up, for each pair of columns that move: a
    reading follows its command late and with noise. `why` says what the values do.
    """
    first = _asked_and_read(table, said, found)
    rest = {n: guess for n, guess in found.items() if n not in first}
    if first:
        rest = {n: one for n, one in rest.items() if one.role not in ("command", "position")}
    position = next((n for n, one in {**first, **rest}.items() if one.role == "position"), None)
    if position is None:
        return first | rest
    speeds = [n for n, guess in rest.items() if guess.role == "velocity"]
    rest = {n: guess for n, guess in rest.items() if n not in speeds}
    if any(guess.role == "command" for guess in first.values()):  # what rests moves nothing
        rest = {n: one for n, one in rest.items() if one.role != "effort" or np.nanstd(table[n])}
    others = {n: guess for n, guess in {**rest, **first}.items() if n not in speeds}
    slope = _slope_of(table, said, others, position)
    first |= {n: found.get(n, guess) for n, guess in slope.items()}
    first |= {n: found[n] for n in speeds[:1] if not slope}
    if effort := _best_effort(table, said, {**rest, **first}, position):
        first[effort.source] = effort
    return first | {n: guess for n, guess in rest.items() if n not in first}


def _asked_and_read(
    table: Mapping[str, FloatArray], said: Mapping[str, Named], found: Mapping[str, Guess]
) -> dict[str, Guess]:
    """The command and the reading of an axis, of all pairs of columns that may be them the one
    that scores most; empty where none may.
    """
    movers = {n: guess for n, guess in found.items() if guess.role in ("command", "position")}
    if any(guess.index is not None for guess in movers.values()):
        return {}
    named = {guess.role for guess in movers.values()}
    effort = any(guess.role == "effort" for guess in found.values())
    settled = len(named) == 2 and any(
        correlation(table[one], table[other]) >= GUESSES.alike
        for one, other in itertools.combinations(movers, 2)
        if movers[one].role != movers[other].role
    )
    free = [] if settled or not movers else _free(table, found)
    moving = [n for n in [*movers, *free] if n in table and np.nanstd(table[n]) > 0.0]
    best, pair = -np.inf, None
    for one, other in itertools.combinations(moving, 2):
        if not _may_be_one_axis(table, movers, one, other):
            continue
        follows_by, alike = lead(table[one], table[other])
        fits = min(-float(np.log10(max(1.0 - alike**2, 1e-9))), GUESSES.surest_fit)
        near = GUESSES.own_name * (_begins(one) == _begins(other))
        first = asks(table[one], table[other])
        for asked, read, leads in ((one, other, first), (other, one, not first)):
            if effort and "command" not in named and not (leads and follows_by):
                continue
            says = _says_asked(asked, said, movers) - _says_asked(read, said, movers)
            score = says + fits + near + (GUESSES.came_first if leads else -GUESSES.came_first)
            if score > best:
                best, pair = score, (asked, read, alike)
    return {} if pair is None else _as_pair(*pair, table, said, movers)


def _may_be_one_axis(
    table: Mapping[str, FloatArray], movers: Mapping[str, Guess], one: str, other: str
) -> bool:
    """Whether two columns that differ are named as command and reading, or move alike."""
    alike = follows_step(table[one], table[other])
    as_named = {movers[n].role for n in (one, other) if n in movers} == {"command", "position"}
    one_motion = {one, other} <= movers.keys() or of_one_motion(table[one], table[other])
    differ = not np.array_equal(table[one], table[other], equal_nan=True)
    return differ and (as_named or bool(alike >= GUESSES.alike and one_motion))


def _as_pair(
    asked: str,
    read: str,
    alike: float,
    table: Mapping[str, FloatArray],
    said: Mapping[str, Named],
    movers: Mapping[str, Guess],
) -> dict[str, Guess]:
    """Guesses of two columns, with what they were taken for it."""
    follows_it = f"{read} follows it ({alike**2:.0%})" if alike**2 >= GUESSES.least_share else ""
    as_asked = asked in movers and movers[asked].role == "command"
    says = movers[asked].why if as_asked else ""
    why = ", ".join(filter(None, [says.removesuffix(f", {EARLIER}"), follows_it]))
    role = "command"
    if not as_asked and read not in movers:
        why = f"moves like {read}, {EARLIER}"
    elif not as_asked:
        why = f"moves like {read}, {EARLIER}"
        role = "steps" if is_count(table[asked]) and not is_count(table[read]) else role
    seen = movers[read].why if read in movers and movers[read].role == "position" else ""
    return {
        asked: Guess(asked, role, "1" if role == "steps" else None, said[asked].unit, why),
        read: Guess(read, "position", None, said[read].unit, seen or f"moves like {asked}"),
    }


def _says_asked(name: str, said: Mapping[str, Named], movers: Mapping[str, Guess]) -> float:
    """1 where a name says that a column was asked for, -1 where it says that it was read."""
    if name not in movers:
        return 0.0
    if movers[name].role == "command" or _desired(name, movers):
        return 1.0
    return -1.0 if (MEASURED | SEEN).intersection(in_words(name)) else -GUESSES.plainly_named


def _desired(name: str, names: Collection[str]) -> bool:
    """Whether a name is another's with a d for desired: q_d_0 beside q_0."""
    return (plain := _D.sub("", name)) != name and plain in names


def _begins(name: str) -> str:
    """The first word of a name, which columns of one joint share: X_Position, X_Current."""
    return re.split(r"[^0-9A-Za-z]+", name)[0]


def _slope_of(
    table: Mapping[str, FloatArray],
    said: Mapping[str, Named],
    found: Mapping[str, Guess],
    position: str,
) -> dict[str, Guess]:
    """The column that is the slope of the reading, where none is called a velocity."""
    time = next((table[n] for n, guess in found.items() if guess.role == "t"), None)
    free = _free(table, found)
    if time is None or not free or is_stepwise(table[position]):
        return {}
    slope = np.gradient(table[position], *([time] if rising(time) else []))
    alike = {name: correlation(table[name], slope) for name in free}
    called = [name for name in free if said[name].role == "velocity" and alike[name] > 0.5]
    best = max(called or free, key=lambda name: alike[name])
    if alike[best] < GUESSES.alike_slope or difference(table, [best, *_movers(found)]) == best:
        return {}
    return {best: Guess(best, "velocity", None, said[best].unit, f"it is the slope of {position}")}


def _movers(found: Mapping[str, Guess]) -> list[str]:
    return [name for name, guess in found.items() if guess.role in ("command", "position")]


def _best_effort(
    table: Mapping[str, FloatArray],
    said: Mapping[str, Named],
    found: Mapping[str, Guess],
    position: str,
) -> Guess | None:
    """The effort that scores most by its name and by how it goes with the motion; of columns that
    are not called so, one that goes with acceleration and the sign of speed alike.
    """
    called = [n for n, one in found.items() if one.role == "effort" and one.index is None]
    shares = {name: _share_of_motion(table[name], table[position]) for name in called}
    if not called:
        shares = {
            name: share
            for name in _free(table, found)
            if not (is_whole(table[name]) or pulls(name))  # a weight pulls too: it is asked
            and (share := _share_of_both(table[name], table[position])) > GUESSES.alike**2
            and difference(table, [name, *_movers(found)]) != name
        }
    if not shares or (len(called) == 1 and called[0] in found and shares[called[0]] == 0.0):
        return None
    own = {n for n in shares if _begins(n) == _begins(position)} or set(shares)

    def score(name: str) -> float:
        words = set(in_words(name))
        direct = 2.0 if words & TORQUES else 1.0 if words & CURRENTS else 0.0
        likely = 4.0 * (shares[name] >= GUESSES.least_share) + 8.0 * (direct > 0.0)
        measured = 0.5 * bool(words & MEASURED) - 2.5 * (said[name].asked or _desired(name, shares))
        return 16.0 * (name in own) + likely + direct + measured + 0.4 * shares[name]

    best = max(shares, key=score)
    by_name = "by its name" if called else ""
    goes = f"it goes with the motion ({shares[best]:.0%})"
    if len(called) == 1 or shares[best] < GUESSES.least_share:
        goes = "" if called else goes
    why = "; ".join(filter(None, [by_name, goes]))
    return Guess(best, "effort", None, said[best].unit, why)


def _share_of_both(effort: FloatArray, position: FloatArray) -> float:
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


ASKED = frozenset({"command", "steps", "distance"})
"""What a reading is compared with."""
EARLIER = "smoother or earlier"
"""Why one of two columns that move alike is the command, where no name says it."""


def by_values(
    table: Mapping[str, FloatArray], said: Mapping[str, Named], found: Mapping[str, Guess]
) -> Iterator[Guess]:
    """Roles from shapes: pairs that move alike are command and reading, slopes are velocities."""
    filled = [n for n in table if np.isfinite(table[n]).mean() > GUESSES.least_filled]
    free = [n for n in filled if n not in found]
    moving = [n for n in free if np.ptp(np.diff(table[n])) != 0.0]  # neither still nor a count
    if deltas := _three_motors(table, moving, free):
        yield from deltas
        return
    for name in [n for n in moving if is_label(table[n])]:
        moving.remove(name)
        yield Guess(name, "segment", None, None, "few whole numbers, one after another")
    time = next((table[n] for n, guess in found.items() if guess.role == "t"), None)
    if len(moving) <= GUESSES.few_columns and (error := difference(table, moving)):
        moving.remove(error)
    speeds = [] if time is None else list(slopes(table, moving, time))
    with_slope = {of for _, of in speeds}
    for velocity, of in speeds:
        moving.remove(velocity)
        yield Guess(velocity, "velocity", None, said[velocity].unit, f"it is the slope of {of}")
    pairs = list(pairs_alike(table, moving))
    pairs.sort(key=with_slope.isdisjoint)  # currents move alike too, and have no velocity
    yield from _of_pairs(table, said, pairs)
    rest = [n for n in moving if n not in {name for pair in pairs for name in pair}]
    if not pairs:
        yield from _of_lone(table, said, rest, list(with_slope))
    elif len(pairs) == 1 and rest:
        yield Guess(rest[0], "effort", None, said[rest[0]].unit, "what is left; may be another")


def _of_pairs(
    table: Mapping[str, FloatArray], said: Mapping[str, Named], pairs: list[tuple[str, str]]
) -> Iterator[Guess]:
    """What two columns are that move alike; of more pairs than a delta has motors the first."""
    indices: Sequence[str | None] = ["1", "2", "3"] if len(pairs) == MOTORS else [None]
    why = "moves like {}"
    for (asked, seen), index in zip(pairs, indices, strict=False):
        like = why.format(asked)
        if is_count(table[asked]) and not is_count(table[seen]):
            words = f"whole numbers; {why.format(seen)}"
            yield Guess(asked, "steps", index or "1", None, words)
            yield Guess(seen, "theta", index or "1", said[seen].unit, like)
        elif is_stepwise(table[asked]) and len(pairs) == 1 and table[asked].min() >= 0.0:
            words = f"rests in turns; {why.format(seen)}"
            yield Guess(asked, "distance", None, said[asked].unit, words)
            yield Guess(seen, "range", None, said[seen].unit, like)
        else:
            words = f"{why.format(seen)}, {EARLIER}"
            yield Guess(asked, "command", index, said[asked].unit, words)
            role = "position" if index is None else "theta"
            yield Guess(seen, role, index, said[seen].unit, like)


def _of_lone(
    table: Mapping[str, FloatArray],
    said: Mapping[str, Named],
    rest: list[str],
    with_slope: list[str],
) -> Iterator[Guess]:
    """Columns of which no two move alike: a position, and what it was asked or driven by."""
    rest = [n for n in rest if not is_flag(table[n])]
    if not rest:
        return
    steady = [n for n in rest if is_stepwise(table[n])][: len(rest) - 1]
    others = [n for n in rest if n not in steady[:1]]
    known = [n for n in with_slope if n in others]
    place = known[0] if known else min(others, key=lambda n: roughness(table[n]))
    if roughness(table[place]) > GUESSES.roughest:
        return
    why = "another column is its slope" if known else "the smoothest of the columns"
    yield Guess(place, "position", None, said[place].unit, why)
    others.remove(place)
    for name in steady[:1]:
        yield Guess(name, "command", None, said[name].unit, "it rests in turns")
    for name in others[: 0 if steady else 1]:
        goes = _share_of_both(table[name], table[place]) > GUESSES.alike**2
        if known or len(rest) == 2 or goes:  # of two there is nothing else that it could be
            yield Guess(name, "effort", None, said[name].unit, "what is left; may be another")


def _three_motors(
    table: Mapping[str, FloatArray], moving: list[str], free: list[str]
) -> list[Guess]:
    """Three counts, and three readings that follow them: a delta. Empty where it is none."""
    counts = [name for name in moving if is_count(table[name])]
    others = [name for name in moving if not is_whole(table[name])]
    if len(counts) != 3:
        return []
    others = [name for name in others if follows(table[name], [table[n] for n in counts])]
    if len(others) < 3:
        return []
    found = [
        Guess(name, "steps", str(n + 1), None, "three columns of whole numbers")
        for n, name in enumerate(counts)
    ]
    found += [
        Guess(name, "range", axis, None, "three readings beside three counts")
        for name, axis in zip(others, "xyz", strict=False)
    ]
    small = [n for n in free if n not in counts and is_whole(table[n])]
    if len(small) == 3:
        found += [
            Guess(name, "status", axis, None, "small whole numbers, three of them")
            for name, axis in zip(small, "xyz", strict=True)
        ]
    return found


def partners(
    table: Mapping[str, FloatArray], said: Mapping[str, Named], found: Mapping[str, Guess]
) -> Iterator[Guess]:
    """What moves like a column that is known by its name, and has no name itself: the reading of a
    command, the command of a reading, the range of a distance.
    """
    roles = {guess.role for guess in found.values()}
    free = _free(table, found)

    def of(*wanted: str) -> list[Guess]:
        return [guess for guess in found.values() if guess.role in wanted]

    if not roles & {"position", "range"} and roles & ASKED:
        for guess, name in _nearest(table, of(*ASKED), free):
            yield _read(guess, name, "range" if guess.role == "distance" else "position", said)
    elif not roles & {*ASKED, "effort"}:
        for guess, name in _nearest(table, of("range")[:1], free):
            yield _read(guess, name, "distance", said)


def _free(table: Mapping[str, FloatArray], found: Mapping[str, Guess]) -> list[str]:
    """Columns that move, and of which nothing is known."""
    return [
        name
        for name, values in table.items()
        if name not in found
        and np.isfinite(values).mean() > GUESSES.least_filled
        and np.nanstd(values) > 0.0
    ]


def _nearest(
    table: Mapping[str, FloatArray], known: list[Guess], free: list[str]
) -> Iterator[tuple[Guess, str]]:
    """Each of the known columns with the free one that moves most like it; each column once."""
    alike = [
        (round(likeness, 3), -_apart(table[guess.source], table[name]), guess, name)
        for guess in known
        for name in free
        if name != guess.source
        and (likeness := correlation(table[guess.source], table[name])) >= GUESSES.alike
    ]
    used: set[str] = set()
    for _, _, guess, name in sorted(alike, key=lambda one: one[:2], reverse=True):
        if guess.source not in used and name not in used:
            used |= {guess.source, name}
            yield guess, name


def _apart(one: FloatArray, other: FloatArray) -> float:
    return float(np.nanmean(np.abs(one - other)))


def _read(known: Guess, name: str, role: str, said: Mapping[str, Named]) -> Guess:
    return Guess(name, role, known.index, said[name].unit, f"moves like {known.source}")
