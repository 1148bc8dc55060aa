"""Centres of G-code's arcs: by I and J from their beginning, by I and J as a place, or by R."""

from __future__ import annotations

import math

Place = tuple[float, float]
ROUND = 1e-3
"""Coordinates are rounded in files: R may be so much too short for a half turn."""
SAME_M = 1e-9


def centre_by_words(
    begin: Place, end: Place, words: dict[str, float], unit_m: float, clockwise: bool, placed: bool
) -> Place:
    """The centre [m] of an arc from `begin` to `end` [m]; placed: I and J are a place (G90.1).

    Raises ValueError with what is wrong.
    """
    if "R" in words:
        return _by_radius(begin, end, words["R"], unit_m, clockwise)
    given = {"I", "J"} & set(words)
    if placed:
        if len(given) < 2:
            raise ValueError("an arc under G90.1 needs I and J, the place of its centre")
        return words["I"] * unit_m, words["J"] * unit_m
    if not given:
        raise ValueError("an arc needs I and J, from its beginning to its centre, or its radius R")
    return (
        begin[0] + words.get("I", 0.0) * unit_m,
        begin[1] + words.get("J", 0.0) * unit_m,
    )


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
