"""Questions about machines of several kinds: their name and their motors."""

from __future__ import annotations

from deltactl.firmware_py.describing.motors import LEAST_PULSES, of_both, of_ratio, too_few_pulses
from deltactl.firmware_py.describing.question import Notation, Question

NAME = Question("name", "Name of the machine", "my-robot", any_text=True)
MICROSTEPS = Question(
    "microsteps_per_rev",
    "Step pulses for one turn of the motor, as set at the drive (200 full steps of 8 microsteps:"
    " 1600, or 200x8). With servo drives, or where recordings hold angles and no steps, 1600 will"
    " do",
    "1600",
    least=LEAST_PULSES,
    too_small=too_few_pulses,
    # Whoever writes both does not mean the one by the other.
    notation=Notation(of_both, least=1.0),
    guessed=True,
)
GEAR = Question(
    "gear_ratio",
    "Turns of the motor for one turn of what it drives (5 for a gear of 5:1, 1 without a gear)",
    least=0.001,
    notation=Notation(of_ratio),
)
