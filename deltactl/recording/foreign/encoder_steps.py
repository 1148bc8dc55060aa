"""The unit of an angle by the steps of its reading: encoders part a turn into 2^n."""

from __future__ import annotations

import numpy as np

from deltactl.recording.column_measures import spacing
from deltactl.recording.foreign.options import GUESSES
from deltactl.recording.reading.columns import FloatArray

TURNS: tuple[tuple[float, str], ...] = ((360.0, "deg"), (2.0 * np.pi, "rad"))
"""One turn in each unit. No power of two brings the one near the other (57.3 is 2^5.84), nor near
the decimal steps of a scale in mm."""
SERVO_STEPS: tuple[tuple[float, int], ...] = ((300.0, 1024),)
"""Degrees, and the steps they are parted into: Dynamixel AX."""


def of_encoder(values: FloatArray) -> tuple[str, str] | None:
    """Unit of readings (n,) that go in steps of an encoder, and words for the step; else None."""
    step = even_step(values)
    if step is None:
        return None
    across = float(np.nanmax(values) - np.nanmin(values)) / step
    least, most = GUESSES.near_unit_step
    near = float(np.clip(GUESSES.slip / across, least, most))
    for degrees, parts in SERVO_STEPS:
        if abs(step * parts / degrees - 1.0) < near:
            return "deg", f"in steps of {degrees:g}/{parts} degrees"
    low, high = GUESSES.encoder_bits
    for turn, unit in TURNS:
        bits = round(float(np.log2(turn / step)))
        if low <= bits <= high and abs(step * 2.0**bits / turn - 1.0) < near:
            said = f"360/{2**bits} degrees" if unit == "deg" else f"2 pi/{2**bits} rad"
            return unit, f"in steps of {said}"
    return None


def even_step(values: FloatArray) -> float | None:
    """The step of readings (n,) that stand at places evenly apart; None where they do not.

    All of them must; of what the engine takes for the rounding of a reading
    (`observations.readings.step_of`) a few may not.
    """
    known = values[np.isfinite(values)]
    if not len(known) or not np.ptp(known):
        return None
    alike = GUESSES.same_reading * float(np.ptp(known))
    places = np.unique(known)
    places = places[np.diff(places, prepend=-np.inf) > alike]
    if len(places) < GUESSES.places_for_a_step:
        return None
    step = spacing(places)
    steps = np.concatenate([[0.0], np.cumsum(np.round(np.diff(places) / step))])
    left = places - step * steps
    far = float(np.max(np.abs(left - np.mean(left))))
    return step if far < GUESSES.off_place * step else None
