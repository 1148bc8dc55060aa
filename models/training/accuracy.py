"""How wrong a network is as it runs: on even points, and where it is worst."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

from deltactl.models.linkage import Linkage
from deltactl.models.network.file import NetworkFile
from deltactl.models.network.inverse import InverseNetwork
from deltactl.models.network.metadata import Validation
from deltactl.models.robot import FloatArray
from deltactl.models.training.recipe import Task
from deltactl.models.training.samples import around, edges, hardest, labels_rad, spread

STREAM = 1
"""Second word of the validation's seed: never the stream that chose training samples."""

_FINEST_M = 1e-9
_HEADROOM = 1.5
"""The bound is this many times the worst found: searches from other starts differ by a tenth."""

_CLIMBERS, _TRIES, _NARROW = 50, 50, 0.85


@dataclass(frozen=True)
class Effort:
    """How hard to look: even samples, and rounds of the search for the worst point."""

    samples: int = 20_000
    rounds: int = 40


Errors = Callable[[FloatArray], FloatArray]
"""Positions (n, 3) to the size of the largest of three errors [deg], (n,)."""


def measure(file: NetworkFile, task: Task, effort: Effort | None = None) -> Validation:
    """Errors of the running network against the float64 geometry, on points of its own."""
    effort = effort or Effort()
    rng = np.random.default_rng([task.seed, STREAM])
    linkage, network = Linkage.of(task.robot.geometry), InverseNetwork(file)
    even_m = spread(task.domain, rng, effort.samples)
    even_m = even_m[task.learns(labels_rad(linkage, even_m))]
    even_deg = errors_deg(network, linkage, task, even_m)
    return Validation(
        samples=len(even_deg),
        rmse_deg=float(np.sqrt(np.mean(even_deg**2))),
        max_deg=float(np.abs(even_deg).max()),
        bound_deg=_HEADROOM * worst_deg(network, task, rng, effort),
    )


def errors_deg(
    network: InverseNetwork, linkage: Linkage, task: Task, position_m: FloatArray
) -> FloatArray:
    """Network minus geometry [deg], shape (n, 3); 0 at poses the task is not about."""
    wanted_rad = labels_rad(linkage, position_m)
    error_rad = network.raw_rad_many(position_m) - wanted_rad
    error_rad[~task.learns(wanted_rad)] = 0.0
    error_deg: FloatArray = np.rad2deg(error_rad)
    return error_deg


def worst_deg(
    network: InverseNetwork, task: Task, rng: np.random.Generator, effort: Effort
) -> float:
    """The largest error that a search finds: many points, then uphill from the worst of them."""
    linkage, some = Linkage.of(task.robot.geometry), effort.samples // 2
    anchor_m = hardest(task.domain, linkage, rng)
    start_m = np.vstack(
        [
            anchor_m,
            spread(task.domain, rng, some),
            edges(task.domain, rng, some),
            around(task.domain, anchor_m, rng, some, _FINEST_M),
        ]
    )

    def size_deg(position_m: FloatArray) -> FloatArray:
        error_deg = errors_deg(network, linkage, task, position_m)
        largest: FloatArray = np.abs(error_deg).max(axis=1)
        return largest

    return _climb(size_deg, task, start_m, rng, effort.rounds)


def _climb(
    size_deg: Errors, task: Task, start_m: FloatArray, rng: np.random.Generator, rounds: int
) -> float:
    """Keep the worst points, try others near them at all scales, in ever closer rounds."""
    low_m, high_m = task.domain.bounding_box()
    reach_m = 0.03 * (high_m - low_m)
    points_m, found_deg = start_m, size_deg(start_m)
    for _ in range(rounds):
        worst = np.argsort(-found_deg)[:_CLIMBERS]
        points_m, found_deg = points_m[worst], found_deg[worst]
        scale = 10.0 ** rng.uniform(-3.0, 0.0, (len(points_m) * _TRIES, 1))
        step_m = rng.normal(size=(len(points_m) * _TRIES, 3)) * reach_m * scale
        tries_m = task.domain.clip(np.repeat(points_m, _TRIES, axis=0) + step_m)
        points_m = np.vstack([points_m, tries_m])
        found_deg = np.concatenate([found_deg, size_deg(tries_m)])
        reach_m = _NARROW * reach_m
    return float(found_deg.max())
