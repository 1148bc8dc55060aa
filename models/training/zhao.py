"""Zhao's network as Zhao 2023, section 3 describes it, and what it takes to make it learn.

Described: 3 inputs, 8 hidden layers of 50 sigmoid neurons, 3 outputs, Adam, 5000 epochs, 75 % of
the samples to train, the squared error of eq. (3). Not described: units, batch, rate, start. As
printed, metres in and degrees out, it answers the mean angle after 5000 epochs as after one.
Added: standardised inputs and outputs (inside the file), a wider centred start, a falling rate.
`benchmarks/costs/training.py --ablation` prints what each adds.

Where it begins decides whether it learns at all. A sigmoid has mean 1/2 and slope 1/4. With
Glorot's weights, meant for tanh, every layer passes on about a quarter of what differs between
samples, and after eight of them all inputs look alike: the network answers the mean for a thousand
epochs. Four times as wide, and with a bias that takes away the mean of the layer before, what goes
in comes out.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass
from itertools import pairwise
from typing import Any, Literal

import numpy as np

from deltactl.foundation.errors import NetworkError
from deltactl.foundation.extras import needs
from deltactl.foundation.process import one_thread
from deltactl.models.robot import ARMS, FloatArray
from deltactl.models.training.graph import Graph
from deltactl.models.training.perceptron import Perceptron, Scaling, add_layers, fold
from deltactl.models.training.recipe import Follow, Trained, plain, unseen
from deltactl.models.training.samples import split

Stretches = Callable[[int], Iterator[tuple[int, FloatArray]]]
"""Epochs between looks to (epochs done, weights)."""


def advance(
    start: FloatArray,
    sizes: Sequence[int],
    samples: tuple[FloatArray, FloatArray],
    rates: FloatArray,
    batch: int,
    seed: int,
) -> Stretches:
    """Prepare a training of a sigmoid network in float32 on one core.

    samples: inputs (n, k) and wanted outputs (n, m), scaled. rates: one an epoch. The same seed
    gives the same weights on the same machine. Raises MissingExtra without numba.
    """
    epochs = _kernel()
    inputs, wanted = (np.ascontiguousarray(part, dtype=np.float32) for part in samples)
    weights = start.astype(np.float32)
    moments = np.zeros((2, len(weights)), dtype=np.float32)
    shape = np.array(sizes, dtype=np.int64)
    seeds = np.random.default_rng([seed, 1])

    def stretches(length: int) -> Iterator[tuple[int, FloatArray]]:
        steps = 0
        for begin in range(0, len(rates), length):
            part = rates[begin : begin + length].astype(np.float32)
            begun = (steps, int(seeds.integers(2**31)))
            steps = epochs(weights, shape, (inputs, wanted), moments, part, batch, begun)
            yield begin + len(part), weights.astype(np.float64)

    return stretches


def _kernel() -> Any:
    with needs("training", "training this network"):
        from deltactl.models.training.adam_kernel import epochs
    return epochs


Start = Literal["glorot", "wide"]

SIGMOID_GAIN = 4.0
SIGMOID_MEAN = 0.5


def starting_weights(sizes: Sequence[int], start: Start, rng: np.random.Generator) -> FloatArray:
    """Weights and biases, flat, in the order of `Perceptron.layers`.

    "glorot": uniform, Glorot and Bengio 2010, biases 0 (what Keras does). "wide": the same four
    times as wide in all hidden layers, biases centred.
    """
    parts: list[FloatArray] = []
    last = len(sizes) - 2
    for layer, (before, after) in enumerate(pairwise(sizes)):
        reach = np.sqrt(6.0 / (before + after))
        wide = start == "wide"
        gain = SIGMOID_GAIN if wide and layer < last else 1.0
        weights = rng.uniform(-gain * reach, gain * reach, (after, before))
        centred = wide and layer > 0
        bias = -SIGMOID_MEAN * weights.sum(axis=1) if centred else np.zeros(after)
        parts += [weights.ravel(), bias]
    return np.concatenate(parts)


RECIPE = "zhao"
REPORTS = 100
"""How often a training says how far it is."""


@dataclass(frozen=True)
class ZhaoSettings:
    """Shape and effort. The first three are the paper's, the rest is what was added."""

    layers: int = 8
    width: int = 50
    epochs: int = 5000
    batch: int = 32
    standardise: bool = True
    """Inputs and outputs to mean 0 and deviation 1; without it metres in and degrees out."""
    start: Start = "wide"
    rate: float = 1e-3
    schedule: Literal["cosine", "constant"] = "cosine"
    """Cosine: the rate falls to 0 like half a cosine."""

    @property
    def sizes(self) -> tuple[int, ...]:
        """Neurons layer by layer."""
        return (ARMS, *[self.width] * self.layers, ARMS)

    def rates(self) -> FloatArray:
        """Learning rate of every epoch; shape (epochs,)."""
        part = (np.arange(self.epochs) + 0.5) / self.epochs
        falling: FloatArray = 0.5 * self.rate * (1.0 + np.cos(np.pi * part))
        return falling if self.schedule == "cosine" else np.full(self.epochs, self.rate)


