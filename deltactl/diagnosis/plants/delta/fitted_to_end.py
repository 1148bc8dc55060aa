"""All sizes of a set of effects together, by damped Gauss-Newton steps to the end."""

from __future__ import annotations

from collections.abc import Mapping, Sequence

import numpy as np

from deltactl.diagnosis.observations.readings import FloatArray
from deltactl.diagnosis.plants.candidate import Term
from deltactl.diagnosis.plants.delta.beside_point import Absorbed
from deltactl.diagnosis.plants.delta.noise_of_channels import ChannelsNoise
from deltactl.diagnosis.plants.delta.options import DELTA_FITS
from deltactl.diagnosis.plants.delta.point import Around


def fitted_to_end(
    around: Around,
    observed: FloatArray,
    noise: ChannelsNoise,
    free: FloatArray,
    terms: Sequence[Term],
    others: Mapping[int, Sequence[FloatArray]],
) -> list[Term]:
    """Terms at their best sizes; free: whitened columns (m, p) in spreads, always fitted too.

    others: further places to start a term from, by its number: of an effect that is not linear a
    fit may end where none nearby is better.
    """
    taken = Absorbed(free)
    if not terms:
        return []

    def fitted(start: Sequence[Term], steps: int) -> tuple[list[Term], float]:
        return _descended(around, observed, noise, taken, list(start), steps)

    best, cost = fitted(terms, DELTA_FITS.most_steps)
    for number, places in others.items():
        for at in places:
            start = [*best]
            start[number] = best[number].moved_to(at)
            tried, less = fitted(start, DELTA_FITS.steps_beside)
            if less < cost - DELTA_FITS.little_beside:
                best, cost = fitted(tried, DELTA_FITS.most_steps)
    return best


def _descended(
    around: Around,
    observed: FloatArray,
    noise: ChannelsNoise,
    taken: Absorbed,
    terms: list[Term],
    steps: int,
) -> tuple[list[Term], float]:
    """Terms after so many steps, and their cost."""
    predicted = around.with_terms(terms)
    cost, left, share = _cost(observed, predicted, noise, taken)
    damping = 1e-4
    for _ in range(steps):
        white = noise.whiten(_slopes(around, terms, predicted))
        of_white = taken.share(white)
        gram = white.T @ white - of_white.T @ of_white
        along = white.T @ left - of_white.T @ share
        scale = np.diag(gram) + 1e-12
        for _ in range(5):
            step = np.linalg.solve(gram + damping * np.diag(scale), along)
            moved = _moved(terms, step)
            there = around.with_terms(moved)
            tried = _cost(observed, there, noise, taken)
            if tried[0] < cost:
                break
            damping = max(damping, 1e-4) * 10.0
        else:
            return terms, cost
        gained, terms, predicted = cost - tried[0], moved, there
        cost, left, share = tried
        damping /= 10.0
        if gained < DELTA_FITS.little:
            break
    return terms, cost


def _cost(
    observed: FloatArray, predicted: FloatArray, noise: ChannelsNoise, taken: Absorbed
) -> tuple[float, FloatArray, FloatArray]:
    left = noise.whiten(observed - predicted)
    share = taken.share(left)
    return float(left @ left - share @ share), left, share


def _slopes(around: Around, terms: Sequence[Term], predicted: FloatArray) -> FloatArray:
    """Derivatives (n c, k) by all moved coordinates."""
    columns = []
    for number, term in enumerate(terms):
        for i in term.candidate.moved:
            one, at = term.candidate.coordinates[i], term.at.copy()
            step = one.step if at[i] + one.step <= one.high else -one.step
            at[i] += step
            moved = [*terms[:number], Term(term.candidate, at), *terms[number + 1 :]]
            columns.append((around.with_terms(moved) - predicted) / step)
    return np.stack(columns, axis=1)


def _moved(terms: Sequence[Term], step: FloatArray) -> list[Term]:
    moved, first = [], 0
    for term in terms:
        own = term.candidate.moved
        at = term.at.copy()
        at[own] += step[first : first + len(own)]
        first += len(own)
        moved.append(term.moved_to(at))
    return moved
