"""Columns of which one unit is so much as its owner alone knows: the pulses that command a hobby
servo, the counts of its potentiometer, the steps of a slide.

A printed command has a word in place of the number. A number that is fitted to the recording would
hide a wrong setting.
"""

from __future__ import annotations

from collections.abc import Collection, Mapping
from dataclasses import replace

import numpy as np

from deltactl.recording.column_measures import travel
from deltactl.recording.foreign.doubts import counts_like
from deltactl.recording.foreign.motion_units import is_open
from deltactl.recording.foreign.names import (
    PULSES,
    ROLE_OF,
    Factor,
    Guess,
    Named,
    Taken,
    by_name,
    in_words,
    is_analogue,
    is_of_joint,
)
from deltactl.recording.foreign.notes import Note
from deltactl.recording.foreign.options import GUESSES
from deltactl.recording.foreign.shapes import Table, is_whole, lead, rising
from deltactl.recording.foreign.units import IN_SI, LINEAR, ROTARY, UNIT_FACTORS
from deltactl.recording.reading.run import FloatArray

PER_US, PER_STEP = "DEG_PER_US", "MM_PER_STEP"
OF_PULSES = Factor(
    PER_US,
    "pulses in us, which command a hobby servo",
    "degrees for 1 us of the pulse: 0.09 where 500 to 2500 us make 180 degrees",
    zero_known=False,
)
COUNTS, VOLTS = "the counts of a potentiometer", "the volts of a potentiometer"
TICKS = "the counts of an encoder"
READ_AS = {
    ("deg", COUNTS): (0.293, "degrees for one count: 0.293 where 0 to 1023 make 300 degrees"),
    ("deg", VOLTS): (90.9, "degrees for 1 V: 90.9 where 0 to 3.3 V make 300 degrees"),
    ("deg", TICKS): (0.0879, "degrees for one count: 0.0879 where 4096 make a turn"),
    ("mm", COUNTS): (0.0978, "mm for one count: 0.0978 where 0 to 1023 make 100 mm"),
    ("mm", VOLTS): (30.3, "mm for 1 V: 30.3 where 0 to 3.3 V make 100 mm"),
    ("mm", TICKS): (0.005, "mm for one count: 0.005 where 200 make 1 mm"),
}
"""By the unit of a motion, and what is read of it: what one usually is, and words."""
SAYS = "taken for {}; put for {} below what one is"
OTHERS = ("velocity", "effort", "load", "t", "temp_c")
"""What is no motion, though it may go where the motion goes."""
COUNTED = frozenset({"enc", "encoder", "encoderwert", "tick", "ticks", "rpm"})
"""Words of whole numbers that no voltage is counted by."""


def named_by_pulses(table: Table, said: Mapping[str, Named]) -> dict[str, Named]:
    """Pulses that something follows as the command of a hobby servo, and what a potentiometer gives
    as a reading, whatever their names say elsewhere.
    """
    free = [name for name in table if said[name].role is None and is_analogue(name)]
    found = {name: Named("position", None, None) for name in free if not rising(table[name])}
    moving = [name for name in table if said[name].role not in OTHERS and said[name].used]
    for name, pulses in table.items():
        if _is_pulses(name, pulses, said[name].role) and _is_followed(table, name, moving):
            found[name] = replace(said[name], role="command", unit=None, asked=True, used=True)
    return found


def named_in_inches(table: Table, said: Mapping[str, Named]) -> dict[str, Named]:
    """What is called `_in` and follows steps, or as far in inches a column with a unit of length.

    Beside what is called `_out`, it says no unit.
    """
    ends = {name: in_words(name)[-1] for name in table}
    beside = [name for name in table if said[name].unit in LINEAR or said[name].role == "steps"]
    return {
        name: replace(said[name], unit="inch")
        for name, values in table.items()
        if ends[name] == "in"
        and "out" not in ends.values()
        and said[name].unit is None
        and said[name].role in (None, "position", "range", "distance")
        and not is_whole(values)
        and any(_in_inches_of(values, table[one], said[one].unit) for one in beside)
    }


def _in_inches_of(values: FloatArray, other: FloatArray, unit: str | None) -> bool:
    """Whether values move like others, and as far in inches as those in their unit."""
    if not np.nanstd(values) or not np.nanstd(other):
        return False
    far = travel(other) * IN_SI[unit] / (travel(values) * IN_SI["inch"]) if unit else 1.0
    as_far = max(far, 1.0 / far) < GUESSES.other_unit
    return as_far and lead(other, values)[1] >= GUESSES.alike


def _is_pulses(name: str, values: FloatArray, role: str | None) -> bool:
    """Whether a column is called so and all its values are pulses that a servo takes."""
    low, high = GUESSES.pulses_us
    called = PULSES.intersection(in_words(name)) and role != "position"
    return bool(called) and bool(np.nanmin(values) >= low and np.nanmax(values) <= high)


def _is_followed(table: Table, pulses: str, others: Collection[str]) -> bool:
    """Whether another column goes where pulses go, later, or the other way round."""
    asked = table[pulses]
    if not np.nanstd(asked):
        return False
    return any(
        max(lead(asked, table[name])[1], lead(asked, -table[name])[1]) >= GUESSES.alike
        for name in others
        if name != pulses and not rising(table[name]) and np.nanstd(table[name])
    )


