"""Where each effect would fit best by itself, beside what is at work at a point.

An effect that is linear in its size needs no fit. For the others the cards have shapes to start
from: the one whose score is best begins a few Gauss-Newton steps in all moved coordinates, with
tolerances and the sizes of what is at work free.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence

import numpy as np
from scipy.linalg import cho_solve, solve_triangular

from deltactl.diagnosis.observations.readings import FloatArray
from deltactl.diagnosis.plants.candidate import Candidate, Term
from deltactl.diagnosis.plants.delta.noise_of_channels import ChannelsNoise
from deltactl.diagnosis.plants.delta.options import DELTA_FITS
from deltactl.diagnosis.plants.delta.point import Around, Near, is_straight, key_of, nothing
from deltactl.diagnosis.priors.size_priors import prior_of
from deltactl.models.effects.card import Shape


class Absorbed:
    """What free columns (m, p), each in its prior spread, take of anything."""

    def __init__(self, columns: FloatArray):
        self._columns = columns
        gram = columns.T @ columns + np.eye(columns.shape[1])
        self._root = np.linalg.cholesky(gram)

    def share(self, white: FloatArray) -> FloatArray:
        """In directions whose squares are what is taken, (p, ...)."""
        return self.root_of(self._columns.T @ white)

    def root_of(self, along: FloatArray) -> FloatArray:
        """The same of scalar products with the columns, (p, ...)."""
        found: FloatArray = solve_triangular(self._root, along, lower=True)
        return found

    def sizes(self, white: FloatArray) -> FloatArray:
        """Sizes of the columns, (p, ...)."""
        found: FloatArray = cho_solve((self._root, True), self._columns.T @ white)
        return found


class Starts:
    """Scores of all shapes of candidates, from columns around nothing."""

    def __init__(self, around: Around):
        self._columns: dict[str, list[tuple[Shape, FloatArray]]] = {}
        self._straight: dict[str, FloatArray] = {}
        self._around = around

    def _shapes(self, candidate: Candidate) -> list[tuple[Shape, FloatArray]]:
        key = key_of(candidate)
        if key not in self._columns:
            each = [(shape, _raw(self._around, candidate, shape)) for shape in candidate.shapes]
            self._columns[key] = [one for one in each if np.any(one[1])]
        return self._columns[key]

    def straight(self, candidate: Candidate) -> FloatArray:
        """Derivatives (n c, k) of a straight one: elsewhere they hardly differ, and once it is
        chosen they are made anew.
        """
        key = " ".join([key_of(candidate), *map(str, candidate.shapes[0].origin)])
        if key not in self._straight:
            slopes = _raw(self._around, candidate, candidate.shapes[0])
            self._straight[key] = slopes.astype(np.float64)
        return self._straight[key]

    def best(
        self, candidate: Candidate, noise: ChannelsNoise, left: FloatArray, taken: Absorbed
    ) -> list[tuple[float, FloatArray]]:
        """Gain and place (k,) of starts, the best first."""
        found = []
        of_left = taken.share(left)
        for shape, raw in self._shapes(candidate):
            white = noise.whiten(raw.astype(np.float64))
            share = taken.share(white)
            gram = white.T @ white - share.T @ share
            along = white.T @ left - share.T @ of_left
            size = np.linalg.lstsq(gram, along, rcond=1e-10)[0]
            at = np.array(shape.origin, dtype=np.float64)
            low = np.array([c.low for c in candidate.coordinates])
            high = np.array([c.high for c in candidate.coordinates])
            if shape.linear:
                at[list(shape.linear)] += size
                at = np.clip(at, low, high)
                size = at[list(shape.linear)] - np.array(shape.origin)[list(shape.linear)]
                gain = float(2.0 * size @ along - size @ gram @ size)
                if not np.any(size):
                    at[list(shape.linear)] = shape.reach
            else:
                gain = float(2.0 * along[0] - gram[0, 0])
            found.append((gain, at))
        return sorted(found, key=lambda one: -one[0])


def _raw(around: Around, candidate: Candidate, shape: Shape) -> FloatArray:
    """Change of the channels (n c, k) per unit of each linear coordinate, or by it all."""
    origin = np.array(shape.origin, dtype=np.float64)
    columns = []
    for i in shape.linear:
        at = origin.copy()
        at[i] += shape.reach
        columns.append((around.beside(Term(candidate, at)) - around.predicted) / shape.reach)
    if not shape.linear:
        columns.append(around.beside(Term(candidate, origin)) - around.predicted)
    single: FloatArray = np.stack(columns, axis=1).astype(np.float32)
    return single


class BesidePoint:
    """Best fits of single candidates beside a point, under one noise."""

    def __init__(
        self,
        around: Around,
        noise: ChannelsNoise,
        left: FloatArray,
        free: FloatArray,
        names: Sequence[str] = (),
    ):
        """left: (n c,) unexplained at the point. free: whitened columns (m, p), in spreads.

        names: of the first of them, which are tolerances.
        """
        self._around, self._noise, self._given = around, noise, (left, free, names)
        self._left, self._taken = noise.whiten(left), Absorbed(free)
        self._of_left = self._taken.share(self._left)

    def near(self, candidate: Candidate, starts: Starts, before: Mapping[str, Near]) -> Near:
        """The candidate where it fits best, in the place of its own tolerance."""
        if is_straight(candidate):
            return self._straight(candidate, starts)
        left, free, names = self._given
        other = [name != key_of(candidate) for name in names]
        if not all(other):
            kept = np.array([*other, *[True] * (free.shape[1] - len(other))])
            alone = BesidePoint(self._around, self._noise, left, free[:, kept])
            return alone.near(candidate, starts, before)
        ranked = starts.best(candidate, self._noise, self._left, self._taken)
        if not ranked:
            return _without_any(candidate, len(self._around.predicted))
        begins = [at for gain, at in ranked[: DELTA_FITS.starts_beside] if gain > DELTA_FITS.worth]
        known = before.get(key_of(candidate))
        if begins and known is not None and known.whole is not None:
            begins = [max(known.term.at, begins[0], key=lambda at: self._gain_at(candidate, at))]
        if not begins:
            return self._secant(Term(candidate, ranked[0][1]))
        fits = [self._fitted(Term(candidate, at)) for at in begins]
        return self._secant(max(fits, key=lambda fit: fit[0])[1])

    def _straight(self, candidate: Candidate, starts: Starts) -> Near:
        (shape,) = candidate.shapes
        slopes = starts.straight(candidate)
        white = self._noise.whiten(slopes)
        share = self._taken.share(white)
        gram = white.T @ white - share.T @ share
        along = white.T @ self._left - share.T @ self._of_left
        size = np.linalg.lstsq(gram, along, rcond=1e-10)[0]
        at = np.array(shape.origin, dtype=np.float64)
        at[list(shape.linear)] += size
        return Near(Term(candidate, at).moved_to(at), slopes, None)

    def _secant(self, term: Term) -> Near:
        term = _not_nothing(term)
        predicted = self._around.beside(term)
        slopes = self._around.slopes(term, predicted)
        return Near(term, slopes, predicted - self._around.predicted)

    def _gain_at(self, candidate: Candidate, at: FloatArray) -> float:
        return self._gain(self._around.beside(Term(candidate, at)) - self._around.predicted)

    def _gain(self, change: FloatArray) -> float:
        white = self._noise.whiten(change)
        left, share = self._left - white, self._of_left - self._taken.share(white)
        return float(self._left @ self._left - self._of_left @ self._of_left) - float(
            left @ left - share @ share
        )

    def _fitted(self, term: Term) -> tuple[float, Term]:
        """A few damped Gauss-Newton steps."""
        predicted = self._around.beside(term)
        gain = self._gain(predicted - self._around.predicted)
        damping = 1e-3
        for _ in range(DELTA_FITS.steps_beside):
            white = self._noise.whiten(self._around.slopes(term, predicted))
            rest = self._noise.whiten(predicted - self._around.predicted)
            share = self._taken.share(white)
            gram = white.T @ white - share.T @ share
            along = white.T @ (self._left - rest) - share.T @ (
                self._of_left - self._taken.share(rest)
            )
            scale = np.diag(gram) + 1e-12
            for _ in range(3):
                step = np.linalg.solve(gram + damping * np.diag(scale), along)
                at = term.at.copy()
                at[term.candidate.moved] += step
                moved = term.moved_to(at)
                there = self._around.beside(moved)
                better = self._gain(there - self._around.predicted)
                if better > gain:
                    break
                damping *= 10.0
            else:
                return gain, term
            gained, gain, term, predicted = better - gain, better, moved, there
            damping /= 10.0
            if gained < DELTA_FITS.little_beside:
                break
        return gain, term


def _not_nothing(term: Term) -> Term:
    """The term with a small size instead of none, of which no direction would show."""
    candidate, prior = term.candidate, prior_of(term.candidate)
    least = DELTA_FITS.least_size * prior.typical
    sizes = [candidate.moved[number] for number in prior.sizes]
    if not sizes or np.linalg.norm((term.at - nothing(candidate))[sizes]) >= least:
        return term
    at = term.at.copy()
    at[sizes[0]] += least
    return term.moved_to(at)


def _without_any(candidate: Candidate, rows: int) -> Near:
    """A candidate of which nothing shows."""
    at = np.array(candidate.shapes[0].origin, dtype=np.float64)
    return Near(Term(candidate, at), np.zeros((rows, len(candidate.moved))), None)
