"""Normal equations of a network with one hidden layer of tanh and linear outputs.

All outputs share the hidden layer, so the Jacobian of 13 333 samples and three outputs (40 000
rows of 178) need not be formed: with A the derivatives of the hidden neurons by their own weights
(n, hidden * (inputs + 1)) and H the hidden neurons and a one (n, hidden + 1), every block of J'J
is a block of [A H]'[A H] times products of output weights. That is a sixth of the work.
"""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np

from deltactl.models.robot import FloatArray
from deltactl.models.training import levenberg_marquardt
from deltactl.models.training.levenberg_marquardt import Normal, Step
from deltactl.models.training.perceptron import Perceptron

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
