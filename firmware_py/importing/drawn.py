"""What both kinds of file give: a start and legs in metres, in the robot's frame."""

from __future__ import annotations

import json
import math
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:  # the command line asks this file for a number only, before it shows its help
    from deltactl.firmware_py.paths.legs import Legs

Point = tuple[float, float, float]
TABLES = (".csv", ".txt", ".tsv")
"""Endings of tables of points; all else is G-code."""
FLAT = "no z: every point at the height of --origin"
CORNER_MM = 0.5
"""How far corners are cut where nobody says: a few microsteps of most robots, and enough to pass
the points of a drawn curve without a stop."""
MOST_MISTAKES = 20
"""So many of a file are listed."""


@dataclass(frozen=True, slots=True)
class Drawn:
    """A path before it is a job. notes: what was passed over.

    lines: of the file, from 1, one for each leg. start_line: that of the start. between: steps of
    a job (outputs, waits, pauses), each with how many legs come before it; -1: before the start.
    """

    start_m: Point
    legs: Legs
    notes: tuple[str, ...] = ()
    lines: Sequence[int] = ()
    start_line: int | None = None
    between: tuple[tuple[int, dict[str, Any]], ...] = ()

    def steps(self) -> Iterator[tuple[int, int] | dict[str, Any]]:
        """Steps in their order: one of a job, or the first leg of a path and that behind it."""
        first = 0
        for before, step in self.between:
            if before > first:
                yield first, before
                first = before
            yield step
        if first < len(self.legs):
            yield first, len(self.legs)


def job_text(drawn: Drawn, name: str, robot: str, speed_mps: float, corner_m: float) -> str:
    """A job file of it."""
    import yaml  # the command line asks this file for a number only, before it shows its help

    head = {
        "name": name,
        "robot": robot,
        "timing": {"mode": "accelerated", "speed_mps": speed_mps},
        "inverse_kinematics": {"kind": "geometry"},
    }
    begin = f"# Made by deltactl convert.\n{yaml.safe_dump(head, sort_keys=False)}"
    if not drawn.between:
        return begin + "".join(_way(drawn, 0, len(drawn.legs), corner_m, "", ""))
    parts = [begin, "steps:\n"]
    for step in drawn.steps():
        if isinstance(step, dict):
            parts.append(f"  - {_flow(step)}\n")
        else:
            parts.extend(_way(drawn, *step, corner_m, "  - ", "    "))
    return "".join(parts)


def job_data(
    drawn: Drawn, name: str, robot: str, speed_mps: float, corner_m: float
) -> dict[str, Any]:
    """What job_text says, as values: a long file is not read again to be checked."""
    data: dict[str, Any] = {
        "name": name,
        "robot": robot,
        "timing": {"mode": "accelerated", "speed_mps": speed_mps},
        "inverse_kinematics": {"kind": "geometry"},
    }

    def way(first: int, last: int) -> dict[str, Any]:
        begin = {"start_m": drawn.start_m} if first == 0 else {}
        return {
            "shape": "way",
            **begin,
            "corner_m": corner_m,
            "legs": drawn.legs.rows(slice(first, last)),
        }

    if not drawn.between:
        return data | {"path": way(0, len(drawn.legs))}
    steps = (one if isinstance(one, dict) else {"path": way(*one)} for one in drawn.steps())
    return data | {"steps": tuple(steps)}


def held(drawn: Drawn, speed_mps: float) -> str:
    """Which speeds of the file are above the job's, in words; empty where none is."""
    speeds_mps = drawn.legs.speed_mps
    fast = speeds_mps[(speeds_mps > speed_mps) & (speeds_mps < math.inf)]
    if not len(fast):
        return ""
    return (
        f"speeds of the file above --speed {1e3 * speed_mps:g} mm/s are held to it: up to"
        f" {1e3 * fast.max():.6g} mm/s, in {len(fast)} of {len(drawn.legs)} moves"
    )


def rounded(drawn: Drawn, corner_mm: float) -> str:
    """What becomes of the corners, in words; empty where there are none, or none is cut."""
    bends = not drawn.legs.spline[1:].all()
    if not bends or corner_mm <= 0.0:
        return ""
    return f"corners are rounded by up to {corner_mm:g} mm; --corner 0 stops at each point"


def as_written(place_m: tuple[float, ...]) -> tuple[float, ...]:
    """A place with the digits that a job file has of it: the text says what was checked."""
    return tuple(float(f"{value:.7g}") for value in place_m)


def _way(
    drawn: Drawn, first: int, last: int, corner_m: float, bullet: str, indent: str
) -> Iterator[str]:
    yield f"{bullet}path:\n{indent}  shape: way\n"
    if first == 0:
        yield f"{indent}  start_m: {_point(drawn.start_m)}\n"
    yield f"{indent}  corner_m: {corner_m:g}\n{indent}  legs:\n"
    for leg in drawn.legs.rows(slice(first, last)):
        yield f"{indent}    - {_short(leg)}\n"


def _short(leg: dict[str, Any]) -> str:
    parts = []
    for key, value in leg.items():
        text = _point(value) if isinstance(value, tuple) else str(value).lower()
        parts.append(f"{key}: {text}")
    return "{" + ", ".join(parts) + "}"


def _flow(step: dict[str, Any]) -> str:
    """A step as YAML on one line; JSON is such."""
    ((key, value),) = step.items()
    return f"{key}: {json.dumps(value)}"


def _point(values: tuple[float, ...]) -> str:
    return "[" + ", ".join(f"{value:.7g}" for value in values) + "]"
