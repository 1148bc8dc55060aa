"""Our own recipe: small networks of arms, one for all three or one each, in one graph.

Shared: seen from its own motor every arm of a symmetric delta has the same task: with u along the
arm and v across it, its angle depends on (u, v^2, z) alone. So the graph first turns the
target into three such rows and then sends them through one 3-16-16-1 network.

One each, for a robot whose arms differ: u, v^2 and z are enough for any lengths; only what gravity
bends depends, by hundredths of it, on the side. So each arm has a 3-n-n-1 network of its own, and
the graph runs the three side by side.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from itertools import islice
from typing import NamedTuple

import numpy as np

from deltactl.foundation.errors import NetworkError
from deltactl.models.linkage import Linkage, serial_margin
from deltactl.models.robot import ARMS, FloatArray
from deltactl.models.training import levenberg_marquardt
from deltactl.models.training.graph import Graph
from deltactl.models.training.perceptron import Layer, Perceptron, Scaling, add_layers, fold
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

REPORT_EVERY = 100
COUNT_EVERY = 10
_EMPHASIS = 3.0
_LEAST_WEIGHT = 0.05


class Samples(NamedTuple):
    """Inputs (n, k) and wanted outputs (n, m), in their own units."""

    inputs: FloatArray
    wanted_rad: FloatArray
    weight: FloatArray
    """How much each sample counts at first, shape (n,)."""


def fit(
    network: Perceptron,
    samples: Samples,
    scaling: tuple[Scaling, Scaling],
    settings: Settings,
    rng: np.random.Generator,
    watch: Stopwatch,
) -> list[Layer]:
    """Layers that take unscaled inputs and give unscaled outputs.

    The first stage minimises the squared error. Each further round multiplies a sample's
    weight by 1 to 4 according to its error (Lawson's idea for the smallest maximum error).
    """
    into, out = scaling
    inputs, wanted = into.apply(samples.inputs), out.apply(samples.wanted_rad)
    parameters = network.start(rng)
    weight = np.broadcast_to(samples.weight[:, None], wanted.shape)
    for stage in range(settings.rounds + 1):
        if stage:
            error = np.abs(network.values(parameters, inputs) - wanted)
            weight = _emphasise(weight, error)
        iterations = settings.iterations_a_round if stage else settings.iterations
        damping = 1e-6 if stage else 1e-2
        search = _search(network, (inputs, wanted), weight, parameters, damping)
        counted = 0
        for step in islice(search, iterations):
            parameters = step.parameters
            if step.iteration % COUNT_EVERY == 0:
                rms_deg = np.rad2deg(np.sqrt(step.cost / weight.sum()) * out.deviation.mean())
                watch.count(step.iteration - counted, f"RMS {rms_deg:.5f} deg")
                counted = step.iteration
                if step.iteration % REPORT_EVERY == 0 and step.iteration < iterations:
                    done = f"{step.iteration} of {iterations}"
                    watch.say(f"  iteration {done}: RMS {rms_deg:.5f} deg")
        error_deg = np.rad2deg((network.values(parameters, inputs) - wanted) * out.deviation)
        rms_deg, max_deg = np.sqrt(np.mean(error_deg**2)), np.abs(error_deg).max()
        found = f"training samples RMS {rms_deg:.5f} deg, max {max_deg:.5f} deg"
        watch.say(f"stage {stage} of {settings.rounds}: {found}")
        watch.count(iterations - counted, found)
    return fold(network.layers(parameters), into, out)


def _emphasise(weight: FloatArray, error: FloatArray) -> FloatArray:
    weight = weight * (1.0 + _EMPHASIS * error / error.max())
    evened: FloatArray = np.maximum(weight / weight.mean(), _LEAST_WEIGHT)
    return evened


def _search(
    network: Perceptron,
    samples: tuple[FloatArray, FloatArray],
    weight: FloatArray,
    start: FloatArray,
    damping: float,
) -> Iterator[levenberg_marquardt.Step]:
    inputs, wanted = samples
    root = np.sqrt(weight)

    def residuals(trial: FloatArray) -> FloatArray:
        error: FloatArray = (network.values(trial, inputs) - wanted) * root
        return error.ravel()

    def jacobian(trial: FloatArray) -> tuple[FloatArray, FloatArray]:
        values, slope = network.jacobian(trial, inputs)
        slope *= root[:, :, None]
        return ((values - wanted) * root).ravel(), slope.reshape(-1, network.parameters)

    return levenberg_marquardt.steps(residuals, jacobian, start, damping)


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
