"""Units that values suggest, and warnings where they look like another unit than the one said."""

from __future__ import annotations

import re
import shlex
from collections.abc import Mapping, Sequence
from dataclasses import replace

import numpy as np

from deltactl.recording.column_measures import travel
from deltactl.recording.foreign.doubts import ANGULAR, slope_ratio
from deltactl.recording.foreign.mapping import as_option
from deltactl.recording.foreign.motion_units import (
    PAIRS,
    is_open,
    motion_beside,
    of_one_unit,
    rather,
    unit_of_motion,
)
from deltactl.recording.foreign.names import BY_NAME, Guess, Taken, by_name, without_unit
from deltactl.recording.foreign.notes import Note, not_about
from deltactl.recording.foreign.options import GUESSES
from deltactl.recording.foreign.shapes import Table, lead, same_range
from deltactl.recording.foreign.units import (
    IN_SI,
    LINEAR,
    ROTARY,
    SPEEDS,
    SPEEDS_OF,
    UNIT_OF,
)
from deltactl.recording.reading.run import FloatArray

RATIOS: tuple[tuple[float, str, str], ...] = (
    (1.0 / IN_SI["deg"], "deg", "rad"),
    (1.0 / IN_SI["mm"], "mm", "m"),
    (1.0 / IN_SI["cm"], "cm", "m"),
    (4096.0 / (2.0 * np.pi), "counts of 4096 a turn", "rad"),
)
"""How many of the first unit are one of the second."""


def time_unit(
    t: FloatArray, late_rows: int = 0, thousandfold: str | None = None
) -> tuple[str, str]:
    """Unit of a time column without one, and why: whole numbers are ticks of a computer's clock.

    late_rows: by which a reading follows its command; no axis is seconds late. thousandfold: a
    velocity that is a thousand times the slope of its position by these times.
    """
    step = float(np.median(np.diff(t)))
    whole = bool((t == np.round(t)).all())
    ticks, ticks_ns = GUESSES.ticks_ns
    if step >= ticks and whole:
        in_ns = step >= ticks_ns
        return ("ns", "steps of some million") if in_ns else ("us", "steps of some thousand")
    if step >= GUESSES.ticks_us and whole:
        return "us", f"whole numbers, {step:g} apart"
    if step == GUESSES.ticks_ms and whole and thousandfold is not None:
        return "ms", f"1 apart, as {thousandfold} shows"
    if step == GUESSES.ticks_ms and whole and late_rows > 0:
        return "ms", f"1 apart, and the reading is {late_rows} rows late"
    if (step > GUESSES.ticks_ms and whole) or step > GUESSES.longest_step_s:
        return "ms", f"{step:g} apart"
    return "s", f"{step:.3g} apart"


ANGLE_WORDS = {
    word: unit
    for word, unit in UNIT_OF.items()
    if unit in ROTARY and unit != "turn" and word not in ("grad", "°")
}
"""Words that are an angle's unit wherever they occur; a turn or a grad may be something else."""
_A_WORD = re.compile(r"(?<![\w.])(\d[\d.,]*[ -]?)?([A-Za-zµ]+)(?!\w)")


def unit_noted(guesses: Taken, lines: Sequence[str]) -> tuple[dict[str, Guess], list[str]]:
    """Angles in the one unit that comment lines before a table name, and a word of that.

    A word behind a number is a size (30 degrees); with a unit of length nothing is known.
    """
    units = _angles_in(" ".join(line for line in lines if line.lstrip()[:1] in "#%"))
    open_ = [n for n, guess in guesses.items() if guess.role in ANGULAR and is_open(guess)]
    if len(units) != 1 or not open_:
        return dict(guesses), []
    (unit,) = units
    noted = {name: replace(guesses[name], unit=unit) for name in open_}
    says = (
        f"taken for {unit}, which a comment before the table names; where that is something else's,"
        " put the right unit into the printed command"
    )
    return {**guesses, **noted}, [Note.on([*noted], says)]


def _angles_in(notes: str) -> set[str]:
    """The units of angles that a text names; none where it names a unit of length."""
    words = [word for size, word in _A_WORD.findall(notes) if not size]
    lengths = any(len(word) > 1 and UNIT_OF.get(word) in LINEAR for word in words)
    return set() if lengths else {ANGLE_WORDS[word] for word in words if word in ANGLE_WORDS}


