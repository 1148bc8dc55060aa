"""Uzunovic's network as Uzunovic 2013, section 3.2 describes it: 3-25-3, Levenberg-Marquardt.

25 tansig neurons (tanh), linear outputs, the squared error of eq. (2) over all samples. Not
described: scaling and start. Here inputs and outputs are standardised inside the file; of many
random starts, sifted in rounds, the best is trained to the end.

Normal equations of a network with one hidden layer of tanh and linear outputs.

All outputs share the hidden layer, so the Jacobian of 13 333 samples and three outputs (40 000
rows of 178) need not be formed: with A the derivatives of the hidden neurons by their own weights
(n, hidden * (inputs + 1)) and H the hidden neurons and a one (n, hidden + 1), every block of J'J
is a block of [A H]'[A H] times products of output weights. That is a sixth of the work.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass, replace
from itertools import islice

import numpy as np

from deltactl.foundation.errors import NetworkError
from deltactl.foundation.process import one_thread
from deltactl.models.robot import ARMS, FloatArray
from deltactl.models.training import levenberg_marquardt
from deltactl.models.training.graph import Graph
from deltactl.models.training.levenberg_marquardt import Normal, Step
from deltactl.models.training.perceptron import Perceptron, Scaling, add_layers, fold
from deltactl.models.training.recipe import Follow, Trained, plain, unseen
from deltactl.models.training.samples import IntArray, split

_BLOCK = 2048
"""Samples looked at together: their arrays stay in the cache."""


def search(
    network: Perceptron,
    inputs: FloatArray,
    wanted: FloatArray,
    start: FloatArray,
    damping: float = 1e-2,
) -> Iterator[Step]:
    """Levenberg-Marquardt from `start`; inputs (n, k) and wanted outputs (n, m), scaled."""
    if len(network.sizes) != 3 or network.activation != "tanh":
        raise ValueError(f"{network.sizes} {network.activation} is not a 3-n-3 network of tanh")

    def cost(parameters: FloatArray) -> float:
        return float(np.sum((network.values(parameters, inputs) - wanted) ** 2))

    def normal(parameters: FloatArray) -> Normal:
        parts = [
            _normal(network, parameters, inputs[at : at + _BLOCK], wanted[at : at + _BLOCK])
            for at in range(0, len(inputs), _BLOCK)
        ]
        costs, matrices, gradients = zip(*parts, strict=True)
        return Normal(sum(costs), sum(matrices), sum(gradients))

    return levenberg_marquardt.steps_by_normal(cost, normal, start, damping)


def _normal(
    network: Perceptron, parameters: FloatArray, inputs: FloatArray, wanted: FloatArray
) -> Normal:
    count, hidden = len(inputs), network.sizes[1]
    (_, _), (output, _) = layers = network.layers(parameters)
    one = np.ones((count, 1))
    values = np.tanh(inputs @ layers[0][0].T + layers[0][1])
    bent = np.hstack([values, one])
    error = values @ output.T + layers[1][1] - wanted
    # Weight by weight as `Perceptron.layers` has them: all of the matrix, then the bias.
    fed = np.hstack([inputs, one])
    by_input = (1.0 - values**2)[:, None, :] * fed[:, :, None]
    both = np.hstack([by_input.reshape(count, -1), bent])
    gram = both.T @ both
    width = fed.shape[1] * hidden
    first = gram[:width, :width].reshape(-1, hidden, fed.shape[1], hidden)
    first = (first * (output.T @ output)[None, :, None, :]).reshape(width, width)
    cross = gram[:width, None, width:] * np.tile(output.T, (fed.shape[1], 1))[:, :, None]
    last = np.kron(np.eye(len(output)), gram[width:, width:])
    cross = cross.reshape(width, -1)
    slope = np.einsum("nki,ni->ki", by_input, error @ output).ravel()
    matrix = np.block([[first, cross], [cross.T, last]])
    gradient = np.concatenate([slope, (error.T @ bent).ravel()])
    order = _order(network)
    return Normal(float(np.sum(error**2)), matrix[np.ix_(order, order)], gradient[order])


def _order(network: Perceptron) -> FloatArray:
    """Where each parameter is in the blocks above: (input, neuron), then (output, neuron)."""
    inputs, hidden, outputs = network.sizes
    first = np.arange((inputs + 1) * hidden).reshape(inputs + 1, hidden)
    last = first.size + np.arange(outputs * (hidden + 1)).reshape(outputs, hidden + 1)
    parts = [first[:-1].T, first[-1], last[:, :-1], last[:, -1]]
    order: FloatArray = np.concatenate([part.ravel() for part in parts])
    return order


RECIPE = "uzunovic"
_REPORT_EVERY = 10


@dataclass(frozen=True)
class UzunovicSettings:
    """Shape and effort; the width is the paper's."""

    width: int = 25
    iterations: int = 150
    few: int = 1500
    """Samples by which starts are sifted."""
    rounds: tuple[tuple[int, int], ...] = ((16, 60), (8, 150), (3, 300))
    """Starts and iterations of each round of sifting; the best of the last goes on with all."""
    enough: float = 1e-5
    """Ends when the error fell by less than this part over the last 20 iterations."""
    hold_out: bool = True
    """A quarter to judge by; the paper trains on, and judges by, all samples."""

    def lasting(self, iterations: int) -> UzunovicSettings:
        """With another number of iterations; a shorter training sifts for less, in proportion."""
        part = min(iterations / self.iterations, 1.0)
        rounds = tuple((starts, max(round(part * each), 1)) for starts, each in self.rounds)
        return replace(self, iterations=iterations, rounds=rounds)


