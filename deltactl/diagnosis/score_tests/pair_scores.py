"""Which two effects would explain most together.

Two causes may each look like a third one: a wrong ratio beside yielding joints looks like a turned
frame first and a wrong arm next. Adding the best one by one walks into that; all pairs at once,
linearised, cost no prediction.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator
from dataclasses import dataclass
from itertools import combinations

import numpy as np

from deltactl.diagnosis.observations.readings import FloatArray, IntArray
from deltactl.diagnosis.plants.candidate import Candidate, Term
from deltactl.diagnosis.score_tests.library import Entry
from deltactl.diagnosis.score_tests.score_test import Scorer, Scores, diagonals, gain_of


@dataclass(frozen=True, slots=True, eq=False)
class Pair:
    """Two starts for a refit, and what both together gain beyond their penalties."""

    starts: tuple[Term, Term]
    value: float


def best_pairs(
    scorer: Scorer,
    basis: FloatArray,
    residual: FloatArray,
    entries: list[int],
    penalty: Callable[[Candidate], float],
    most: int,
) -> list[Pair]:
    """The best pairs of library entries against a solution's basis (m, p) and residual (m,)."""
    shared, along = scorer.project(basis, residual)
    information = scorer.gram - shared @ shared.T
    of = scorer.library.entries
    penalties = {number: penalty(candidate_of(of[number])) for number in entries}
    ranked: list[tuple[float, int, int, FloatArray]] = []
    for columns, pairs in _alike(scorer, entries):
        square = columns[:, :, None], columns[:, None, :]
        step, gain, _ = gain_of(information[square], along[columns], diagonals(scorer.gram[square]))
        values = gain - np.array([penalties[one] + penalties[two] for one, two in pairs])
        ranked += [(-v, *pair, s) for v, pair, s in zip(values, pairs, step, strict=True)]
    found: list[Pair] = []
    for value, one, two, step in sorted(ranked, key=lambda item: item[:3]):
        if len(found) == most:
            break
        starts = start_of(of[one], step[: of[one].df]), start_of(of[two], step[of[one].df :])
        if starts[0] is not None and starts[1] is not None:
            found.append(Pair((starts[0], starts[1]), -value))
    return found


def _alike(scorer: Scorer, entries: list[int]) -> Iterator[tuple[IntArray, list[tuple[int, int]]]]:
    """All pairs with as many columns: these, (pairs, k), and the pairs."""
    groups: dict[int, list[tuple[int, int]]] = {}
    columns = {number: list(scorer.library.entries[number].numbers) for number in entries}
    for one, two in combinations(entries, 2):
        groups.setdefault(len(columns[one]) + len(columns[two]), []).append((one, two))
    for pairs in groups.values():
        yield np.array([columns[one] + columns[two] for one, two in pairs]), pairs


def leading(scorer: Scorer, scores: Scores, taken: set[tuple[str, ...]]) -> list[int]:
    """The best entry of every candidate that is not taken."""
    best: dict[tuple[str, ...], int] = {}
    for number, entry in enumerate(scorer.library.entries):
        if entry.candidate is None or entry.candidate.members or entry.key in taken:
            continue
        if entry.key not in best or scores.gain[number] > scores.gain[best[entry.key]]:
            best[entry.key] = number
    return list(best.values())


def candidate_of(entry: Entry) -> Candidate:
    """The candidate of an entry that is no spline term."""
    assert entry.candidate is not None
    return entry.candidate


def start_of(entry: Entry, step: FloatArray) -> Term | None:
    """Where a linear step leads; None for a size outside its bounds (a negative width)."""
    assert entry.shape is not None
    if not entry.shape.linear and step[0] <= 0.0:
        return None
    at = np.array(entry.shape.origin)
    for i, moved in zip(entry.shape.linear, step, strict=False):
        at[i] += moved
    start = Term(candidate_of(entry), at).moved_to(at)
    if entry.shape.linear and not np.allclose(start.at, at, rtol=0.2, atol=1e-12):
        return None
    return start
