"""Adam over many epochs, in stretches between which the caller may look and speak."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from typing import Any

import numpy as np

from deltactl.foundation.extras import needs
from deltactl.models.robot import FloatArray

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
            one_seed = int(seeds.integers(2**31))
            steps = epochs(weights, shape, inputs, wanted, moments, part, batch, steps, one_seed)
            yield begin + len(part), weights.astype(np.float64)

    return stretches


def _kernel() -> Any:
    with needs("training", "training this network"):
        from deltactl.models.training.adam_kernel import epochs
    return epochs
