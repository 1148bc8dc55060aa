"""The unit of positions and distances of which none is said, and what else it may be."""

from __future__ import annotations

import re
import shlex
from collections.abc import Iterable, Iterator, Sequence
from dataclasses import dataclass, replace

import numpy as np

from deltactl.recording.column_measures import travel
from deltactl.recording.foreign.doubts import (
    ANGULAR,
    READ,
    RTDE,
    counts_like,
    of_counts,
    of_encoder,
    turns,
    whole,
)
from deltactl.recording.foreign.mapping import as_option
from deltactl.recording.foreign.names import (
    AS_SAID,
    Guess,
    Taken,
    in_words,
    is_of_joint,
    without_unit,
)
from deltactl.recording.foreign.notes import Hint, Note
from deltactl.recording.foreign.options import GUESSES
from deltactl.recording.foreign.shapes import Table, same_range
from deltactl.recording.foreign.units import (
    FORCES,
    IN_SI,
    LINEAR,
    LINEAR_SPEEDS,
    LONE,
    ROTARY_SPEEDS,
    TORQUES,
    of_motion,
    size_of,
)
from deltactl.recording.reading.run import FloatArray

PAIRS = (
    ("command", "position"),
    ("distance", "range"),
    *((f"command_{n}", f"theta_{n}") for n in (1, 2, 3)),
)
"""What was asked for, and what came of it."""
STRAIGHT = ("pos", "range", "distance")
COUNTS = frozenset({"count", "counts", "cnt", "tick", "ticks", "steps", "raw", "inkremente"})
"""What headings call the counts of an encoder."""
TAKEN = {None: "rad", "rotary": "rad", "linear": "m"}
"""By the motion of an axis, the unit that is taken where neither a word nor the size tells one."""
OF_DATA = re.compile(r"[^.]+\.(pos|goal)")
"""How LeRobot calls what a joint did and its command, in degrees; where all joints are together,
below `action`, their values say more."""
NO_UNIT = "nothing says the unit"
OF_COUNTS = (
    "numbers up to {:g}, taken for encoder counts, 4096 a turn; if a turn has others, put"
    f" what one count is [rad] in place of {GUESSES.count_rad} into the printed command"
)


def of_one_unit(guesses: Taken, table: Table) -> Iterator[list[Guess]]:
    """Columns of motion, those together that have one unit though none is said: the angles of all
    arms, the places of one platform, and the command and the reading of one axis that go over the
    same numbers.
    """
    left = {guess.name: guess for guess in guesses.values() if guess.role in (*ANGULAR, *STRAIGHT)}
    arms = [one for one in left.values() if one.index in ("1", "2", "3") and is_open(one)]
    places = [one for one in left.values() if one.role == "pos" and is_open(one)]
    groups = [group for group in (arms, places, *_pairs_alike(left, table)) if group]
    yield from groups
    together = {one.name for group in groups for one in group}
    yield from ([one] for one in left.values() if one.name not in together)


def _pairs_alike(left: Taken, table: Table) -> Iterator[list[Guess]]:
    """A command and its reading, a distance and its range, that go over the same numbers."""
    for names in PAIRS[:2]:
        pair = [left[name] for name in names if name in left and is_open(left[name])]
        if len(pair) == 2 and _go_alike(*(table[one.source] for one in pair)):
            yield pair


def _go_alike(one: FloatArray, other: FloatArray) -> bool:
    """Whether two columns go over the same numbers, or as far where their zeros differ."""
    wide, told = travel(one), travel(other)
    as_far = max(wide, told) < GUESSES.other_unit * min(wide, told)
    return as_far or same_range(one, other)


def is_open(guess: Guess) -> bool:
    """Whether nothing says the unit of a column."""
    return guess.unit is None and guess.scale == 1.0


def unit_of_motion(
    group: Sequence[Guess], table: Table, motion: str | None
) -> tuple[list[Guess], str]:
    """The columns of a group with their unit, and what to be warned of; empty where of nothing, and
    where it is asked for the unit.

    motion: linear or rotary, where that is known of the axis.
    """
    guess, values = group[0], np.concatenate([table[one.source] for one in group])
    if guess.scale != 1.0:  # somebody knows
        return list(group), ""
    if guess.unit is not None:
        return list(group), _doubt(guess, values)
    largest = float(np.nanmax(np.abs(values)))
    if guess.role in STRAIGHT or motion == "linear":
        return _of_lengths(group, largest)
    if (stepped := _of_steps(group, table)) is not None:
        return stepped, ""
    if (found := _of_called(group, largest, motion)) is not None:
        return found
    few = largest <= (GUESSES.one_turn_rad if _is_lone(group) else GUESSES.widest_rad)
    if _called_counts(group, table) or (counts_like(values) and not few):
        says = Note.on(_names(group), OF_COUNTS.format(largest))
        return _all(group, "rad", GUESSES.count_rad), says
    return (list(group), "") if few else _of_degrees(group, largest, motion)


