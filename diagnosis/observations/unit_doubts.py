"""What looks like another unit than the one a column was read in, where nobody said the unit."""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np

from diagnosis.observations.readings import FloatArray

TURNS_RAD = 4.0 * np.pi
"""Joints seldom turn further; degrees read as rad always do."""
LONG_STEP_S = 2.0
"""Whole steps of time from here on are more often ms or us."""
ANGULAR = ("command", "position", "theta")
ROTARY, LINEAR = ("rad", "mrad", "deg", "turn"), ("m", "mm", "cm", "um", "inch")


def doubt(name: str, column: str, values: FloatArray) -> str:
    """A sentence for a column read in the contract's unit; empty where it looks right."""
    known = values[np.isfinite(values)]
    if name == "t" and len(known) > 1:
        step_s = float(np.median(np.diff(known)))
        if step_s >= LONG_STEP_S and bool((known == np.round(known)).all()):
            return (
                f't was read in s, in steps of {step_s:g} s; if it is in ms, --set "t={column}[ms]"'
            )
    if name.split("_")[0] in ANGULAR and len(known):
        farthest = float(np.max(np.abs(known)))
        if farthest > TURNS_RAD:
            return (
                f"{name} was read in rad (or m), up to {farthest:.4g}; if it is in degrees,"
                f' --set "{name}={column}[deg]"'
            )
    return ""


def other_motion(units: Mapping[str, str], motion: str) -> str:
    """Why units cannot be those of an axis that turns (rotary) or slides (linear); empty if right.

    units: of the columns of the contract, as they were said.
    """
    wrong, does = (LINEAR, "turns") if motion == "rotary" else (ROTARY, "slides")
    other = "linear" if motion == "rotary" else "rotary"
    for name, unit in units.items():
        if name.split("_")[0] in ANGULAR and unit in wrong:
            return (
                f"{name} is in {unit}, and this axis {does} (motion: {motion} in the robot file);"
                f" give its unit, or say motion: {other}"
            )
    return ""