AS_KERAS = ZhaoSettings(start="glorot", rate=1e-3, schedule="constant")
"""The paper's recipe on standardised data, with the defaults of Keras for all it leaves open."""
AS_PRINTED = ZhaoSettings(standardise=False, start="glorot", rate=1e-3, schedule="constant")
"""The paper's recipe on metres and degrees."""


@one_thread
def train_zhao(
    position_m: FloatArray,
    angles_rad: FloatArray,
    settings: ZhaoSettings | None = None,
    seed: int = 0,
    follow: Follow = unseen,
) -> Trained:
    """Train on measured positions (n, 3) [m] and commanded arm angles (n, 3) [rad].

    A quarter is held out (`split`). Needs the `training` extra. Raises NetworkError when a column
    is constant or the training runs away.
    """
    settings = settings or ZhaoSettings()
    rows, held = split(len(position_m), seed)
    into, out = _scalings(position_m[rows], angles_rad[rows], settings.standardise)
    network = Perceptron(settings.sizes, "sigmoid")
    start = starting_weights(settings.sizes, settings.start, np.random.default_rng(seed))
    inputs, wanted = into.apply(position_m), out.apply(angles_rad)
    course: list[tuple[int, float]] = []
    weights = start
    steps = advance(
        start, settings.sizes, (inputs[rows], wanted[rows]), settings.rates(), settings.batch, seed
    )
    for done, weights in steps(max(settings.epochs // REPORTS, 1)):
        error = (network.values(weights, inputs[held]) - wanted[held]) * out.deviation
        rmse_deg = float(np.rad2deg(np.sqrt(np.mean(error**2))))
        if not np.isfinite(rmse_deg):
            raise NetworkError(f"the training ran away in epoch {done}; lower the learning rate")
        course.append((done, rmse_deg))
        follow(done, settings.epochs, f"held-out RMS {rmse_deg:.4f} deg")
    graph = Graph()
    source = graph.input("position_m", (1, ARMS))
    layers = fold(network.layers(weights), into, out)
    return Trained(
        graph=graph,
        source=source,
        result=add_layers(graph, source, layers, "sigmoid"),
        recipe=RECIPE,
        architecture="-".join(map(str, settings.sizes)) + " sigmoid",
        parameters=network.parameters,
        samples=len(rows),
        settings=plain(settings),
        seed=seed,
        course=tuple(course),
    )


def _scalings(
    position_m: FloatArray, angles_rad: FloatArray, standardise: bool
) -> tuple[Scaling, Scaling]:
    if standardise:
        try:
            return Scaling.of(position_m), Scaling.of(angles_rad)
        except ValueError as error:
            raise NetworkError(f"the samples cannot be learned from: {error}") from error
    one = np.ones(ARMS)
    return Scaling(0.0 * one, one), Scaling(0.0 * one, np.deg2rad(one))
