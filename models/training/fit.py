"""Fits a perceptron to labels by Levenberg-Marquardt, then evens out its largest errors."""

from __future__ import annotations

from collections.abc import Iterator
from itertools import islice
from typing import NamedTuple

import numpy as np

from deltactl.models.robot import FloatArray
from deltactl.models.training import levenberg_marquardt
from deltactl.models.training.perceptron import Layer, Perceptron, Scaling, fold
from deltactl.models.training.recipe import Settings, Stopwatch

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
