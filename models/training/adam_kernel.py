"""Backpropagation and Adam for a sigmoid network, compiled: a whole epoch without Python.

At 32 samples a step a network of 8 x 50 is so small that what a library spends between its
operations is most of the time. Here a step is 24 small matrix products and three loops, in float32,
on one core: figures in docs/decisions/networks.md.
"""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import numpy as np
from numba import njit

Float32Array = np.ndarray[Any, np.dtype[np.float32]]
IntArray = np.ndarray[Any, np.dtype[np.int64]]

compiled = njit(fastmath=True, error_model="numpy", boundscheck=False, cache=True)

BETA_1, BETA_2, EPSILON = 0.9, 0.999, 1e-7
"""Kingma and Ba 2014, with the epsilon of Keras."""

_f = np.float32
# tanh on [-7.9, 7.9] as a ratio of polynomials, to a few units in the last place of float32
# (the coefficients of Eigen, src/Core/MathFunctionsImpl.h); unlike exp() it is vectorised.
_END = _f(7.90531110763549805)
_A1, _A3, _A5, _A7 = (
    _f(4.89352455891786e-3),
    _f(6.37261928875436e-4),
    _f(1.48572235717979e-5),
    _f(5.12229709037114e-8),
)
_A9, _A11, _A13 = _f(-8.60467152213735e-11), _f(2.00018790482477e-13), _f(-2.76076847742355e-16)
_B0, _B2, _B4, _B6 = (
    _f(4.89352518554385e-3),
    _f(2.26843463243900e-3),
    _f(1.18534705686654e-4),
    _f(1.19825839466702e-6),
)
_ONE, _HALF = _f(1.0), _f(0.5)


def _bend(values: Float32Array) -> None:
    """Sigmoid of every element, in place: (1 + tanh(x / 2)) / 2."""
    for row in range(values.shape[0]):
        for column in range(values.shape[1]):
            x = min(max(values[row, column] * _HALF, -_END), _END)
            s = x * x
            above = _A13 * s + _A11
            above = above * s + _A9
            above = above * s + _A7
            above = above * s + _A5
            above = above * s + _A3
            above = above * s + _A1
            below = ((_B6 * s + _B4) * s + _B2) * s + _B0
            values[row, column] = _HALF + _HALF * x * above / below


def _forward(weights: Float32Array, sizes: IntArray, outputs: Float32Array) -> None:
    """Outputs (layers + 1, widest, batch) of every layer, from row 0 that holds the inputs."""
    at, last = 0, len(sizes) - 2
    for layer in range(last + 1):
        before, after = sizes[layer], sizes[layer + 1]
        matrix = weights[at : at + before * after].reshape(after, before)
        bias = weights[at + before * after : at + (before + 1) * after]
        np.dot(matrix, outputs[layer][:before], outputs[layer + 1][:after])
        for row in range(after):
            for column in range(outputs.shape[2]):
                outputs[layer + 1, row, column] += bias[row]
        if layer < last:
            bend(outputs[layer + 1][:after])
        at += (before + 1) * after


def _backward(
    weights: Float32Array,
    sizes: IntArray,
    outputs: Float32Array,
    error: Float32Array,
    slope: Float32Array,
) -> None:
    """Slope of half the summed square of `error` by every weight; `error` is (2, widest, batch).

    Half 0 holds the error of the last layer at first; the halves take turns after that.
    """
    at = weights.size
    for step, layer in enumerate(range(len(sizes) - 2, -1, -1)):
        before, after = sizes[layer], sizes[layer + 1]
        at -= (before + 1) * after
        here, below = error[step % 2], error[(step + 1) % 2]
        inputs = outputs[layer][:before]
        gradient = slope[at : at + before * after].reshape(after, before)
        np.dot(here[:after], inputs.T, gradient)
        for row in range(after):
            total = _f(0.0)
            for column in range(outputs.shape[2]):
                total += here[row, column]
            slope[at + before * after + row] = total
        if layer:
            matrix = weights[at : at + before * after].reshape(after, before)
            np.dot(matrix.T, here[:after], below[:before])
            for row in range(before):
                for column in range(outputs.shape[2]):
                    value = inputs[row, column]
                    below[row, column] *= value * (_ONE - value)


def _adam(
    weights: Float32Array,
    slope: Float32Array,
    first: Float32Array,
    second: Float32Array,
    rate: float,
    step: int,
) -> None:
    """One step of Adam; `first` and `second` are its running moments, `step` counts from 1."""
    root = np.sqrt(1.0 - BETA_2**step)
    size, least = _f(rate * root / (1.0 - BETA_1**step)), _f(EPSILON * root)
    b1, b2 = _f(BETA_1), _f(BETA_2)
    for index in range(weights.size):
        g = slope[index]
        m = b1 * first[index] + (_ONE - b1) * g
        v = b2 * second[index] + (_ONE - b2) * g * g
        first[index], second[index] = m, v
        weights[index] -= size * m / (np.sqrt(v) + least)


def _epochs(
    weights: Float32Array,
    sizes: IntArray,
    samples: tuple[Float32Array, Float32Array],
    moments: Float32Array,
    rates: Float32Array,
    batch: int,
    begun: tuple[int, int],
) -> int:
    """Train in place for `len(rates)` epochs; returns the steps taken in all.

    samples: inputs (n, k) and wanted (n, m). moments (2, weights). begun: steps before, and what
    seeds the orders. Every epoch is a new random order; the
    last batch is filled up from the order's beginning.
    """
    inputs, wanted = samples
    done, seed = begun
    np.random.seed(seed)
    count = len(inputs)
    steps = (count + batch - 1) // batch
    widest = sizes.max()
    outputs = np.zeros((len(sizes), widest, batch), np.float32)
    error = np.zeros((2, widest, batch), np.float32)
    slope = np.zeros_like(weights)
    order = np.arange(count)
    share = _f(2.0 / (batch * wanted.shape[1]))
    for epoch in range(len(rates)):
        np.random.shuffle(order)
        for step in range(steps):
            for column in range(batch):
                row = order[(step * batch + column) % count]
                for k in range(inputs.shape[1]):
                    outputs[0, k, column] = inputs[row, k]
            forward(weights, sizes, outputs)
            for column in range(batch):
                row = order[(step * batch + column) % count]
                for k in range(wanted.shape[1]):
                    error[0, k, column] = share * (outputs[-1, k, column] - wanted[row, k])
            backward(weights, sizes, outputs, error, slope)
            done += 1
            adam(weights, slope, moments[0], moments[1], rates[epoch], done)
    return done


bend = compiled(_bend)
forward = compiled(_forward)
backward = compiled(_backward)
adam = compiled(_adam)
epochs: Callable[..., int] = compiled(_epochs)
