"""All sizes of a set of effects together, by damped Gauss-Newton steps to the end."""

from __future__ import annotations

from collections.abc import Sequence

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
) -> list[Term]:
    """Terms at their best sizes; free: whitened columns (m, p) in spreads, always fitted too."""
    taken, terms = Absorbed(free), list(terms)
    if not terms:
        return terms
    predicted = around.with_terms(terms)
    cost, left, share = _cost(observed, predicted, noise, taken)
    damping = 1e-4
    for _ in range(DELTA_FITS.most_steps):
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
            return terms
        gained, terms, predicted = cost - tried[0], moved, there
        cost, left, share = tried
        damping /= 10.0
        if gained < DELTA_FITS.little:
            break
    return terms


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
