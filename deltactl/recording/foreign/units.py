"""Units: how they are written, how large they are, and which kind of column has which."""

from __future__ import annotations

import difflib

import numpy as np

UNIT_WORDS: dict[str, str] = {
    "s": "s sec secs second seconds", "ms": "ms msec millis milliseconds",
    "us": "us usec micros µs",
    "ns": "ns nsec nanos nanoseconds", "m": "m meter meters metre metres", "mm": "mm", "cm": "cm",
    "um": "um µm micron microns", "rad": "rad rads radian radians", "mrad": "mrad",
    "deg": "deg degs degree degrees grad °", "turn": "turn turns rev revs",
    "arcmin": "arcmin arcmins arcminute arcminutes ′",
    "arcsec": "arcsec arcsecs arcsecond arcseconds ″ \"", "A": "a amp amps",
    "mA": "ma milliamp milliamps", "V": "volt volts",
    "Nm": "nm n.m newtonmeter", "N": "n newton", "Ncm": "ncm",
    "mNm": "mnm", "min": "min minutes", "rad/s": "rad/s", "deg/s": "deg/s °/s", "m/s": "m/s",
    "mm/s": "mm/s", "rpm": "rpm 1/min u/min",
    "turn/s": "turn/s turns/s rev/s revs/s rps u/s",
}  # fmt: skip
"""Unit of a mapping -> how it is written in names, in lower case."""
UNIT_OF = {word: unit for unit, words in UNIT_WORDS.items() for word in words.split()}
IN_SI = {
    "s": 1.0, "ms": 1e-3, "us": 1e-6, "ns": 1e-9, "min": 60.0, "m": 1.0, "cm": 0.01, "mm": 1e-3,
    "um": 1e-6, "inch": 0.0254, "rad": 1.0, "mrad": 1e-3, "deg": np.pi / 180.0, "turn": 2.0 * np.pi,
    "arcmin": np.pi / 10800.0, "arcsec": np.pi / 648000.0,
    "N": 1.0, "mN": 1e-3, "Nm": 1.0, "mNm": 1e-3, "Ncm": 0.01, "1": 1.0, "A": 1.0, "mA": 1e-3,
    "V": 1.0,
    "rad/s": 1.0, "deg/s": np.pi / 180.0, "m/s": 1.0, "mm/s": 1e-3, "rpm": np.pi / 30.0,
    "turn/s": 2.0 * np.pi,
}  # fmt: skip
"""Units by their size in the contract's."""
UNIT_FACTORS = (1.0 / IN_SI["deg"], 1.0 / IN_SI["mm"], 1.0 / IN_SI["cm"])
"""How many degrees are one radian, and mm and cm one metre."""
TIMES = ("s", "ms", "us", "ns", "min")
ROTARY = ("rad", "mrad", "deg", "arcmin", "arcsec", "turn")
LINEAR = ("m", "mm", "cm", "um", "inch")
ROTARY_SPEEDS, LINEAR_SPEEDS = ("rad/s", "deg/s", "rpm", "turn/s"), ("m/s", "mm/s")
SPEEDS = (*ROTARY_SPEEDS, *LINEAR_SPEEDS)
"""Of `velocity` alone."""
PULLING = ("N", "mN", "Nm", "mNm", "Ncm")
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
A_FACTOR = "or a factor to SI units in its place, as position=seen*4.848e-6"


def no_unit(said: str) -> str:
    """Why a unit is refused, and which was meant by it: as people write it, or nearly."""
    meant = UNIT_OF.get(said.lower()) or next(
        iter(difflib.get_close_matches(said, IN_SI, n=1, cutoff=0.6)), None
    )
    if meant in IN_SI:
        return f"unknown unit '{said}'; did you mean '{meant}'?"
    return f"unit must be one of {', '.join(IN_SI)}, {A_FACTOR}"
