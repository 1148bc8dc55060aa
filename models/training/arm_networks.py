"""Three small networks, one an arm, in one graph: the inverse of a robot whose arms differ.

Seen from its own motor an arm's angle depends on (u, v^2, z): along it, across it squared, up.
That holds for any lengths; only what gravity bends depends, by hundredths of it, on the side. So
each arm has a 3-n-n-1 network of its own, and the graph runs the three side by side.
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from deltactl.models.linkage import Linkage
from deltactl.models.robot import ARMS, FloatArray
from deltactl.models.training.fit import Samples, fit
from deltactl.models.training.graph import Graph
from deltactl.models.training.perceptron import Layer, Perceptron, Scaling, add_layers
from deltactl.models.training.recipe import Follow, Settings, Stopwatch, silent, unseen
from deltactl.models.training.shared_arm import arm_rows, frame_rows


def train_arms(
    linkage: Linkage,
    position_m: FloatArray,
    angles_rad: FloatArray,
    settings: Settings,
    seed: int,
    follow: Follow = unseen,
) -> tuple[Graph, int, int, int]:
    """Graph, its ends, and the number of parameters, from exact poses, both (n, 3).

    `linkage` gives the arms' directions; it need not explain the poses.
    """
    network = Perceptron((3, *settings.hidden, 1))
    rows = arm_rows(linkage, position_m)
    arms: list[list[Layer]] = []
    for arm in range(ARMS):
        inputs, wanted = rows[:, arm], angles_rad[:, arm, None]
        samples = Samples(inputs, wanted, np.ones(len(inputs)))
        scaling = Scaling.of(inputs), Scaling.of(wanted)
        rng = np.random.default_rng([seed, arm])
        part = arm * settings.total, ARMS * settings.total
        watch = Stopwatch(silent, f"arm {arm + 1}: ", follow, part)
        arms.append(fit(network, samples, scaling, settings, rng, watch))
    graph, source, result = side_by_side(linkage, arms)
    return graph, source, result, ARMS * network.parameters


def side_by_side(linkage: Linkage, arms: Sequence[list[Layer]]) -> tuple[Graph, int, int]:
    """The graph: target (1, 3) to (u, v^2, z) of all arms (1, 9) to angles (1, 3)."""
    graph = Graph()
    source = graph.input("position_m", (1, ARMS))
    rows = frame_rows(graph, source, linkage)
    layers = [_together(parts) for parts in zip(*arms, strict=True)]
    return graph, source, add_layers(graph, rows, layers, "tanh")


def _together(parts: Sequence[Layer]) -> Layer:
    """Layers of separate networks as one: blocks along the diagonal, zeros elsewhere."""
    heights, widths = zip(*(weights.shape for weights, _ in parts), strict=True)
    together = np.zeros((sum(heights), sum(widths)))
    row = column = 0
    for weights, _ in parts:
        height, width = weights.shape
        together[row : row + height, column : column + width] = weights
        row, column = row + height, column + width
    return together, np.concatenate([bias for _, bias in parts])
