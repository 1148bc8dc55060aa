"""Pulses and turns of a motor as people give them: what is read, refused, or remarked on."""

from __future__ import annotations

import re

USUAL_STEPS = 200.0
"""Full steps for one turn of nearly every stepper: 1.8 degrees each."""
FULL_STEPS = (200.0, 400.0)
"""For one turn of motors with 1.8 or 0.9 degrees a step."""
LEAST_PULSES = 100.0
"""For one turn: below are the settings of drives (2 to 64), far from what turns an arm."""
SETTINGS = (128.0, 256.0)
"""Microsteps of one full step that drives offer too, and that may be pulses for one turn."""

_RATIO = re.compile(r"([.\d]+) ?: ?([.\d]+)")
"""A gear's ratio as its maker writes it, 5:1, or as its user does, 1:5."""
_BOTH = re.compile(r"([1-9]\d{0,5}) ?[x*×] ?([1-9]\d{0,3})", re.IGNORECASE)
"""Full steps of a turn, and the microsteps of each: 200x16."""
TIN_CAN_STEPS = 32
"""Of the motor in a 28BYJ-48, before its gear of 63.68:1."""


def too_few_pulses(pulses: float) -> str:
    """What is said of pulses for one turn that can only be microsteps of one full step."""
    return (
        f"{pulses:g} microsteps a full step? Of a motor with {USUAL_STEPS:g} steps a turn that is"
        f" --microsteps-per-rev {USUAL_STEPS * pulses:g}. Of a motor with fewer, write both: a"
        f" 28BYJ-48 has {TIN_CAN_STEPS}, in half steps --microsteps-per-rev {TIN_CAN_STEPS}x2"
        " --gear-ratio 63.68"
    )


def of_both(text: str) -> float | None:
    """Pulses for one turn from 200x16, full steps and microsteps of each; None for other texts."""
    found = _BOTH.fullmatch(text.strip())
    return float(int(found[1]) * int(found[2])) if found else None


def of_ratio(text: str) -> float | None:
    """The turns of the motor for one of the arm that 4:1 and 1:4 both mean; None for no such text.

    People write a reduction either way round, and no arm is geared up.
    """
    found = _RATIO.fullmatch(text.strip())
    try:
        first, second = (float(part) for part in found.groups()) if found else (0.0, 0.0)
    except ValueError:  # two points in a number
        return None
    return max(first, second) / min(first, second) if min(first, second) > 0.0 else None


def ratio_remark(text: str) -> list[str]:
    """How a ratio with a colon was read."""
    ratio = of_ratio(text)
    if ratio is None:
        return []
    times = "once" if ratio == 1.0 else f"{ratio:.6g} times"
    return [
        f"--gear-ratio:    {text.strip()} is read as {ratio:.6g}: the motor turns {times} for one"
        " turn of what it drives"
    ]


def pulses_remark(text: str, pulses: float) -> list[str]:
    """How full steps and microsteps were read, and what is seldom meant, and may be right."""
    if of_both(text) is not None:
        return [f"--microsteps-per-rev: {text.strip()} is read as {pulses:g} pulses for one turn"]
    if pulses in FULL_STEPS:
        return [
            f"look here:       {pulses:g} pulses for one turn are full steps; if the drive makes"
            " microsteps, give the pulses that it is set to (1600 for 8 microsteps a step)"
        ]
    if pulses < USUAL_STEPS or pulses in SETTINGS:
        return [
            f"look here:       {pulses:g} pulses for one whole turn of the motor are few; if the"
            f" drive is set to {pulses:g} microsteps a step, write {USUAL_STEPS * pulses:g}"
        ]
    return []
