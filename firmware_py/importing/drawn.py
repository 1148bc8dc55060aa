"""What both kinds of file give: a start and legs in metres, in the robot's frame."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

Point = tuple[float, float, float]
TABLES = (".csv", ".txt", ".tsv")
"""Endings of tables of points; all else is G-code."""
FLAT = "no z: every point at the height of --origin"
CORNER_MM = 0.5
"""How far corners are cut where nobody says: a few microsteps of most robots, and enough to pass
the points of a drawn curve without a stop."""


@dataclass(frozen=True, slots=True)
class Drawn:
    """A path before it is a job; `legs` are those of a job file. notes: what was passed over.

    lines: of the file, from 1, one for each leg. start_line: that of the start.
    """

    start_m: Point
    legs: tuple[dict[str, Any], ...]
    notes: tuple[str, ...] = ()
    lines: tuple[int, ...] = ()
    start_line: int | None = None


def job_text(drawn: Drawn, name: str, robot: str, speed_mps: float, corner_m: float) -> str:
    """A job file of it."""
    import yaml  # the command line asks this file for a number only, before it shows its help

    legs = [_short(leg) for leg in drawn.legs]
    head = {
        "name": name,
        "robot": robot,
        "timing": {"mode": "accelerated", "speed_mps": speed_mps},
        "inverse_kinematics": {"kind": "geometry"},
    }
    body = yaml.safe_dump(head, sort_keys=False)
    lines = "".join(f"    - {leg}\n" for leg in legs)
    return (
        f"# Made by deltactl convert.\n{body}path:\n  shape: way\n"
        f"  start_m: {_point(drawn.start_m)}\n  corner_m: {corner_m:g}\n  legs:\n{lines}"
    )


def held(drawn: Drawn, speed_mps: float) -> str:
    """Which speeds of the file are above the job's, in words; empty where none is."""
    fast = [leg["speed_mps"] for leg in drawn.legs if leg.get("speed_mps", 0.0) > speed_mps]
    if not fast:
        return ""
    return (
        f"speeds of the file above --speed {1e3 * speed_mps:g} mm/s are held to it: up to"
        f" {1e3 * max(fast):.6g} mm/s, in {len(fast)} of {len(drawn.legs)} moves"
    )


def rounded(drawn: Drawn, corner_mm: float) -> str:
    """What becomes of the corners, in words; empty where there are none, or none is cut."""
    bends = any("spline" not in leg for leg in drawn.legs[1:])
    if not bends or corner_mm <= 0.0:
        return ""
    return f"corners are rounded by up to {corner_mm:g} mm; --corner 0 stops at each point"


def _short(leg: dict[str, Any]) -> str:
    parts = []
    for key, value in leg.items():
        text = _point(value) if isinstance(value, tuple) else str(value).lower()
        parts.append(f"{key}: {text}")
    return "{" + ", ".join(parts) + "}"


def _point(values: tuple[float, ...]) -> str:
    return "[" + ", ".join(f"{value:.7g}" for value in values) + "]"
