"""What a linkage reaches near a place out of its reach, in words: a wrong unit shows there."""

from __future__ import annotations

import math

import numpy as np

from deltactl.models.linkage.arms import Linkage
from deltactl.models.linkage.inverse import inverse
from deltactl.models.linkage.status import Status

LEVELS, DIRECTIONS, RADII = 1001, 36, 120


def in_reach(linkage: Linkage, x_m: float, y_m: float, z_m: float) -> str:
    """Which heights [mm] are in reach at x, y [m]; where none is, which circles are."""
    longest_m = float(np.max(linkage.upper_arm_m) + np.max(linkage.forearm_m))
    levels_m = np.linspace(-longest_m, longest_m, LEVELS)
    places = np.stack([np.full(LEVELS, x_m), np.full(LEVELS, y_m), levels_m], axis=1)
    good_m = levels_m[inverse(linkage, places).status == Status.OK]
    if not len(good_m):
        circle = _widest_circle(linkage, min(longest_m, math.hypot(x_m, y_m)), z_m)
        return f"at this x and y no z is in reach{circle}"
    span = f"z from {1e3 * good_m[0]:.0f} to {1e3 * good_m[-1]:.0f} mm is in reach"
    below = good_m[0] <= -z_m <= good_m[-1] < z_m
    meant = f" (did you mean z = {-1e3 * z_m:.6g} mm?)" if below else ""
    return f"at this x and y, {span}, negative below the base{meant}"


def _widest_circle(linkage: Linkage, radius_m: float, z_m: float) -> str:
    """The widest circle around the middle that is whole in reach at a height, below a radius."""
    radii_m = np.linspace(0.0, radius_m, RADII)
    turns_rad = np.linspace(0.0, 2.0 * np.pi, DIRECTIONS, endpoint=False)
    x_m = radii_m[:, None] * np.cos(turns_rad)
    y_m = radii_m[:, None] * np.sin(turns_rad)
    places = np.stack([x_m, y_m, np.full_like(x_m, z_m)], axis=-1)
    whole = (inverse(linkage, places).status == Status.OK).all(axis=1)
    within = len(whole) if whole.all() else int(np.argmin(whole))
    if within < 2:
        return ""
    widest_mm = math.floor(1e3 * float(radii_m[within - 1]))
    return f"; around the middle, at this z, circles of up to {widest_mm} mm radius are"
