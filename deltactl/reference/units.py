"""The unit of every key that is a number: by the end of its name, or where that says none, by key.

Of a number without a unit it is said what it counts or is the ratio of.
"""

from __future__ import annotations

BY_SUFFIX = {
    "m": "m", "mm": "mm", "rad": "rad", "deg": "degrees", "s": "s", "ms": "ms", "us": "us",
    "hz": "Hz", "kg": "kg", "n": "N", "nm": "N m", "radps": "rad/s", "radps2": "rad/s2",
    "mps": "m/s", "gib": "GiB", "days": "days", "a": "A", "nmpa": "N m/A", "kgm2": "kg m2",
    "nmsprad": "N m s/rad", "1ps": "1/s", "1ps2": "1/s2", "mcps": "Mcps", "pin": "BCM number",
    "pins": "BCM numbers", "scale": "ratio", "ratio": "ratio", "fraction": "ratio",
}  # fmt: skip

BY_KEY = {
    "pin": "BCM number",
    "turns": "turns",
    "repeats": "count",
    "repeat": "count",
    "retries": "count",
    "count": "count",
    "skip_lines": "count",
    "seed": "any number",
    "microsteps_per_rev": "count",
    "singularity_margin": "sine",
    "correlation": "ratio",
    "probability": "ratio",
    "axis": "ratio",
    "chip": "number of a chip",
    "bus": "number of a bus",
    "addresses": "7-bit address",
    "joint": "number of a joint",
    "inertia": "kg m2 or kg",
    "effort_gain": "N m or N",
    "drive_stiffness": "N m/rad or N/m",
    "parameters": "SI units",
    "ci95": "SI units",
    "scale": "ratio",
    "offset": "SI units",
    "value": "SI units",
}

BOUNDED_ELSEWHERE = {"parameters": "those of the effect", "ci95": "those of the effect"}
"""Numbers whose bounds depend on another key."""


def unit_of(key: str) -> str:
    """The unit of a key; empty where its name tells none."""
    return BY_KEY.get(key) or (BY_SUFFIX.get(key.rsplit("_", 1)[-1], "") if "_" in key else "")
