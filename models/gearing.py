"""Which gear ratios an arm may have; nothing is loaded for it, as the help of commands asks it."""

from __future__ import annotations

LEAST_RATIO = 1.0
"""Turns of the motor for one of an arm: motors are too fast and too weak to turn one faster."""


def too_small_ratio(ratio: float) -> str:
    """What is said of a ratio below `LEAST_RATIO`, with which an arm would outrun its motor."""
    if ratio <= 0.0:
        return f"must not be below {LEAST_RATIO:g}"
    turns = f"{1.0 / ratio:.6g}"
    return f"did you mean {turns}? The motor turns {turns} times for one turn of the arm"
