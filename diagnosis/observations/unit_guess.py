"""Units that values suggest, and warnings where they look like another unit than the one said."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import replace

import numpy as np

from diagnosis.observations.column_guess import Guess
from diagnosis.observations.readings import FloatArray

RATIOS: tuple[tuple[float, str, str], ...] = (
    (180.0 / np.pi, "deg", "rad"), (1000.0, "mm", "m"), (100.0, "cm", "m"),
    (4096.0 / (2.0 * np.pi), "counts of 4096 a turn", "rad"),
)  # fmt: skip
"""How many of the first unit are one of the second."""
NEAR_UNIT = 0.15
ANGULAR = ("command", "position", "theta")
WIDEST_RAD = 13.0
"""Two turns: more is degrees, millimetres or counts far more often than radians or metres."""
COUNT_RAD = 0.001534
"""One of 4096 counts a turn, as hobby servos have: the one that is most often met."""
LONGEST_M = 15.0
ROTARY, LINEAR = ("rad", "mrad", "deg", "turn"), ("m", "mm", "cm", "um", "inch")


def time_unit(t: FloatArray) -> tuple[str, str]:
    """Unit of a time column without one, and why: whole numbers are ticks of a computer's clock."""
    step = float(np.median(np.diff(t)))
    whole = bool((t == np.round(t)).all())
    if step >= 1e5 and whole:
        return ("ns", "steps of some million") if step >= 2e5 else ("us", "steps of some thousand")
    if step >= 1000.0 and whole:
        return "us", f"whole numbers, {step:g} apart"
    if (step > 1.0 and whole) or step > 20.0:
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
        if linear and largest > LONGEST_M:
            return replace(guess, unit="mm"), f"{guess.source}: up to {largest:g}, taken for mm"
        if not linear and largest > WIDEST_RAD:
            whole = bool((values[np.isfinite(values)] % 1.0 == 0.0).all())
            if whole and largest > 400.0:
                return replace(guess, unit="rad", scale=COUNT_RAD), (
                    f"{guess.source}: whole numbers up to {largest:g}, taken for encoder counts,"
                    f" 4096 a turn; if it has others, put what one is [rad] in place of {COUNT_RAD}"
                    " into the command below"
                )
            return replace(guess, unit="deg"), (
                f"{guess.source}: up to {largest:g}, taken for degrees; if it is mm, put"
                " [mm] in place of [deg] into the command below"
            )
        return guess, ""
    if guess.unit == "rad" and largest > 4 * WIDEST_RAD:
        return guess, f"{guess.source}: is said to be rad and goes up to {largest:g}; degrees?"
    if guess.unit == "m" and largest > LONGEST_M:
        return guess, f"{guess.source}: is said to be m and goes up to {largest:g}; millimetres?"
    if guess.unit == "deg" and largest < 0.5:
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
        wide, told = _spread(table[one.source]), _spread(table[other.source])
        if wide <= 0.0 or told <= 0.0 or (one.unit != other.unit and one.unit and other.unit):
            continue
        larger, smaller, ratio = (
            (one, other, wide / told) if wide > told else (other, one, told / wide)
        )
        for factor, big, small in RATIOS:
            if abs(ratio / factor - 1.0) < NEAR_UNIT:
                warnings.append(
                    f"{larger.source} moves {ratio:.3g} times as much as {smaller.source}: "
                    f"{big} against {small}?"
                )
                if big in ("deg", "mm", "cm"):
                    guesses[larger.source] = replace(larger, unit=big)
                    guesses[smaller.source] = replace(smaller, unit=small)
                break
    return warnings


def _spread(values: FloatArray) -> float:
    return float(np.nanquantile(values, 0.98) - np.nanquantile(values, 0.02))
