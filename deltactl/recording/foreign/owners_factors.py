"""Columns of which one unit is so much as its owner alone knows: the pulses that command a hobby
servo, the counts of its potentiometer, the steps of a slide.

A printed command has a word in place of the number. A number that is fitted to the recording would
hide a wrong setting.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from dataclasses import replace

import numpy as np

from deltactl.recording.foreign.motion_units import is_open
from deltactl.recording.foreign.names import (
    AS_SAID,
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
from deltactl.recording.foreign.options import GUESSES
from deltactl.recording.foreign.shapes import Table, is_whole, lead, rising
from deltactl.recording.foreign.units import IN_SI, LINEAR, ROTARY
from deltactl.recording.reading.run import FloatArray

PER_US, PER_COUNT, PER_STEP = "DEG_PER_US", "DEG_PER_COUNT", "MM_PER_STEP"
OF_PULSES = Factor(
    PER_US,
    "pulses in us, which command a hobby servo",
    "degrees for 1 us of the pulse: 0.09 where 500 to 2500 us make 180 degrees",
    zero_known=False,
)
SAYS = "{}: taken for {}; put for {} below what one is"


def named_by_pulses(table: Table, said: Mapping[str, Named]) -> dict[str, Named]:
    """Pulses that something follows as the command of a hobby servo, and the count of its
    potentiometer as its reading, whatever their names say elsewhere.
    """
    found: dict[str, Named] = {}
    for name, pulses in table.items():
        if not _is_pulses(name, pulses, said[name].role):
            continue
        followers = list(_followers(table, name))
        if followers:
            found[name] = replace(said[name], role="command", unit=None, asked=True, used=True)
            read = [one for one in followers if is_analogue(one)]
            found |= {one: Named("position", None, None) for one in read}
    return found


def _is_pulses(name: str, values: FloatArray, role: str | None) -> bool:
    """Whether a column is called so and all its values are pulses that a servo takes."""
    low, high = GUESSES.pulses_us
    called = PULSES.intersection(in_words(name)) and role != "position"
    return bool(called) and bool(np.nanmin(values) >= low and np.nanmax(values) <= high)


def _followers(table: Table, pulses: str) -> Iterator[str]:
    """Columns that go where pulses go, later, or the other way round."""
    asked = table[pulses]
    if not np.nanstd(asked):
        return
    for name, values in table.items():
        if name == pulses or rising(values) or not np.nanstd(values):
            continue
        if max(lead(asked, values)[1], lead(asked, -values)[1]) >= GUESSES.alike:
            yield name


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
    out, pulses = dict(guesses), None
    if asked and is_open(asked) and _is_pulses(asked.source, table[asked.source], None):
        pulses = table[asked.source]
        out[asked.source] = _taken(asked, "deg", GUESSES.pulse_deg, OF_PULSES)
    if seen is not None and is_open(seen) and _is_counted_voltage(seen, table, pulses is not None):
        in_degrees = asked is not None and asked.unit == "deg"
        beside = table[asked.source] if asked and in_degrees else pulses
        factor = _of_counts(beside, in_degrees, table[seen.source])
        out[seen.source] = _taken(seen, "deg", GUESSES.analogue_deg, factor)
    out = _steps_of_a_slide(out, table)
    owed = [(one.source, one.factor) for one in out.values() if one.factor is not None]
    return out, [SAYS.format(name, factor.is_, factor.word) for name, factor in owed]


def _taken(guess: Guess, unit: str, one: float, factor: Factor) -> Guess:
    return replace(guess, unit=unit, scale=one, unit_guessed=True, factor=factor)


def _is_counted_voltage(seen: Guess, table: Table, of_servo: bool) -> bool:
    """Whether readings are whole numbers as a converter gives them, and are called so, or nothing
    else is known of them and they are those of a hobby servo.
    """
    values = table[seen.source]
    counted = is_whole(values) and float(np.nanmin(values)) >= 0.0
    called = is_analogue(seen.source) or (of_servo and not is_of_joint(seen.source))
    return counted and called and seen.why != AS_SAID


def _of_counts(asked: FloatArray | None, in_degrees: bool, counts: FloatArray) -> Factor:
    """What is to be said of the count of a voltage, beside what it follows: degrees, or pulses."""
    says = "degrees for one count: 0.293 where 0 to 1023 make 300 degrees"
    if asked is not None and (each := _slope(asked, counts)):
        backwards = " (negative, as it falls while the command grows)" * (each < 0.0)
        here = f"{1.0 / each:.4g}" if in_degrees else f"{PER_US} divided by {each:.4g}"
        says += f"{backwards}; here it is {here}, with which a wrong travel cannot be found"
    return Factor(PER_COUNT, "counts of a voltage, as of a potentiometer", says, zero_known=False)


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
        "mm for one step, as the drive is set: 0.0125 where 80 steps make 1 mm; here it moves"
        f" {each:g} mm, with which a wrong setting cannot be found",
    )
    command = _taken(replace(steps, role="command", index=None), "mm", each, factor)
    return {**guesses, steps.source: command, seen.source: position}
