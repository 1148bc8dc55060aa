"""Scalar products of whitened columns, which hundreds of sets of regressors share."""

from __future__ import annotations

import itertools

import numpy as np

from deltactl.diagnosis.observations.readings import FloatArray, IntArray

Block = tuple[str, FloatArray]
"""A regressor and its whitened columns (m, k), each times its prior spread."""


class Products:
    """Gram matrices of sets of blocks; a block is known by its identity."""

    def __init__(self) -> None:
        self._places: dict[str, tuple[Block, IntArray]] = {}
        self._gram: FloatArray = np.zeros((0, 0))
        """Scalar products of the columns of all blocks in `_places`."""
        self._pairs: dict[tuple[str, str], tuple[Block, Block, FloatArray]] = {}

    def of(self, blocks: list[Block]) -> FloatArray:
        """Scalar products (p, p) of all columns, a copy."""
        gram = self._known(blocks)
        return self._by_pairs(blocks) if gram is None else gram

    def _known(self, blocks: list[Block]) -> FloatArray | None:
        """Out of one matrix of blocks that are the same at every point; None where one of them has
        changed.
        """
        spans = []
        for block in blocks:
            if block[0] not in self._places:
                self._enter(block)
            kept, span = self._places[block[0]]
            if kept is not block:
                return None
            spans.append(span)
        at = np.concatenate([np.zeros(0, dtype=np.intp), *spans])
        return self._gram[np.ix_(at, at)]

    def _enter(self, block: Block) -> None:
        first, end = len(self._gram), len(self._gram) + block[1].shape[1]
        grown = np.empty((end, end))
        grown[:first, :first] = self._gram
        span = np.arange(first, end)
        self._places[block[0]] = block, span
        for other, there in self._places.values():
            product = block[1].T @ other[1]
            grown[np.ix_(span, there)] = product
            grown[np.ix_(there, span)] = product.T
        self._gram = grown

    def _by_pairs(self, blocks: list[Block]) -> FloatArray:
        """Pair by pair, where one of the blocks differs from point to point."""
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