def _called_counts(group: Sequence[Guess], table: Table) -> bool:
    """Whether what was read is called counts; a command in counts may have decimals."""
    read = [one for one in group if one.role in READ] or group
    return all(_says_counts(one.source, table[one.source]) for one in read)


def _of_degrees(
    group: Sequence[Guess], largest: float, motion: str | None
) -> tuple[list[Guess], str]:
    """Columns that go further than a turn in rad, and are no counts."""
    says = f"up to {largest:g}, taken for degrees"
    if not _is_lone(group):  # which no machine has in mm
        return _all(group, "deg"), Note.on(_names(group), f"{says}, as all angles of the arms")
    rotary, linear = units_of_size(largest, "rotary" if turns_by_name(group) else motion)
    is_asked = len(rotary) + len(linear) > 1
    return _all(group, "deg"), "" if is_asked else rather(says, "radians", group, "rad")


def _of_lengths(group: Sequence[Guess], largest: float) -> tuple[list[Guess], str]:
    """Distances and places, in m or in mm by their size."""
    if largest <= GUESSES.longest_m:
        return list(group), ""
    says = f"up to {largest:g}, taken for mm"
    if group[0].role in STRAIGHT:
        return _all(group, "mm"), Note.on(_names(group), says)
    return _all(group, "mm"), rather(f"{says}, as the axis slides", "metres", group, "m")


def _of_called(
    group: Sequence[Guess], largest: float, motion: str | None
) -> tuple[list[Guess], str] | None:
    """Columns of one axis in the unit that others with such names have; None where none is."""
    if not _is_lone(group):
        return None
    if all(RTDE.match(one.source) for one in group) and largest <= GUESSES.widest_rad:
        return [
            replace(one, unit="rad", why=f"{one.why}; logs of RTDE are in rad") for one in group
        ], ""
    if all(OF_DATA.fullmatch(one.source) and is_of_joint(one.source) for one in group):
        says = f"{NO_UNIT}; taken for degrees, as most arms with such names are written in"
        return _all(group, "deg", guessed=False), rather(says, "radians", group, "rad")
    if motion == "rotary" or largest <= GUESSES.longest_m or not all(map(_is_place, group)):
        return None
    says = f"up to {largest:g}, taken for mm, as axes called x, y or z slide"
    return _all(group, "mm", guessed=False), rather(says, "degrees", group, "deg")


def _is_lone(group: Sequence[Guess]) -> bool:
    """Whether columns are those of one axis, which may slide as well."""
    return all(one.index is None for one in group)


def _is_place(guess: Guess) -> bool:
    """Whether a word of a name is x, y or z, and none that of a joint."""
    return bool(set("xyz") & set(in_words(guess.source))) and not is_of_joint(guess.source)


def _says_counts(heading: str, values: FloatArray) -> bool:
    """Whether a heading says counts, and whole numbers (n,) are below it."""
    return whole(values) and bool(COUNTS & set(re.split(r"[^a-z]+", heading.lower())))


def _all(
    group: Sequence[Guess], unit: str, scale: float = 1.0, guessed: bool = True
) -> list[Guess]:
    return [replace(one, unit=unit, scale=scale, unit_guessed=guessed) for one in group]


def rather(says: str, other: str, group: Sequence[Guess], unit: str, also: str = "") -> Hint:
    """What columns were taken for, and the unit to say if they are something else.

    The one that was read is enough: what was asked for has the same.
    """
    # What a heading says is denied column by column, by a factor.
    read = next((one for one in group if one.role in READ), group[0])
    said = [(read, None)] if is_open(read) else [(one, 1.0) for one in group]
    words = [
        word
        for one, factor in said
        for word in ("--set", as_option(one.name, without_unit(one.source), unit, factor, 0.0))
    ]
    again = f"inspect it with {shlex.join(words)}{also}"
    return Hint.of(f"{says}; if it is {other}", "unit", _names(group), unit, again)


def units_of_size(largest: float, motion: str | None) -> tuple[list[str], list[str]]:
    """Units in which an axis may go up to a number, where it turns and where it slides."""
    few = largest <= GUESSES.said_factor * GUESSES.widest_rad
    turning = {"deg": True, "rad": few, "turn": few, "arcsec": largest > GUESSES.few_turns_deg}
    longest_mm = 1e3 * GUESSES.longest_m
    sliding = {
        "mm": largest <= longest_mm,
        "m": largest <= GUESSES.longest_m,
        "um": largest > longest_mm,
    }
    rotary, linear = ([one for one, may_be in of.items() if may_be] for of in (turning, sliding))
    return ([] if motion == "linear" else rotary, [] if motion == "rotary" else linear)