def steps_commanded(found: Taken, said: Mapping[str, Named], table: Table) -> dict[str, Guess]:
    """Commands that are called steps beside a reading with a unit in its heading: steps."""
    measured = [name for name in table if said[name].unit in (*ROTARY, *LINEAR)]
    return {
        name: replace(one, role="steps", index="1")
        for name, one in found.items()
        if one.role == "command"
        and one.index is None
        and one.unit is None
        and "steps" in map(ROLE_OF.get, in_words(name))
        and is_whole(table[name])
        and [other for other in measured if other != name]
    }


def with_factors(guesses: Taken, table: Table) -> tuple[dict[str, Guess], list[str]]:
    """Guesses with what the owner has to say of them, and a word of each."""
    named = by_name(guesses)
    asked, seen = named.get("command"), named.get("position")
    out = dict(guesses)
    if asked and is_open(asked) and _is_pulses(asked.source, table[asked.source], None):
        asked = _taken(asked, "deg", GUESSES.pulse_deg, OF_PULSES)
        out[asked.source] = asked
    if seen and is_open(seen) and (what := _read_as(seen.source, table, asked)):
        out[seen.source] = _of_reading(seen, what, asked, table)
    out = _steps_of_a_slide(out, table)
    owed = [(one.source, one.factor) for one in out.values() if one.factor is not None]
    return out, [Note.on([name], SAYS.format(one.is_, one.word)) for name, one in owed]


def _taken(guess: Guess, unit: str, one: float, factor: Factor) -> Guess:
    return replace(guess, unit=unit, scale=one, unit_guessed=True, factor=factor)


def _read_as(name: str, table: Table, asked: Guess | None) -> str | None:
    """What a reading counts, where that is no unit: a potentiometer, where it is called so, or
    follows pulses in whole numbers; an encoder, beside a command that has a unit.
    """
    values, positive = table[name], float(np.nanmin(table[name])) >= 0.0
    if is_analogue(name) and positive:
        in_volts = float(np.nanmax(values)) <= GUESSES.highest_v
        return COUNTS if is_whole(values) else VOLTS if in_volts else None
    if asked is None or not counts_like(values):
        return None
    if asked.factor is OF_PULSES and positive:
        other = is_of_joint(name) or COUNTED.intersection(in_words(name))
        return None if other else COUNTS
    ticks = (
        asked.unit in IN_SI and asked.factor is None and _other_unit(values, table[asked.source])
    )
    return TICKS if ticks else None


def _other_unit(values: FloatArray, asked: FloatArray) -> bool:
    """Whether a reading goes further than its command, and not by a factor between units."""
    ratio = travel(values) / max(travel(asked), 1e-300)
    in_a_unit = any(abs(ratio / one - 1.0) < GUESSES.near_unit for one in UNIT_FACTORS)
    return ratio >= GUESSES.other_unit and not in_a_unit


def _of_reading(seen: Guess, what: str, asked: Guess | None, table: Table) -> Guess:
    """A reading in something that is no unit, with what is to be said of it beside its command."""
    unit = "mm" if asked is not None and asked.unit in LINEAR else "deg"
    usual, says = READ_AS[unit, what]
    each = _slope(table[asked.source], table[seen.source]) if asked else 0.0
    if asked is not None and each and (asked.factor or asked.unit in IN_SI):
        each *= 1.0 if asked.factor else IN_SI[unit] / IN_SI[asked.unit or unit]
        backwards = " (negative, as it falls while the command grows)" * (each < 0.0)
        here = f"{asked.factor.word} divided by {each:.4g}" if asked.factor else f"{1 / each:.4g}"
        says += f"{backwards}; in this recording {here} (by that, no wrong scale is found)"
        usual = usual if asked.factor else float(f"{1 / each:.4g}")
    word = f"{unit.upper()}_PER_{'VOLT' if what == VOLTS else 'COUNT'}"
    return _taken(seen, unit, usual, Factor(word, what, says, zero_known=what == TICKS))


def _slope(asked: FloatArray, seen: FloatArray) -> float:
    """How much one of what was asked for moves what was seen; 0 where that is not known."""
    both = np.isfinite(asked) & np.isfinite(seen)
    if both.sum() < GUESSES.fewest_in_common or not np.ptp(asked[both]):
        return 0.0
    return float(np.polyfit(asked[both], seen[both], 1)[0])


def _steps_of_a_slide(guesses: dict[str, Guess], table: Table) -> dict[str, Guess]:
    """Steps beside a reading in mm as a command in mm.

    Where a command is there too, it is compared with the reading, and the steps are not used: a
    count of steps goes with an angle alone.
    """
    named = by_name(guesses)
    steps = named.get("steps_1")
    seen = named.get("theta_1") or named.get("position")
    if steps is None or seen is None or seen.unit not in LINEAR:
        return guesses
    position = replace(seen, role="position", index=None)
    if "command" in named:
        left = {name: one for name, one in guesses.items() if one.role != "steps"}
        return {**left, seen.source: position}
    each = float(f"{_slope(table[steps.source], table[seen.source] * IN_SI[seen.unit] * 1e3):.3g}")
    if not each:
        return guesses
    factor = Factor(
        PER_STEP,
        "the steps of a slide",
        "mm for one step, as the drive is set: 0.0125 where 80 steps make 1 mm; in this"
        f" recording {each:g} (by that, no wrong setting is found)",
    )
    command = _taken(replace(steps, role="command", index=None), "mm", each, factor)
    return {**guesses, steps.source: command, seen.source: position}
