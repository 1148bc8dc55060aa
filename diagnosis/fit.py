"""Robust whitened least squares over the coordinates of several effects at once."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from functools import cached_property

import numpy as np

from diagnosis.candidate import Term
from diagnosis.event_times import aligned, shown_later
from diagnosis.free_shapes import FreeShape
from diagnosis.model import Model
from diagnosis.noise import Whitener
from diagnosis.nuisance import Nuisance
from diagnosis.orthonormal import orthonormal
from diagnosis.readings import FloatArray

STEPS = 6
CLOSE_ENOUGH = 0.02
"""A step that lowers the cost by less than this ends the fit."""
MOMENTS = (-6, -3, -1, 1, 3, 6)
"""Readings by which the moment of an event is moved, to see whether that fits better."""


@dataclass(frozen=True, eq=False)
class Solution:
    """Fitted terms. cost is a chi-square; residual (m,) is whitened."""

    terms: tuple[Term, ...]
    nuisances: tuple[Term, ...]
    frees: tuple[FreeShape, ...]
    coefficients: FloatArray
    cost: float
    residual: FloatArray
    predicted: FloatArray
    """Channels with everything fitted, (n, channels)."""
    slopes: Callable[[], FloatArray]
    """Works the tangent out."""

    @cached_property
    def tangent(self) -> FloatArray:
        """Whitened derivatives (m, p) by nuisances, moved coordinates of the terms, free shapes."""
        return self.slopes()

    @property
    def free_tangent(self) -> FloatArray:
        """The tangent without coordinates at an end of their range, which cannot give way."""
        stuck = [
            term.at[i] in (term.candidate.coordinates[i].low, term.candidate.coordinates[i].high)
            for term in (*self.nuisances, *self.terms)
            for i in term.candidate.moved
        ]
        keep = np.ones(self.tangent.shape[1], dtype=bool)
        keep[: len(stuck)] = ~np.array(stuck, dtype=bool)
        return self.tangent[:, keep]

    def columns_of(self, number: int) -> slice:
        """Columns of the tangent that belong to term `number`."""
        first = sum(len(t.candidate.moved) for t in self.nuisances)
        first += sum(len(t.candidate.moved) for t in self.terms[:number])
        return slice(first, first + len(self.terms[number].candidate.moved))


class Fitter:
    """Fits terms to the readings of one model under one noise model."""

    def __init__(self, model: Model, whitener: Whitener, nuisances: Sequence[Nuisance]):
        self.model = model
        self.whiten = whitener
        self.nuisances = tuple(nuisances)
        self.observed = np.nan_to_num(model.readings.values)
        self._centre = _moved_values([n.term for n in nuisances])
        self.spread = np.array([x for n in nuisances for x in n.spread])
        self._kept: dict[tuple[int, int], FloatArray] = {}

    @property
    def rows(self) -> int:
        """Whitened readings; the rows of the priors come after them."""
        return len(self.whiten.weight)

    def vector(self, difference: FloatArray) -> FloatArray:
        """Whitened difference of the channels, with room for the priors of the nuisances."""
        white = self.whiten(difference)
        room = np.zeros((len(self._centre), *white.shape[1:]))
        return np.concatenate([white, room])

    def _residual(self, predicted: FloatArray, nuisances: Sequence[Term]) -> FloatArray:
        residual = self.vector(self.observed - predicted)
        residual[self.rows :] = (self._centre - _moved_values(nuisances)) / self.spread
        return residual

    def tangent(
        self, terms: Sequence[Term], nuisances: Sequence[Term], predicted: FloatArray
    ) -> FloatArray:
        """Whitened derivatives of the prediction by every moved coordinate, (m, p)."""
        everything = [*nuisances, *terms]
        columns: list[FloatArray] = []
        for number, term in enumerate(everything):
            for i in term.candidate.moved:
                if (number, i) in self._kept:
                    columns.append(self._kept[number, i])
                    continue
                column = self.vector(self._slope(everything, number, i, predicted))
                if number < len(nuisances):
                    column[self.rows + len(columns)] = 1.0 / self.spread[len(columns)]
                columns.append(column)
                # Small errors of the build are linear, whatever else is fitted beside them.
                if len(self.model.nuisances) <= number < len(nuisances):
                    self._kept[number, i] = column
        rows = self.rows + len(self._centre)
        return np.stack(columns).T if columns else np.zeros((rows, 0))

    def _slope(
        self, terms: Sequence[Term], number: int, i: int, predicted: FloatArray
    ) -> FloatArray:
        """Derivative of the prediction by coordinate i of one term, (n, channels)."""
        term = terms[number]
        step = term.candidate.coordinates[i].step
        at = term.at.copy()
        if at[i] + step > term.candidate.coordinates[i].high:
            step = -step
        at[i] += step
        moved = [*terms[:number], Term(term.candidate, at), *terms[number + 1 :]]
        slope: FloatArray = (self.model.predict(moved) - predicted) / step
        return slope

    def free_tangent(self, frees: Sequence[FreeShape]) -> FloatArray:
        """Whitened columns of free shapes, (m, q)."""
        ports = self.model.ports() if frees else {}
        blocks = [self.vector(free.columns(ports[free.port])) for free in frees]
        rows = self.rows + len(self._centre)
        return np.concatenate(blocks, axis=1) if blocks else np.zeros((rows, 0))

    def solve(
        self,
        terms: Sequence[Term],
        frees: Sequence[FreeShape] = (),
        nuisances: Sequence[Term] | None = None,
        steps: int = STEPS,
    ) -> Solution:
        """Levenberg-Marquardt from the terms as they stand; free shapes are linear."""
        nuisances = tuple(n.term for n in self.nuisances) if nuisances is None else tuple(nuisances)
        nuisances, terms = given_back(self.model.nuisances, nuisances, tuple(terms))
        terms = aligned(terms)
        linear = self.free_tangent(frees)
        basis = orthonormal(linear)
        predicted = self.model.predict([*nuisances, *terms])
        residual = self._residual(predicted, nuisances)
        cost = _cost(residual, basis)
        damping = 1e-6
        tangent: FloatArray | None = None
        for _ in range(steps):
            if tangent is None:
                tangent = self.tangent(terms, nuisances, predicted)
            if tangent.shape[1] == 0:
                break
            jac = np.concatenate([tangent, linear], axis=1)
            everything = [*nuisances, *terms]
            move = _bounded_step(everything, jac, residual, damping)
            tried = _moved(everything, move)
            trial_n, trial_t = tried[: len(nuisances)], aligned(tried[len(nuisances) :])
            trial_predicted = self.model.predict([*trial_n, *trial_t])
            trial_residual = self._residual(trial_predicted, trial_n)
            trial_cost = _cost(trial_residual, basis)
            if trial_cost < cost:
                gain = cost - trial_cost
                nuisances, terms = tuple(trial_n), trial_t
                predicted, residual, cost = trial_predicted, trial_residual, trial_cost
                tangent = None
                damping = max(damping / 10, 1e-9)
                if gain < CLOSE_ENOUGH:
                    break
            else:
                damping = max(damping, 1e-4) * 30
                if damping > 1e3:
                    break
        retimed = self._retimed(terms, nuisances, basis, cost)
        if retimed is not None:
            return self.solve(retimed, frees, nuisances, steps)
        return self._finish(terms, nuisances, tuple(frees), linear, predicted, residual)

    def _retimed(
        self, terms: tuple[Term, ...], nuisances: Sequence[Term], basis: FloatArray, cost: float
    ) -> tuple[Term, ...] | None:
        """The terms with one event a few readings earlier or later, where that fits better."""
        best, least = None, cost - CLOSE_ENOUGH
        for number, term in enumerate(terms):
            for shift in MOMENTS:
                other = shown_later(term, shift * self.model.readings.period_s)
                if other is None:
                    break
                moved = aligned((*terms[:number], other, *terms[number + 1 :]))
                predicted = self.model.predict([*nuisances, *moved])
                other_cost = _cost(self._residual(predicted, nuisances), basis)
                if other_cost < least:
                    best, least = moved, other_cost
        return best

    def _finish(
        self,
        terms: tuple[Term, ...],
        nuisances: tuple[Term, ...],
        frees: tuple[FreeShape, ...],
        linear: FloatArray,
        predicted: FloatArray,
        residual: FloatArray,
    ) -> Solution:
        def slopes() -> FloatArray:
            return np.concatenate([self.tangent(terms, nuisances, driven), linear], axis=1)

        driven = predicted
        coefficients = np.zeros(linear.shape[1])
        if linear.shape[1]:
            coefficients = np.linalg.lstsq(linear, residual, rcond=1e-9)[0]
            residual = residual - linear @ coefficients
            ports, first = self.model.ports(), 0
            for free in frees:
                part = coefficients[first : first + free.size]
                predicted = predicted + ports[free.port] * (free.basis @ part)[:, None]
                first += free.size
        return Solution(
            terms, nuisances, frees, coefficients, float(residual @ residual), residual,
            predicted, slopes,
        )  # fmt: skip


def given_back(
    centres: Sequence[Nuisance], nuisances: tuple[Term, ...], terms: tuple[Term, ...]
) -> tuple[tuple[Term, ...], tuple[Term, ...]]:
    """Nuisances, then terms: what a nuisance took of an effect that is a term goes to the term.

    A delay between samples is interpolated, one of whole samples is not: the fit would not find
    its way back from a nuisance that is full to a term that could take all of it.
    """
    known = {nuisance.term.candidate.key: nuisance.term.at for nuisance in centres}
    taken = {n.candidate.key: n.at - known[n.candidate.key] for n in nuisances
             if n.candidate.key in known}  # fmt: skip
    shared = {term.candidate.key for term in terms} & set(taken)
    kept = tuple(
        n.moved_to(known[n.candidate.key]) if n.candidate.key in shared else n for n in nuisances
    )
    given = tuple(
        term.moved_to(term.at + taken[term.candidate.key]) if term.candidate.key in shared else term
        for term in terms
    )
    return kept, given


def _moved_values(terms: Sequence[Term]) -> FloatArray:
    return np.array([t.at[i] for t in terms for i in t.candidate.moved], dtype=np.float64)


def _cost(residual: FloatArray, basis: FloatArray) -> float:
    along = basis.T @ residual
    return float(residual @ residual - along @ along)


def _damped(gram: FloatArray, along: FloatArray, damping: float) -> FloatArray:
    """A damped step from the normal equations."""
    scale = np.sqrt(np.maximum(np.diag(gram), 1e-30))
    matrix = gram / np.outer(scale, scale) + damping * np.eye(len(gram))
    step: FloatArray = np.linalg.lstsq(matrix, along / scale, rcond=1e-10)[0] / scale
    return step


def _bounded_step(
    terms: Sequence[Term], jac: FloatArray, residual: FloatArray, damping: float
) -> FloatArray:
    """A damped step; coordinates that would leave their bounds stop there, the rest goes on."""
    room = [
        (term.candidate.coordinates[i].low - term.at[i],
         term.candidate.coordinates[i].high - term.at[i])
        for term in terms
        for i in term.candidate.moved
    ]  # fmt: skip
    low, high = np.array(room).T
    gram, along = jac.T @ jac, jac.T @ residual
    free = np.ones(jac.shape[1], dtype=bool)
    step = np.zeros(jac.shape[1])
    for _ in range(3):
        held = along[free] - gram[np.ix_(free, ~free)] @ step[~free]
        step[free] = _damped(gram[np.ix_(free, free)], held, damping)
        own = step[: len(low)]
        out = free[: len(low)] & ((own < low) | (own > high))
        if not out.any():
            break
        own[out] = np.clip(own[out], low[out], high[out])
        free[: len(low)] &= ~out
    return step[: len(low)]


def _moved(terms: Sequence[Term], move: FloatArray) -> list[Term]:
    result, first = [], 0
    for term in terms:
        moved = term.candidate.moved
        at = term.at.copy()
        at[moved] += move[first : first + len(moved)]
        first += len(moved)
        result.append(term.moved_to(at))
    return result
