"""Multilayer perceptron in float64: values, and derivatives by every weight."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from itertools import pairwise

import numpy as np

from deltactl.models.robot import FloatArray
from deltactl.models.training.graph import Activation, Graph

Layer = tuple[FloatArray, FloatArray]
"""Weights of shape (outputs, inputs) and bias of shape (outputs,)."""


@dataclass(frozen=True)
class Perceptron:
    """Layers of `sizes` with one activation in between and a linear end, e.g. (3, 25, 3)."""

    sizes: tuple[int, ...]
    activation: Activation = "tanh"

    @property
    def parameters(self) -> int:
        """How many numbers there are to train."""
        return sum((inputs + 1) * outputs for inputs, outputs in pairwise(self.sizes))

    def start(self, rng: np.random.Generator) -> FloatArray:
        """Random parameters for standardised inputs; shape (parameters,)."""
        parts = []
        for inputs, outputs in pairwise(self.sizes):
            parts.append(rng.normal(0.0, 1.0 / np.sqrt(inputs), inputs * outputs))
            parts.append(rng.normal(0.0, 0.5, outputs))
        return np.concatenate(parts)

    def layers(self, parameters: FloatArray) -> list[Layer]:
        """The parameters as weights and biases (views)."""
        layers, at = [], 0
        for inputs, outputs in pairwise(self.sizes):
            weights = parameters[at : at + inputs * outputs].reshape(outputs, inputs)
            at += inputs * outputs
            layers.append((weights, parameters[at : at + outputs]))
            at += outputs
        return layers

    def values(self, parameters: FloatArray, inputs: FloatArray) -> FloatArray:
        """Outputs, shape (n, sizes[-1]), for inputs of shape (n, sizes[0])."""
        return self._forward(parameters, inputs)[-1]

    def jacobian(self, parameters: FloatArray, inputs: FloatArray) -> tuple[FloatArray, FloatArray]:
        """Outputs (n, m) and their derivatives by the parameters, (n, m, parameters)."""
        outputs = self._forward(parameters, inputs)
        count, width = len(inputs), self.sizes[-1]
        derivative = np.empty((count, width, self.parameters))
        layers, end = self.layers(parameters), self.parameters
        # d output / d pre-activation of the layer in hand, shape (n, m, units).
        slope = np.broadcast_to(np.eye(width), (count, width, width))
        for index in range(len(layers) - 1, -1, -1):
            before, (weights, bias) = outputs[index], layers[index]
            derivative[..., end - bias.size : end] = slope
            end -= bias.size
            block = slope[..., :, None] * before[:, None, None, :]
            derivative[..., end - weights.size : end] = block.reshape(count, width, -1)
            end -= weights.size
            if index:
                slope = (slope @ weights) * self._slope(before)[:, None, :]
        return outputs[-1], derivative

    def _forward(self, parameters: FloatArray, inputs: FloatArray) -> list[FloatArray]:
        """Inputs, then the output of every layer."""
        outputs = [np.asarray(inputs, dtype=np.float64)]
        layers = self.layers(parameters)
        for index, (weights, bias) in enumerate(layers):
            before = outputs[-1] @ weights.T + bias
            outputs.append(before if index == len(layers) - 1 else self._bend(before))
        return outputs

    def _bend(self, before: FloatArray) -> FloatArray:
        # A sigmoid written with tanh: exp would overflow for large negative values.
        is_tanh = self.activation == "tanh"
        bent: FloatArray = np.tanh(before) if is_tanh else 0.5 + 0.5 * np.tanh(0.5 * before)
        return bent

    def _slope(self, after: FloatArray) -> FloatArray:
        """Derivative of the activation, from its value."""
        return 1.0 - after**2 if self.activation == "tanh" else after * (1.0 - after)


@dataclass(frozen=True)
class Scaling:
    """Standardisation `(value - mean) / deviation`, column by column."""

    mean: FloatArray
    deviation: FloatArray

    @classmethod
    def of(cls, values: FloatArray) -> Scaling:
        """From data of shape (n, columns). Raises ValueError for a constant column."""
        mean, deviation = values.mean(axis=0), values.std(axis=0)
        # Not by the deviation: rounding leaves it a little above 0.
        varies = np.ptp(values, axis=0) > 0.0
        if not varies.all():
            raise ValueError(f"column {int(np.argmin(varies))} is constant; nothing to learn")
        return cls(mean, deviation)

    def apply(self, values: FloatArray) -> FloatArray:
        """Standardised values."""
        return (values - self.mean) / self.deviation


def fold(layers: Sequence[Layer], inputs: Scaling, outputs: Scaling) -> list[Layer]:
    """The same network on unscaled values: both scalings go into the outer layers."""
    folded = list(layers)
    weights, bias = folded[0]
    scaled = weights / inputs.deviation
    folded[0] = (scaled, bias - scaled @ inputs.mean)
    weights, bias = folded[-1]
    folded[-1] = (
        weights * outputs.deviation[:, None],
        bias * outputs.deviation + outputs.mean,
    )
    return folded


def add_layers(graph: Graph, source: int, layers: Sequence[Layer], activation: Activation) -> int:
    """Append the layers to a graph; returns the last tensor."""
    tensor = source
    for index, (weights, bias) in enumerate(layers):
        tensor = graph.fully_connected(tensor, weights, bias)
        if index < len(layers) - 1:
            tensor = graph.activation(tensor, activation)
    return tensor
