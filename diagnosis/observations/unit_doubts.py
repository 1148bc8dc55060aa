"""What looks like another unit than the one a column was read in, where nobody said the unit."""

from __future__ import annotations

import numpy as np

from diagnosis.observations.readings import FloatArray

TURNS_RAD = 4.0 * np.pi
"""Joints seldom turn further; degrees read as rad always do."""
LONG_STEP_S = 2.0
"""Whole steps of time from here on are more often ms or us."""
ANGULAR = ("command", "position", "theta")


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
