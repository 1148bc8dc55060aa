"""Our own recipe: one small network for all three arms, asked three times in one call.

Seen from its own motor every arm of a symmetric delta has the same task: with u along the
arm and v across it, its angle depends on (u, v^2, z) alone. So the graph first turns the
target into three such rows and then sends them through one 3-16-16-1 network.
"""

from __future__ import annotations

import numpy as np

from deltactl.foundation.errors import NetworkError
from deltactl.models.linkage import Linkage, serial_margin
from deltactl.models.robot import ARMS, FloatArray
from deltactl.models.training.fit import Samples, fit
from deltactl.models.training.graph import Graph
from deltactl.models.training.perceptron import Layer, Perceptron, Scaling, add_layers
from deltactl.models.training.recipe import (
    Follow,
    Progress,
    Settings,
    Stopwatch,
    Task,
    Trained,
    silent,
    unseen,
)
from deltactl.models.training.samples import around, edges, hardest, labels_rad, spread

RECIPE = "shared_arm"


def train(
    task: Task, settings: Settings, progress: Progress = silent, follow: Follow = unseen
) -> Trained:
    """Train the shared network on the geometry of the task's robot.

    Raises NetworkError when the arms differ or the domain cannot be reached.
    """
    linkage = Linkage.of(task.robot.geometry)
    _require_equal_arms(task.robot.name, linkage)
    watch = Stopwatch(progress, follow=follow, part=(0, settings.total))
    rng = np.random.default_rng(task.seed)
    even, hard = _samples(linkage, task, settings, rng)
    scaling = Scaling.of(even.inputs), Scaling.of(even.wanted_rad)
    samples = Samples(*(np.concatenate(pair) for pair in zip(even, hard, strict=True)))
    network = Perceptron((3, *settings.hidden, 1))
    layers = fit(network, samples, scaling, settings, rng, watch)
    graph, source, result = build(linkage, layers)
    return Trained(
        graph=graph,
        source=source,
        result=result,
        recipe=RECIPE,
        architecture="-".join(map(str, network.sizes)) + " tanh, shared by three arms",
        parameters=network.parameters,
        samples=settings.spread + settings.edge + settings.cluster,
        settings=settings.as_metadata(),
    )


def build(linkage: Linkage, layers: list[Layer]) -> tuple[Graph, int, int]:
    """The graph: target (1, 3) to rows (3 arms, 3), through `layers`, to angles (1, 3).

    v^2 is made by multiplying (u, v, z) with (1, v, 1), both linear in the target.
    """
    graph = Graph()
    source = graph.input("position_m", (1, 3))
    rows = graph.reshape(frame_rows(graph, source, linkage), (ARMS, 3))
    angles = add_layers(graph, rows, layers, "tanh")
    return graph, source, graph.reshape(angles, (1, ARMS))


def frame_rows(graph: Graph, source: int, linkage: Linkage) -> int:
    """Add to the graph: target (1, 3) to (u, v^2, z) of all arms, (1, 9)."""
    values, factors = np.zeros((ARMS, 3, 3)), np.zeros((ARMS, 3, 3))
    ones = np.zeros((ARMS, 3))
    for arm, azimuth_rad in enumerate(linkage.azimuth_rad):
        cosine, sine = np.cos(azimuth_rad), np.sin(azimuth_rad)
        values[arm] = [[cosine, sine, 0.0], [-sine, cosine, 0.0], [0.0, 0.0, 1.0]]
        factors[arm, 1] = values[arm, 1]
        ones[arm] = [1.0, 0.0, 1.0]
    row = graph.fully_connected(source, values.reshape(9, 3), np.zeros(9))
    factor = graph.fully_connected(source, factors.reshape(9, 3), ones.reshape(9))
    return graph.multiply(row, factor)


def arm_rows(linkage: Linkage, position_m: FloatArray) -> FloatArray:
    """(u, v^2, z) of every arm, shape (n, 3 arms, 3), of positions (n, 3)."""
    cosine, sine = np.cos(linkage.azimuth_rad), np.sin(linkage.azimuth_rad)
    x_m, y_m, z_m = (position_m[:, axis, None] for axis in range(3))
    u, v = cosine * x_m + sine * y_m, cosine * y_m - sine * x_m
    return np.stack([u, v**2, np.broadcast_to(z_m, u.shape)], axis=-1)


def _samples(
    linkage: Linkage, task: Task, settings: Settings, rng: np.random.Generator
) -> tuple[Samples, Samples]:
    """All arms over the domain and its edges; the hardest arm around its hardest point."""
    even_m = np.concatenate(
        [spread(task.domain, rng, settings.spread), edges(task.domain, rng, settings.edge)]
    )
    even_m, angles_rad = _learned(linkage, task, even_m)
    rows = arm_rows(linkage, even_m)
    even = Samples(rows.reshape(-1, 3), angles_rad.reshape(-1, 1), np.ones(angles_rad.size))
    anchor_m = hardest(task.domain, linkage, rng)
    near_m = around(task.domain, anchor_m, rng, settings.cluster, settings.finest_m)
    at_anchor = anchor_m[None], labels_rad(linkage, anchor_m[None])
    arm = int(serial_margin(linkage, at_anchor[1], at_anchor[0]).argmin())
    hard_m, hard_rad = _learned(linkage, task, near_m)
    hard = Samples(
        arm_rows(linkage, hard_m)[:, arm],
        hard_rad[:, arm, None],
        np.full(len(hard_m), settings.cluster_weight),
    )
    return even, hard


def _learned(linkage: Linkage, task: Task, position_m: FloatArray) -> tuple[FloatArray, FloatArray]:
    """Positions and angles of those poses that the task is about."""
    angles_rad = labels_rad(linkage, position_m)
    kept = task.learns(angles_rad)
    return position_m[kept], angles_rad[kept]


def _require_equal_arms(name: str, linkage: Linkage) -> None:
    for field in ("radius_m", "upper_arm_m", "forearm_m", "home_offset_rad"):
        if np.ptp(getattr(linkage, field)) > 0.0:
            raise NetworkError(
                f"robot '{name}': its arms differ ({field}), one network cannot serve all three; "
                "train with --recipe uzunovic, or ours on a data set"
            )
