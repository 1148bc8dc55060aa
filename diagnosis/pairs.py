"""Which two effects would explain most together.

Two causes may each look like a third one: a wrong ratio beside yielding joints looks like a turned
frame first and a wrong arm next. Adding the best one by one walks into that; all pairs at once,
linearised, cost no prediction.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from itertools import combinations

import numpy as np

from diagnosis.bank import Entry
from diagnosis.candidate import Candidate, Term
from diagnosis.readings import FloatArray
from diagnosis.score import Scorer, Scores, gain_of


@dataclass(frozen=True, slots=True, eq=False)
class Pair:
    """Two starts for a refit, and what both together gain beyond their prices."""

    starts: tuple[Term, Term]
    value: float


def best_pairs(
    scorer: Scorer,
    tangent: FloatArray,
    residual: FloatArray,
    entries: list[int],
    price: Callable[[Candidate], float],
    most: int,
) -> list[Pair]:
    """The best pairs of bank entries against a solution's tangent (m, p) and residual (m,)."""
    shared, along = scorer.project(tangent, residual)
    diagonal = np.diag(scorer.gram)
    found: list[Pair] = []
    for one, two in combinations(entries, 2):
        first, second = scorer.bank.entries[one], scorer.bank.entries[two]
        columns = np.r_[first.columns, second.columns]
        information = scorer.gram[np.ix_(columns, columns)] - shared[columns] @ shared[columns].T
        step, gain, _ = gain_of(information, along[columns], diagonal[columns])
        assert first.candidate is not None
        assert second.candidate is not None
        value = gain - price(first.candidate) - price(second.candidate)
        if len(found) == most and value <= found[-1].value:
            continue
        starts = start_of(first, step[: first.df]), start_of(second, step[first.df :])
        if starts[0] is None or starts[1] is None:
            continue
        found = sorted([*found, Pair((starts[0], starts[1]), value)], key=lambda p: -p.value)[:most]
    return found


def leading(scorer: Scorer, scores: Scores, taken: set[tuple[str, ...]]) -> list[int]:
    """The best entry of every candidate that is not taken."""
    best: dict[tuple[str, ...], int] = {}
    for number, entry in enumerate(scorer.bank.entries):
        if entry.candidate is None or entry.candidate.members or entry.key in taken:
            continue
        if entry.key not in best or scores.gain[number] > scores.gain[best[entry.key]]:
            best[entry.key] = number
    return list(best.values())


def start_of(entry: Entry, step: FloatArray) -> Term | None:
    """Where a linear step leads; None for a size outside its bounds (a negative width)."""
    assert entry.candidate is not None
    assert entry.shape is not None
    if not entry.shape.linear and step[0] <= 0.0:
        return None
    at = np.array(entry.shape.origin)
    for i, moved in zip(entry.shape.linear, step, strict=False):
        at[i] += moved
    start = Term(entry.candidate, at).moved_to(at)
    if entry.shape.linear and not np.allclose(start.at, at, rtol=0.2, atol=1e-12):
        return None
    return start
