"""Centres of G-code's arcs: by I and J from their beginning, by I and J as a place, or by R."""

from __future__ import annotations

import math

import numpy as np

from deltactl.firmware_py.path_file import LEAST_RADIUS_M, same_radius

Place = tuple[float, float]
ROUND = 1e-3
"""Coordinates are rounded in files: R may be so much too short for a half turn."""
SAME_M = 1e-9


def check_words(words: dict[str, float], placed: bool) -> None:
    """Whether an arc has what it needs, wherever it begins. Raises ValueError."""
    given = {"I", "J"} & set(words)
    if "R" in words:
        if given:
            raise ValueError("an arc has its centre (I, J) or its radius (R), not both")
    elif placed and len(given) < 2:
        raise ValueError("an arc under G90.1 needs I and J, the place of its centre")
    elif not given:
        raise ValueError("an arc needs I and J, from its beginning to its centre, or its radius R")


def centre_by_words(
    begin: Place, end: Place, words: dict[str, float], unit_m: float, clockwise: bool, placed: bool
) -> Place:
    """The centre [m] of an arc from `begin` to `end` [m]; placed: I and J are a place (G90.1).

    Raises ValueError with what is wrong. The words are those that check_words lets pass.
    """
    if "R" in words:
        return _by_radius(begin, end, words["R"], unit_m, clockwise)
    east_m, north_m = words.get("I", 0.0) * unit_m, words.get("J", 0.0) * unit_m
    centre = (east_m, north_m) if placed else (begin[0] + east_m, begin[1] + north_m)
    first_m, last_m = math.dist(begin, centre), math.dist(end, centre)
    if min(first_m, last_m) < LEAST_RADIUS_M:
        raise ValueError("an arc's centre (I, J) is one of its ends; it has no radius")
    if not same_radius(np.array(first_m), np.array(last_m)):
        raise ValueError(
            f"an arc's radius is {first_m / unit_m:.6g} where it begins and {last_m / unit_m:.6g}"
            " where it ends; at most 0.1 % may be between them: is it G90.1 or G91.1, G20 or G21?"
        )
    return centre


def _by_radius(begin: Place, end: Place, radius: float, unit_m: float, clockwise: bool) -> Place:
    """R below 0 is the longer way round."""
    chord_m, radius_m = math.dist(begin, end), abs(radius) * unit_m
    if chord_m < SAME_M:
        raise ValueError("an arc by R needs another place to end at; whole turns by I, J")
    if chord_m > 2.0 * radius_m * (1.0 + ROUND) + SAME_M:
        raise ValueError(
            f"R {radius:g} cannot reach: half the distance is {chord_m / 2.0 / unit_m:.6g}"
        )
    # Left of the chord lies the centre of a short counter-clockwise arc.
    height_m = math.sqrt(max(0.0, radius_m**2 - chord_m**2 / 4.0))
    side = -height_m if clockwise != (radius < 0.0) else height_m
    east, north = ((b - a) / chord_m for a, b in zip(begin, end, strict=True))
    return (
        begin[0] + east * chord_m / 2.0 - north * side,
        begin[1] + north * chord_m / 2.0 + east * side,
    )
