"""Questions about a lone axis."""

from __future__ import annotations

from deltactl.firmware_py.describing.asked_of_all import GEAR, MICROSTEPS, NAME
from deltactl.firmware_py.describing.question import UNKNOWN, Question

ZERO = Question(
    "zero",
    "Should the reading be 0 where the command is 0? absolute: yes (told to go to 30, it should"
    " read 30; also where one was set equal to the other once, at the start or at home); arbitrary:"
    " no (an encoder that begins anywhere, and reads 217 there)",
    "absolute", ("absolute", "arbitrary"), unless=(("recorded", "effort"),),
)  # fmt: skip
TURNS = ("motion", "rotary", "a servo_axis that turns")
SLIDES = ("motion", "linear", "a servo_axis that slides")
NO_EFFORT = (("recorded", "command"),)
STEPPER_AXIS: tuple[Question, ...] = (NAME, MICROSTEPS, GEAR, ZERO)
SERVO_AXIS: tuple[Question, ...] = (
    NAME,
    Question("motion", "Does it turn (rotary) or slide (linear)?", "rotary", ("rotary", "linear")),
    Question(
        "recorded",
        "What is recorded beside the position: its command, the effort (force, torque,"
        " current), or both?",
        "command",
        ("command", "effort", "both"),
    ),
    Question(
        "inertia",
        "Moving inertia, kg m2 (rotary) or kg (linear); 0 if unknown or no effort is recorded",
        "0",
        least=0.0,
        unless=NO_EFFORT,
    ),
    Question(
        "effort_gain",
        "N m (or N) for one unit of the effort column; 1 if there is none",
        "1",
        unless=NO_EFFORT,
    ),
    Question(
        "hanging_nm",
        "Torque that holds a weight on the axis level, N m (kg * 9.81 * metres from the axis);"
        " 0: none hangs there, or the axis stands upright; unknown: if you do not know",
        UNKNOWN,
        unless=(("motion", "linear"),),
        only=TURNS,
    ),
    Question(
        "hanging_deg",
        "Position at which that weight hangs straight down, degrees",
        "0",
        unless=(("motion", "linear"), ("hanging_nm", "0"), ("hanging_nm", UNKNOWN)),
        only=TURNS,
    ),
    Question(
        "slope_n",
        "Force that holds the slide on its slope, N (kg * 9.81 * sine of the slope), negative"
        " if it holds towards lower positions; 0: it is level, or balanced; unknown: if you do not"
        " know",
        UNKNOWN,
        unless=(*NO_EFFORT, ("motion", "rotary")),
        only=SLIDES,
    ),
    ZERO,
)
