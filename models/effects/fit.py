"""How a fit moves in an effect, and from where it starts: coordinates, and points to begin at."""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass, field
from enum import Enum
from typing import Literal

How = Literal["plain", "reciprocal", "log", "sine", "cosine", "frozen"]


@dataclass(frozen=True, slots=True)
class Coordinate:
    """One number the fit moves. frozen: set by a search, not by the fit."""

    parameter: str
    how: How = "plain"
    step: float = 1e-4
    low: float = -math.inf
    high: float = math.inf
    part: int = 0
    """Component of a vector parameter."""


@dataclass(frozen=True, slots=True)
class Shape:
    """A point to start from: coordinates at which nothing happens (`origin`), and unit columns.

    Columns of the score are regressors from origin along the linear coordinates, `reach` long.
    """

    origin: tuple[float, ...]
    linear: tuple[int, ...] = (0,)
    reach: float = 1e-4


class Search(Enum):
    """What finds an effect that no table of starting points does."""

    MOMENT = "a scan over the moments of the recording"
    REPEATS = "stretches of one repeated reading"
    HEIGHTS = "heights that the platform was sent to"
    CLOCK = "the clock of the sensors"


@dataclass(frozen=True, slots=True)
class Fit:
    """Coordinates, starting points and fixed parameters.

    searched: by what it is found instead of by a row of starting points for each component.
    """

    coordinates: tuple[Coordinate, ...] = ()
    shapes: tuple[Shape, ...] = ()
    fixed: Mapping[str, float] = field(default_factory=dict)
    searched: Search | None = None
