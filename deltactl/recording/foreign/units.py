"""Units: how they are written, how large they are, and which kind of column has which."""

from __future__ import annotations

import difflib
from collections.abc import Sequence

import numpy as np

_UNITS = {
    "s": (1.0, "s sec secs second seconds"),
    "ms": (1e-3, "ms msec millis milliseconds"),
    "us": (1e-6, "us usec micros µs"),
    "ns": (1e-9, "ns nsec nanos nanoseconds"),
    "min": (60.0, "min minutes"),
    "m": (1.0, "m meter meters metre metres"),
    "cm": (0.01, "cm"),
    "mm": (1e-3, "mm"),
    "um": (1e-6, "um µm micron microns"),
    "inch": (0.0254, "inch inches"),
    "rad": (1.0, "rad rads radian radians"),
    "mrad": (1e-3, "mrad"),
    "deg": (np.pi / 180.0, "deg degs degree degrees grad °"),
    "turn": (2.0 * np.pi, "turn turns rev revs"),
    "arcmin": (np.pi / 10800.0, "arcmin arcmins arcminute arcminutes ′"),
    "arcsec": (np.pi / 648000.0, 'arcsec arcsecs arcsecond arcseconds ″ "'),
    "N": (1.0, "n newton"),
    "mN": (1e-3, ""),
    "Nm": (1.0, "nm n.m newtonmeter"),
    "mNm": (1e-3, "mnm"),
    "Ncm": (0.01, "ncm"),
    "1": (1.0, ""),
    "A": (1.0, "a amp amps"),
    "mA": (1e-3, "ma milliamp milliamps"),
    "V": (1.0, "volt volts"),
    "rad/s": (1.0, "rad/s"),
    "deg/s": (np.pi / 180.0, "deg/s °/s"),
    "m/s": (1.0, "m/s"),
    "mm/s": (1e-3, "mm/s"),
    "rpm": (np.pi / 30.0, "rpm 1/min u/min"),
    "turn/s": (2.0 * np.pi, "turn/s turns/s rev/s revs/s rps u/s"),
}
"""Unit of a mapping -> its size in the contract's, and how names write it, in lower case."""
IN_SI = {unit: size for unit, (size, _) in _UNITS.items()}
UNIT_WORDS = {unit: words for unit, (_, words) in _UNITS.items() if words}
UNIT_OF = {word: unit for unit, words in UNIT_WORDS.items() for word in words.split()}
UNIT_APART = UNIT_OF | {"in": "inch"}
"""Units in brackets, in a line of their own, or as somebody says them."""
UNIT_FACTORS = (1.0 / IN_SI["deg"], 1.0 / IN_SI["mm"], 1.0 / IN_SI["cm"])
"""How many degrees are one radian, and mm and cm one metre."""
TIMES = ("s", "ms", "us", "ns", "min")
ROTARY = ("rad", "mrad", "deg", "arcmin", "arcsec", "turn")
LINEAR = ("m", "mm", "cm", "um", "inch")
ROTARY_SPEEDS, LINEAR_SPEEDS = ("rad/s", "deg/s", "rpm", "turn/s"), ("m/s", "mm/s")
SPEEDS = (*ROTARY_SPEEDS, *LINEAR_SPEEDS)
"""Units of `velocity` alone."""
SPEEDS_OF: dict[str | None, tuple[str, ...]] = {
    **dict.fromkeys(ROTARY, ROTARY_SPEEDS),
    **dict.fromkeys(LINEAR, LINEAR_SPEEDS),
}
"""By the unit of a place, those of its velocity."""
FORCES, TORQUES = ("N", "mN"), ("Nm", "mNm", "Ncm")
PULLING = (*FORCES, *TORQUES)
UNITS_OF: dict[str, tuple[str, ...]] = {
    "t": TIMES,
    **dict.fromkeys(("command", "position", "theta"), (*ROTARY, *LINEAR)),
    **dict.fromkeys(("pos", "range", "distance"), LINEAR),
    "velocity": SPEEDS,
    "effort": (*PULLING, "A", "mA", "V"),
    "load": PULLING,
    **dict.fromkeys(("current", "disturbance"), ("A", "mA")),
}
"""What each kind of column is measured in; of a position only the machine says if it turns."""
CLOCKS = frozenset(word for unit in ("ms", "us", "ns") for word in UNIT_WORDS[unit].split()) | {
    "sec",
    "secs",
    "seconds",
}
"""Headings that are a unit and nothing else: the time. Not s or min, which may be a way or a least.
"""
LONE_UNITS = frozenset(
    word for unit in (*ROTARY, *LINEAR) for word in UNIT_WORDS[unit].split() if len(word) > 1
) - {"turn", "turns", "grad", "rev", "revs"}
"""Headings that are a unit and nothing else: of a motion."""
A_FACTOR = "or a factor to SI units in its place, as position=seen*4.848e-6"


LONE = ("command", "position")
"""What a single axis, which turns or slides, was asked for, and what came of it."""


def size_of(unit: str) -> float:
    """SI size of what `unit=` says: a unit, or the size itself. Raises ValueError."""
    return IN_SI[unit] if unit in IN_SI else float(unit)


def of_motion(rotary: Sequence[str], linear: Sequence[str]) -> str:
    """Units to choose from, for an axis that turns and for one that slides."""
    kinds = ((rotary, "turns"), (linear, "slides"))
    return "; ".join(f"{either(units)} if it {does}" for units, does in kinds if units)


def either(names: Sequence[str]) -> str:
    """'a', 'a or b', 'a, b or c'."""
    return " or ".join([", ".join(names[:-1]), names[-1]] if len(names) > 1 else names)


def no_unit(said: str) -> str:
    """Why a unit is refused, and which was meant by it: as people write it, or nearly."""
    meant = UNIT_APART.get(said.lower()) or next(
        iter(difflib.get_close_matches(said, IN_SI, n=1, cutoff=0.6)), None
    )
    if meant in IN_SI:
        return f"unknown unit '{said}'; did you mean '{meant}'?"
    return f"unit must be one of {', '.join(IN_SI)}, {A_FACTOR}"