@one_thread
def train_uzunovic(
    position_m: FloatArray,
    angles_rad: FloatArray,
    settings: UzunovicSettings | None = None,
    seed: int = 0,
    follow: Follow = unseen,
) -> Trained:
    """Train on measured positions (n, 3) [m] and arm angles (n, 3) [rad].

    Raises NetworkError when a column is constant. Needs scipy (the `training` extra).
    """
    settings = settings or UzunovicSettings()
    rows, held = _parts(len(position_m), seed, settings.hold_out)
    try:
        into, out = Scaling.of(position_m[rows]), Scaling.of(angles_rad[rows])
    except ValueError as error:
        raise NetworkError(f"the samples cannot be learned from: {error}") from error
    network = Perceptron((ARMS, settings.width, ARMS))
    inputs, wanted = into.apply(position_m), out.apply(angles_rad)
    start = _sifted(network, inputs[rows], wanted[rows], settings, seed)
    parameters, course, costs = start, [], []
    total = settings.iterations
    for step in islice(search(network, inputs[rows], wanted[rows], start), total):
        parameters = step.parameters
        costs.append(step.cost)
        over = len(costs) > 20 and costs[-21] - costs[-1] < settings.enough * costs[-1]
        if step.iteration % _REPORT_EVERY == 0 or over or step.iteration == total:
            left = (network.values(parameters, inputs[held]) - wanted[held]) * out.deviation
            course.append((step.iteration, float(np.rad2deg(np.sqrt(np.mean(left**2))))))
            words = "held-out RMS" if settings.hold_out else "RMS"
            done = total if over else step.iteration
            follow(done, total, f"{words} {course[-1][1]:.4f} deg")
        if over:
            break
    graph = Graph()
    source = graph.input("position_m", (1, ARMS))
    layers = fold(network.layers(parameters), into, out)
    return Trained(
        graph=graph,
        source=source,
        result=add_layers(graph, source, layers, "tanh"),
        recipe=RECIPE,
        architecture="-".join(map(str, network.sizes)) + " tanh",
        parameters=network.parameters,
        samples=len(rows),
        settings=plain(settings),
        seed=seed,
        course=tuple(course),
    )


def _parts(count: int, seed: int, hold_out: bool) -> tuple[IntArray, IntArray]:
    everything = np.arange(count)
    return split(count, seed) if hold_out else (everything, everything)


def _sifted(
    network: Perceptron,
    inputs: FloatArray,
    wanted: FloatArray,
    settings: UzunovicSettings,
    seed: int,
) -> FloatArray:
    """Where the best of many random starts gets to on a part of the samples.

    Starts end in valleys of unlike depth, and a few iterations do not tell which is deep: so the
    better ones go on, round by round. A tenth of the samples tells as much for a tenth of the time.
    """
    rng = np.random.default_rng(seed)
    few = rng.permutation(len(inputs))[: settings.few]
    inputs, wanted = inputs[few], wanted[few]
    left = [network.start(rng) for _ in range(settings.rounds[0][0])]
    for starts, iterations in settings.rounds:
        ends = []
        for start in left[:starts]:
            tried = list(islice(search(network, inputs, wanted, start), iterations))
            ends.append((tried[-1].cost, tried[-1].parameters) if tried else (np.inf, start))
        left = [parameters for _, parameters in sorted(ends, key=lambda end: end[0])]
    return left[0]
