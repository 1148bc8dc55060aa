"""What a training run is given, what it makes, and how it tells how far it is."""

from __future__ import annotations

import time
from collections.abc import Callable
from dataclasses import asdict, dataclass, field
from typing import Any

import numpy as np

from deltactl.models.network.metadata import Box, Cylinder, Range
from deltactl.models.robot import DeltaRobot, EffectEntry, FloatArray
from deltactl.models.training.graph import Graph

BoolArray = np.ndarray[Any, np.dtype[np.bool_]]
Progress = Callable[[str], None]
Follow = Callable[[int, int, str], None]
"""Called with the progress: iterations done, of how many, and the result so far in words."""


def silent(line: str) -> None:
    """Says nothing."""


def unseen(done: int, total: int, text: str) -> None:
    """Shows nothing."""


@dataclass(frozen=True)
class Task:
    """A robot, the region to learn, and a seed."""

    robot: DeltaRobot
    domain: Cylinder | Box
    seed: int
    angle_deg: Range = (-180.0, 180.0)
    """Only poses with all arms in this range are learned, and answered."""

    def learns(self, angles_rad: FloatArray) -> BoolArray:
        """Which rows of (n, 3) arm angles [rad] are in range; shape (n,)."""
        low_rad, high_rad = np.deg2rad(self.angle_deg)
        inside: BoolArray = ((angles_rad >= low_rad) & (angles_rad <= high_rad)).all(axis=1)
        return inside


@dataclass(frozen=True)
class Settings:
    """Effort and shape of a Levenberg-Marquardt training."""

    hidden: tuple[int, ...] = (16, 16)
    spread: int = 2000
    """Positions evenly over the domain."""
    edge: int = 500
    """Positions on its faces."""
    cluster: int = 4000
    """Positions around the hardest point, at all scales."""
    cluster_weight: float = 0.3
    """Weight of one such position at first; one of the others counts 1."""
    finest_m: float = 2e-6
    iterations: int = 800
    rounds: int = 5
    """How often the samples are weighted anew by their errors, to lower the largest."""
    iterations_a_round: int = 200

    @property
    def total(self) -> int:
        """Iterations of all stages."""
        return self.iterations + self.rounds * self.iterations_a_round

    def as_metadata(self) -> dict[str, float | int | str]:
        """Plain values for the file's metadata."""
        plain = asdict(self)
        plain["hidden"] = "-".join(map(str, self.hidden))
        return plain


def plain(settings: Any) -> dict[str, float | int | str]:
    """A dataclass of settings as the metadata has them: yes, no and tables as words."""
    return {name: _as_word(value) for name, value in asdict(settings).items()}


def _as_word(value: Any) -> float | int | str:
    if isinstance(value, bool):
        return "yes" if value else "no"
    return str(value) if isinstance(value, tuple) else value


@dataclass(frozen=True)
class Trained:
    """A network ready to be written."""

    graph: Graph
    source: int
    result: int
    recipe: str
    architecture: str
    parameters: int
    samples: int
    settings: dict[str, float | int | str] = field(default_factory=dict)
    seed: int = 0
    course: tuple[tuple[int, float], ...] = ()
    """Epochs or iterations, and the RMS error [deg] on the held-out samples at that time."""
    remarks: tuple[tuple[str, str], ...] = ()
    """What else there is to say, as name and words."""
    effects: tuple[EffectEntry, ...] = ()
    """Effects of the robot file that the answers take into account."""

    def angles_rad_many(self, position_m: FloatArray) -> FloatArray:
        """Angles [rad] of positions [m], both (n, 3), in float64, refusing nothing."""
        return self.graph.values(self.source, self.result, position_m)

    def rmse_deg(self, position_m: FloatArray, angles_rad: FloatArray) -> float:
        """Root of the mean squared error [deg] over all samples and arms."""
        error_rad = self.angles_rad_many(position_m) - angles_rad
        return float(np.rad2deg(np.sqrt(np.mean(error_rad**2))))


class Stopwatch:
    """Prefixes progress lines with the seconds since it was made, and counts iterations."""

    def __init__(
        self,
        progress: Progress,
        about: str = "",
        follow: Follow = unseen,
        part: tuple[int, int] = (0, 0),
    ):
        """`part`: iterations done before, and in all; `follow` is called for those since."""
        self._start_s = time.monotonic()
        self._progress, self._follow = progress, follow
        self._about = about
        self._done, self._total = part

    def say(self, text: str) -> None:
        """Pass one line on."""
        self._progress(f"{time.monotonic() - self._start_s:6.1f} s  {self._about}{text}")

    def count(self, iterations: int, text: str) -> None:
        """So many more iterations are done, with this result."""
        self._done += iterations
        self._follow(self._done, self._total, f"{self._about}{text}")
