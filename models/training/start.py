"""Where a deep sigmoid network begins: this decides whether it learns at all.

A sigmoid has mean 1/2 and slope 1/4. With Glorot's weights, meant for tanh, every layer passes on
about a quarter of what differs between samples, and after eight of them all inputs look alike: the
network answers the mean for a thousand epochs. Four times as wide, and with a bias that takes
away the mean of the layer before, what goes in comes out.
"""

from __future__ import annotations

from collections.abc import Sequence
from itertools import pairwise
from typing import Literal

import numpy as np

from deltactl.models.robot import FloatArray

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
