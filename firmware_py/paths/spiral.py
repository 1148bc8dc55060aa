"""A level logarithmic spiral r = a exp(b t), as in Zhao 2023, Figure 9."""

from __future__ import annotations

import math

import numpy as np

from deltactl.firmware_py.paths.path import Path, curve, intervals, level


def length_m(inner_radius_m: float, outer_radius_m: float, turns: float) -> float:
    """Length of the path [m]: sqrt(1 + b^2) / b times the growth of the radius."""
    growth = _growth(inner_radius_m, outer_radius_m, turns)
    return math.hypot(1.0, growth) / growth * (outer_radius_m - inner_radius_m)


def spiral(
    centre_m: tuple[float, float, float],
    inner_radius_m: float,
    outer_radius_m: float,
    turns: float,
    spacing_m: float,
) -> Path:
    """From the inner radius on the +x side outwards, counter-clockwise from above.

    The arc length is linear in the radius, so the spacing is equal without any search.
    """
    length = length_m(inner_radius_m, outer_radius_m, turns)
    radius_m = np.linspace(inner_radius_m, outer_radius_m, intervals(length, spacing_m) + 1)
    growth = _growth(inner_radius_m, outer_radius_m, turns)
    angle_rad = np.log(radius_m / inner_radius_m) / growth
    return curve(
        level(centre_m, radius_m * np.cos(angle_rad), radius_m * np.sin(angle_rad)), spacing_m
    )


def _growth(inner_radius_m: float, outer_radius_m: float, turns: float) -> float:
    """b of r = a exp(b t), per radian."""
    return math.log(outer_radius_m / inner_radius_m) / (2.0 * math.pi * turns)