def with_units(
    guesses: Taken, table: Table, motion: str | None = None
) -> tuple[dict[str, Guess], list[str]]:
    """Guesses with a unit where the values tell one, and what to be warned of.

    motion: of a single axis, where it is known.
    """
    guesses = _shared({name: _per_second(guess) for name, guess in guesses.items()}, table)
    out, warnings = dict(guesses), list[str]()
    if motion is None and any(one.unit in ROTARY for one in guesses.values()):
        motion = "rotary"
    motion = motion or motion_beside(guesses)
    for name, guess in guesses.items():
        if guess.role == "t" and guess.unit is None:
            late = _late_rows(guesses, table) if guess.why == "by its name" else 0
            unit, why = time_unit(table[name], late, _thousandfold(guesses, table, name))
            out[name] = replace(guess, unit=unit, unit_guessed=unit != "s")
            if unit != "s":
                says = f"taken for {unit} ({why}); the file gives no unit"
                warnings.append(Note.on([name], says))
    for group in of_one_unit(guesses, table):
        known, warning = unit_of_motion(group, table, motion)
        out |= {guess.source: guess for guess in known}
        warnings += [warning] if warning else []
    warnings = [*_counts_by_speed(out, table, warnings), *_pairs(out, table)]
    warnings += _of_slope(out, table)
    return out, warnings


def _thousandfold(guesses: Taken, table: Table, time: str) -> str | None:
    """A velocity that is a thousand times the slope of the position, in the same unit as far as
    headings say: then the times are in ms.
    """
    named = by_name(guesses)
    speed, place = named.get("velocity"), named.get("position")
    if speed is None or place is None:
        return None
    if speed.unit != (place.unit and f"{place.unit}/s"):
        return None
    ratio = slope_ratio(table[time], table[place.source], table[speed.source])
    thousand = ratio is not None and abs(ratio / 1e3 - 1.0) < GUESSES.near_unit
    return speed.source if thousand else None


def _late_rows(guesses: Taken, table: Table) -> int:
    """Rows by which the reading of an axis follows its command; 0 where there are not both."""
    named = by_name(guesses)
    if not {"command", "position"} <= named.keys():
        return 0
    return lead(table[named["command"].source], table[named["position"].source])[0]


GRAD = re.compile(r"(?i)(?<![a-z])grad(?![a-z])")
"""Degrees in German, and gon in surveying."""


def meant_otherwise(guesses: Taken, units: Mapping[str, str]) -> list[str]:
    """What to say where a unit's sign has a second meaning. units: of a line under the heading."""
    said: list[str] = [
        Note.on(
            [name],
            "grad is read as degrees, as in German; were it gon, 400 to a turn, say"
            f' --set "{guess.name}={without_unit(name)}[deg]*0.9"',
        )
        for name, guess in guesses.items()
        if guess.unit == "deg" and GRAD.search(f"{name} {units.get(name, '')}")
    ]
    arcs = [one for name, one in guesses.items() if one.unit == "arcsec" and '"' in name]
    return said + ([rather('" is read as seconds of arc', "inches", arcs, "inch")] if arcs else [])


def _shared(guesses: Taken, table: Table) -> dict[str, Guess]:
    """Where one of a pair has a unit and the other goes over the same numbers, both have it."""
    named = by_name(guesses)
    out = dict(guesses)
    for names in PAIRS:
        pair = [named[name] for name in names if name in named and named[name].scale == 1.0]
        units = [one.unit for one in pair if one.unit is not None]
        if len(pair) == 2 and len(units) == 1 and same_range(*(table[one.source] for one in pair)):
            out |= {one.source: replace(one, unit=units[0]) for one in pair}
    return out


def _per_second(guess: Guess) -> Guess:
    """A velocity whose heading names the unit of its way: dq_deg is in deg/s."""
    speed = f"{guess.unit}/s"
    return replace(guess, unit=speed) if guess.role == "velocity" and speed in SPEEDS else guess


def _counts_by_speed(guesses: dict[str, Guess], table: Table, warnings: Sequence[str]) -> list[str]:
    """Warnings in which counts of an encoder have the size that the heading of a speed says."""
    named = by_name(guesses)
    speed, place, time = (named.get(name) for name in ("velocity", "position", "t"))
    counted = [n for n, one in guesses.items() if one.scale == GUESSES.count_rad]
    if speed is None or place is None or time is None or place.source not in counted:
        return list(warnings)
    t_s = table[time.source] * IN_SI[time.unit or "s"]
    ratio = slope_ratio(t_s, table[place.source], table[speed.source])
    if ratio is None or speed.unit not in SPEEDS_OF["rad"]:
        return list(warnings)
    turn = round_counts(2.0 * np.pi / (abs(ratio) * IN_SI[speed.unit]))
    size = float(f"{2.0 * np.pi / turn:.4g}")
    guesses |= {name: replace(guesses[name], scale=size, unit_guessed=False) for name in counted}
    says = f"taken for encoder counts, {turn:g} a turn, as {speed.source} shows"
    return [*not_about(warnings, counted), Note.on(counted, says)]


