"""Zhao's network as Zhao 2023, section 3 describes it, and what it takes to make it learn.

Described: 3 inputs, 8 hidden layers of 50 sigmoid neurons, 3 outputs, Adam, 5000 epochs, 75 % of
the samples to train, the squared error of eq. (3). Not described: units, batch, rate, start. As it
stands, metres in and degrees out, it answers the mean angle after 5000 epochs as after one.
Added: standardised inputs and outputs (inside the file), a wider centred start, a falling rate.
`benchmarks/costs/training.py --ablation` prints what each adds.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Literal

import numpy as np

from deltactl.foundation.errors import NetworkError
from deltactl.foundation.process import one_thread
from deltactl.models.robot import ARMS, FloatArray
from deltactl.models.training.adam import advance
from deltactl.models.training.graph import Graph
from deltactl.models.training.perceptron import Perceptron, Scaling, add_layers, fold
from deltactl.models.training.recipe import Follow, Trained, plain, unseen
from deltactl.models.training.samples_of_angles import split
from deltactl.models.training.start import Start, starting_weights

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
