"""Units that values suggest, and warnings where they look like another unit than the one said."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import replace

import numpy as np

from diagnosis.observations.column_guess import Guess
from diagnosis.observations.needed_columns import travel
from diagnosis.observations.options import GUESSES
from diagnosis.observations.readings import FloatArray

RATIOS: tuple[tuple[float, str, str], ...] = (
    (180.0 / np.pi, "deg", "rad"), (1000.0, "mm", "m"), (100.0, "cm", "m"),
    (4096.0 / (2.0 * np.pi), "counts of 4096 a turn", "rad"),
)  # fmt: skip
"""How many of the first unit are one of the second."""
ANGULAR = ("command", "position", "theta")
ROTARY, LINEAR = ("rad", "mrad", "deg", "turn"), ("m", "mm", "cm", "um", "inch")


def time_unit(t: FloatArray) -> tuple[str, str]:
    """Unit of a time column without one, and why: whole numbers are ticks of a computer's clock."""
    step = float(np.median(np.diff(t)))
    whole = bool((t == np.round(t)).all())
    ticks, ticks_ns = GUESSES.ticks_ns
    if step >= ticks and whole:
        in_ns = step >= ticks_ns
        return ("ns", "steps of some million") if in_ns else ("us", "steps of some thousand")
    if step >= GUESSES.ticks_us and whole:
        return "us", f"whole numbers, {step:g} apart"
    if (step > GUESSES.ticks_ms and whole) or step > GUESSES.longest_step_s:
        return "ms", f"{step:g} apart"
    return "s", f"{step:.3g} apart"


def with_units(
    guesses: Mapping[str, Guess], table: Mapping[str, FloatArray]
) -> tuple[dict[str, Guess], list[str]]:
    """Guesses with a unit where the values tell one, and what to be warned of."""
    out, warnings = dict(guesses), list[str]()
    for name, guess in guesses.items():
        values = table[name]
        if guess.role == "t" and guess.unit is None:
            unit, why = time_unit(values)
            out[name] = replace(guess, unit=unit)
            if unit != "s":
                warnings.append(f"{name}: taken for {unit} ({why}); no unit stands in the file")
        elif guess.role in (*ANGULAR, "pos", "range", "distance"):
            out[name], warning = _of_motion(guess, values)
            warnings += [warning] if warning else []
    warnings += _pairs(out, table)
    return out, warnings


def _of_motion(guess: Guess, values: FloatArray) -> tuple[Guess, str]:
    largest = float(np.nanmax(np.abs(values)))
    if guess.scale != 1.0:  # somebody knows
        return guess, ""
    linear = guess.role in ("pos", "range", "distance")
    if guess.unit is None:
        if linear and largest > GUESSES.longest_m:
            return replace(guess, unit="mm"), f"{guess.source}: up to {largest:g}, taken for mm"
        if not linear and largest > GUESSES.widest_rad:
            whole = bool((values[np.isfinite(values)] % 1.0 == 0.0).all())
            if whole and largest > GUESSES.least_counts:
                return replace(guess, unit="rad", scale=GUESSES.count_rad), (
                    f"{guess.source}: whole numbers up to {largest:g}, taken for encoder counts,"
                    f" 4096 a turn; if it has others, put what one is [rad] in place of"
                    f" {GUESSES.count_rad} into the command below"
                )
            return replace(guess, unit="deg"), (
                f"{guess.source}: up to {largest:g}, taken for degrees; if it is mm, put"
                " [mm] in place of [deg] into the command below"
            )
        return guess, ""
    if guess.unit == "rad" and largest > GUESSES.said_factor * GUESSES.widest_rad:
        return guess, f"{guess.source}: is said to be rad and goes up to {largest:g}; degrees?"
    if guess.unit == "m" and largest > GUESSES.longest_m:
        return guess, f"{guess.source}: is said to be m and goes up to {largest:g}; millimetres?"
    if guess.unit == "deg" and largest < GUESSES.narrowest_deg:
        return guess, f"{guess.source}: is said to be deg and stays below {largest:.3g}; radians?"
    return guess, ""


def _pairs(guesses: dict[str, Guess], table: Mapping[str, FloatArray]) -> list[str]:
    """Command and reading of one axis that differ by a factor between units."""
    by_name = {guess.name: guess for guess in guesses.values()}
    warnings = []
    for asked, seen in (
        ("command", "position"), ("distance", "range"),
        *((f"command_{n}", f"theta_{n}") for n in (1, 2, 3)),
    ):  # fmt: skip
        if asked not in by_name or seen not in by_name:
            continue
        one, other = by_name[asked], by_name[seen]
        wide, told = travel(table[one.source]), travel(table[other.source])
        if wide <= 0.0 or told <= 0.0 or (one.unit != other.unit and one.unit and other.unit):
            continue
        larger, smaller, ratio = (
            (one, other, wide / told) if wide > told else (other, one, told / wide)
        )
        for factor, big, small in RATIOS:
            if abs(ratio / factor - 1.0) < GUESSES.near_unit:
                warnings.append(
                    f"{larger.source} moves {ratio:.3g} times as much as {smaller.source}: "
                    f"{big} against {small}?"
                )
                if big in ("deg", "mm", "cm"):
                    guesses[larger.source] = replace(larger, unit=big)
                    guesses[smaller.source] = replace(smaller, unit=small)
                break
    return warnings