def _names(group: Sequence[Guess]) -> list[str]:
    return [one.source for one in group]


def _of_steps(group: Sequence[Guess], table: Table) -> list[Guess] | None:
    """The group in the unit that the steps of its readings tell; None where they tell none."""
    read = [one.source for one in group if one.role in READ]
    told = {name: found for name in read if (found := of_encoder(table[name])) is not None}
    units = {unit for unit, _ in told.values()}
    if len(units) != 1:
        return None
    (unit,) = units
    why = {name: f"reads {step}" for name, (_, step) in told.items()}
    like = f"in the unit of {next(iter(told))}"
    return [replace(one, unit=unit, why=f"{one.why}; {why.get(one.source, like)}") for one in group]


def motion_beside(guesses: Taken) -> str | None:
    """How an axis moves by the units that headings give beside its motion: a torque or a speed in
    rpm turns it, a force slides it; None where they say nothing, or a name says that it slides.
    """
    own = [one for one in guesses.values() if one.name in LONE]
    if any(one.unit in LINEAR or _is_place(one) for one in own):
        return None
    units = {one.unit for one in guesses.values() if not one.unit_guessed}
    turns, slides = units & {*TORQUES, *ROTARY_SPEEDS}, units & {*FORCES, *LINEAR_SPEEDS}
    if bool(turns) == bool(slides):
        return None
    return "rotary" if turns else "linear"


def turns_by_name(group: Iterable[Guess]) -> bool:
    """Whether a name among these is that of a joint, or says that it is an angle."""
    return any(is_of_joint(one.source) for one in group)


@dataclass(frozen=True, slots=True)
class Asked:
    """What nothing in a table of an axis tells, and its owner has to say: the unit of its motion,
    and with it whether it turns or slides.
    """

    columns: Sequence[str]
    """Names of command and position in the file."""
    rotary: Sequence[str]
    """Units they may have where it turns; none where it is known to slide."""
    linear: Sequence[str]
    """The same where it slides."""

    @property
    def motion(self) -> bool:
        """Whether it is not known either if it turns or slides."""
        return bool(self.rotary and self.linear)

    @property
    def named(self) -> str:
        """The columns with commas between."""
        return ", ".join(self.columns)

    @property
    def units(self) -> str:
        """The units to choose from."""
        return of_motion(self.rotary, self.linear)


def ask_unit(
    guesses: Taken, table: Table, motion: str | None = None
) -> tuple[dict[str, str], Asked | None]:
    """Units that are taken until somebody says one, by the columns' names in the contract, and what
    is to be asked; nothing where a word or the size decides.

    motion: linear or rotary, where that is known.
    """
    open_ = [guess for guess in guesses.values() if guess.name in LONE and guess.unsaid]
    if not open_:
        return {}, None
    largest = max(float(np.nanmax(np.abs(table[one.source]))) for one in open_)
    rotary, linear = units_of_size(largest, motion)
    if len(rotary) + len(linear) == 1:
        return {}, None
    if linear and largest * IN_SI["inch"] <= GUESSES.longest_m:
        linear.append("inch")
    unit = TAKEN[motion]
    taken = {one.name: one.unit or unit for one in open_}
    if any(one.name == "velocity" and is_open(one) for one in guesses.values()):
        taken["velocity"] = f"{unit}/s"
    return taken, Asked(_names(open_), rotary, linear)


def in_unit(guesses: Taken, unit: str | None) -> dict[str, Guess]:
    """Guesses with the unit that somebody says of what an axis does."""
    if unit is None:
        return dict(guesses)
    given = {"unit": unit} if unit in IN_SI else {"scale": size_of(unit)}
    lone = (name for name, one in guesses.items() if one.name in LONE and is_open(one))
    return {**guesses, **{name: replace(guesses[name], **given) for name in lone}}


def _doubt(guess: Guess, values: FloatArray) -> str:
    """What is odd about values in the unit that was said; empty where nothing is."""
    largest, unit, name = float(np.nanmax(np.abs(values))), guess.unit, guess.source
    if guess.why == AS_SAID:  # only what no reader takes
        return Note(of_counts(guess.name, name, unit or "1", values), [name])
    if unit == "rad" and largest > GUESSES.said_factor * GUESSES.widest_rad:
        far = f"{largest:g} ({turns(largest)})"
        return Note.on([name], f"is said to be rad and goes up to {far}; degrees?")
    if unit == "m" and largest > GUESSES.longest_m:
        return Note.on([name], f"is said to be m and goes up to {largest:g}; millimetres?")
    if unit is not None and (why := of_counts(guess.name, name, unit, values)):
        return Note(why, [name])
    if unit == "deg" and largest < GUESSES.narrowest_deg:
        return Note.on([name], f"is said to be deg and stays below {largest:.3g}; radians?")
    return ""
