"""Scalar products of whitened columns, which hundreds of sets of regressors share."""

from __future__ import annotations

import itertools
from collections.abc import Sequence

import numpy as np

from deltactl.diagnosis.observations.readings import FloatArray

Block = tuple[str, FloatArray]
"""A regressor and its whitened columns (m, k), each times its prior spread."""


class Products:
    """Gram matrices of sets of blocks; a block is known by its identity."""

    def __init__(self) -> None:
        self._pairs: dict[tuple[str, str], tuple[Block, Block, FloatArray]] = {}

    def of(self, blocks: list[Block]) -> FloatArray:
        """Scalar products (p, p) of all columns."""
        ends = np.cumsum([0, *(block[1].shape[1] for block in blocks)])
        gram = np.zeros((ends[-1], ends[-1]))
        spans = [slice(first, end) for first, end in itertools.pairwise(ends)]
        for number, (block, span) in enumerate(zip(blocks, spans, strict=True)):
            for other, beside in zip(blocks[: number + 1], spans, strict=False):
                product = self._pair(block, other)
                gram[span, beside] = product
                gram[beside, span] = product.T
        return gram

    def _pair(self, one: Block, other: Block) -> FloatArray:
        place = one[0], other[0]
        kept = self._pairs.get(place)
        if kept is None or kept[0] is not one or kept[1] is not other:
            kept = (one, other, one[1].T @ other[1])
            self._pairs[place] = kept
        return kept[2]


class Target:
    """A whitened model error (m,), and what blocks have in common with it."""

    def __init__(self, base: FloatArray, white: FloatArray):
        self.base, self.white, self.power = base, white, float(white @ white)
        self._shares: dict[str, tuple[Block, FloatArray]] = {}

    def share(self, blocks: list[Block]) -> FloatArray:
        """Scalar products (p,) of all columns with it."""
        return np.concatenate([np.zeros(0), *(self._share(block) for block in blocks)])

    def _share(self, block: Block) -> FloatArray:
        kept = self._shares.get(block[0])
        if kept is None or kept[0] is not block:
            kept = (block, block[1].T @ self.white)
            self._shares[block[0]] = kept
        return kept[1]


def left_of(target: FloatArray, shapes: Sequence[FloatArray], theta: FloatArray) -> FloatArray:
    """What linear sizes (p,) of the first shapes leave of a whitened model error, (m,)."""
    left, first = target.copy(), 0
    for shape in shapes:
        if first == len(theta):
            break
        left -= shape @ theta[first : first + shape.shape[1]]
        first += shape.shape[1]
    return left
