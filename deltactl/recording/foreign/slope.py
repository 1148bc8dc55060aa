"""A velocity against the position that it is the slope of: the factor between their units."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from deltactl.foundation.errors import RecordingError
from deltactl.recording.foreign.options import GUESSES
from deltactl.recording.foreign.units import IN_SI
from deltactl.recording.reading.columns import FloatArray
from deltactl.recording.tables.flat import GAP_PERIODS, FlatRecording

TOO_LARGE: tuple[tuple[float, str], ...] = (
    *(
        (
            1.0 / IN_SI[f"{small}/s"],
            f"give its unit: velocity=COLUMN[{small}/s]; or is the position in {large}, and not in"
            f" {small}: position=COLUMN[{large}]?",
        )
        for small, large in (("deg", "rad"), ("mm", "m"))
    ),
    (IN_SI["deg"], "is it the position that is in degrees: position=COLUMN[deg]?"),
    (IN_SI["mm"], "is it the position that is in mm: position=COLUMN[mm]?"),
    (1.0 / IN_SI["rpm"], "give its unit: velocity=COLUMN[rpm]"),
)
"""How many times too large the velocity is, and what is to be written then."""


def slope_ratio(t_s: FloatArray, position: FloatArray, velocity: FloatArray) -> float | None:
    """How many times d(position)/dt the velocity is; None where it is no slope of it.

    All of shape (n,), NaN for empty cells. Moves over some rows are compared with the integral of
    the velocity, so that neither rounding of the position nor uneven times count.
    """
    known = np.isfinite(position) & np.isfinite(velocity) & np.isfinite(t_s)
    t_s, position, velocity = t_s[known], position[known], velocity[known]
    if len(t_s) < GUESSES.fewest_in_common + max(GUESSES.slope_rows):
        return None
    step = np.diff(t_s)
    longest = GAP_PERIODS * float(np.median(step))
    between = 0.5 * (velocity[1:] + velocity[:-1]) * step
    between[step > longest] = np.nan  # and with it whatever spans the gap
    best, ratio = 0.0, None
    for rows in GUESSES.slope_rows:
        went = position[rows:] - position[:-rows]
        whole = np.convolve(between, np.ones(rows), mode="valid")
        good = np.isfinite(whole)
        if good.sum() < GUESSES.fewest_in_common or not (
            np.std(went[good]) and np.std(whole[good])
        ):
            continue
        alike = float(np.corrcoef(went[good], whole[good])[0, 1])
        if abs(alike) > max(best, GUESSES.alike_slope):
            best = abs(alike)
            ratio = float(np.copysign(np.std(whole[good]) / np.std(went[good]), alike))
    return ratio


def check_velocity(recordings: Sequence[FlatRecording]) -> None:
    """Refuse a velocity in another unit than the position's. Raises RecordingError."""
    for recording in recordings:
        name = next((n for n in ("position", "theta_1") if n in recording.columns), None)
        if name is None or "velocity" not in recording.columns:
            continue
        columns = recording.columns
        ratio = slope_ratio(recording.t_s, columns[name], columns["velocity"])
        if ratio is None or 1.0 / GUESSES.other_unit < ratio < GUESSES.other_unit:
            continue
        near = [says for factor, says in TOO_LARGE if abs(ratio / factor - 1.0) < GUESSES.near_unit]
        other = f"is a gear or a sign between them? Else velocity=COLUMN*{1.0 / ratio:.4g}"
        raise RecordingError(
            f"{recording.source}: velocity is {ratio:.3g} times d({name})/dt of the same recording;"
            f" {near[0] if near else other}"
        )