def round_counts(measured: float) -> float:
    """The counts of a turn that were measured, as encoders have them: a power of two, or the number
    of fewest figures near it.
    """
    power = 2.0 ** round(float(np.log2(measured)))
    figures = (float(f"{measured:.{digits}g}") for digits in range(1, 5))
    near = (one for one in (power, *figures) if abs(one / measured - 1.0) < GUESSES.near_counts)
    return next(near, measured)


def _of_slope(guesses: dict[str, Guess], table: Table) -> list[str]:
    """The unit of a velocity follows from the position that it is the slope of.

    One of which neither this nor a heading tells the unit is left out of the guesses.
    """
    named = by_name(guesses)
    speed, place, time = (named.get(name) for name in ("velocity", "position", "t"))
    if speed is None or place is None or speed.scale != 1.0:
        return []
    if time is None:  # whose unit may be that of the position
        if not (speed.unit or speed.why == "as you say") and IN_SI[place.unit or "1"] != 1.0:
            del guesses[speed.source]
        return []
    t_s = table[time.source] * IN_SI[time.unit or "s"]
    place_si = table[place.source] * place.scale * IN_SI[place.unit or "1"]
    ratio = slope_ratio(t_s, place_si, table[speed.source])
    sure = speed.why == "as you say" or speed.source == "velocity"
    if ratio is None:
        if speed.unit is None and not sure:
            del guesses[speed.source]
        return []
    return _by_ratio(guesses, speed, place, ratio, sure)


def _by_ratio(
    guesses: dict[str, Guess], speed: Guess, place: Guess, ratio: float, sure: bool
) -> list[str]:
    """The unit of a velocity, which is so many times the slope of a place; what is wrong with it.

    sure: that it is a velocity is known, so that it is not left out of the guesses.
    """
    own = SPEEDS_OF.get(place.unit, ())
    fits = [u for u in own or SPEEDS if abs(ratio * IN_SI[u] - 1.0) < GUESSES.near_unit]
    unit = next(iter(fits), None)
    if speed.unit in fits:
        return []
    left_out = not sure and (speed.unit is not None or unit is None)
    is_ = "is left out; it is" if left_out else "is"
    words = f"{is_} {ratio:.3g} times the slope of {place.source}"
    if left_out:
        del guesses[speed.source]
        if not speed.why.startswith(BY_NAME):  # nobody calls it a velocity
            return []
    if speed.unit is not None:
        return [Note.on([speed.source], f"{words}, which does not go with {speed.unit}")]
    if unit is None:
        factor = float(f"{1.0 / ratio:.4g}")
        right = as_option("velocity", without_unit(speed.source), "1", factor, 0.0)
        says = f"{words}, which fits no known unit; --set {shlex.quote(right)} reads it in SI units"
        return [Note.on([speed.source], says)]
    shown = unit if own or IN_SI[unit] != 1.0 else None  # rad or m are not distinguishable
    why = f"{speed.why}, in {unit} by its size" if shown else speed.why
    guesses[speed.source] = replace(speed, unit=shown, why=why, unit_guessed=place.unit_guessed)
    return []


def _pairs(guesses: dict[str, Guess], table: Table) -> list[str]:
    """Command and reading of one axis that differ by a factor between units."""
    named = by_name(guesses)
    warnings: list[str] = []
    for asked, seen in PAIRS:
        if asked not in named or seen not in named:
            continue
        one, other = named[asked], named[seen]
        if one.factor or other.factor:
            continue
        wide, told = travel(table[one.source]), travel(table[other.source])
        if wide <= 0.0 or told <= 0.0 or (one.unit != other.unit and one.unit and other.unit):
            continue
        larger, smaller, ratio = (
            (one, other, wide / told) if wide > told else (other, one, told / wide)
        )
        for factor, big, small in RATIOS:
            if abs(ratio / factor - 1.0) < GUESSES.near_unit:
                says = (
                    f"{larger.source} moves {ratio:.3g} times as much as {smaller.source}: "
                    f"{big} against {small}?"
                )
                warnings.append(Note(says, [larger.source, smaller.source]))
                if big in ("deg", "mm", "cm"):
                    guesses[larger.source] = replace(larger, unit=big)
                    guesses[smaller.source] = replace(smaller, unit=small)
                break
    return warnings
