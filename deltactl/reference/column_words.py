"""The columns of a table in words, with an example of each."""

from __future__ import annotations

import re

_NUMBERED = re.compile(r"_[123xyz]$")

COLUMN_WORDS: dict[str, tuple[float, str]] = {
    "t": (0.02, "time"),
    "steps": (1840, "counts that the motor was sent, from where its arm is level"),
    "command": (0.52, "where the arm, or the axis, was told to be"),
    "range": (0.412, "what the ranging sensor read"),
    "status": (0, "0: the reading is valid; anything else: it is not"),
    "theta": (0.523, "the angle of the arm, measured"),
    "pos": (0.05, "where the platform was, measured from outside"),
    "t_pwm": (0.006, "step period in force"),
    "current": (0.35, "current of the servo drive"),
    "disturbance": (0.02, "what the disturbance observer added"),
    "temp_c": (23.5, "temperature of the machine"),
    "position": (0.523, "where the axis was, measured"),
    "effort": (1.2, "torque, force or current that the drive gave"),
    "velocity": (0.8, "speed of the axis; absent: from its position"),
    "load": (4.9, "what pulled at the axis from outside"),
    "distance": (0.4, "the true distance"),
    "segment": (0, "number of the run; where it changes, another begins"),
}
"""By name, without the number of the motor or the sensor's letter."""


def stem_of(column: str) -> str:
    """A column's name without its number or letter."""
    return _NUMBERED.sub("", column)
