"""Robust whitened least squares over the coordinates of several effects at once."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from functools import cached_property, partial
from typing import TypeVar

import numpy as np
from scipy.sparse import csr_array

from deltactl.diagnosis.estimation.budget import Budget
from deltactl.diagnosis.estimation.change_point_search import better_moment
from deltactl.diagnosis.estimation.change_point_timing import aligned
from deltactl.diagnosis.estimation.estimate import Point, Solution, orthonormal, without
from deltactl.diagnosis.estimation.levenberg_marquardt import Slopes, moved_by
from deltactl.diagnosis.estimation.noise import Whitener
from deltactl.diagnosis.estimation.options import ESTIMATION
from deltactl.diagnosis.estimation.splines import SplineTerm
from deltactl.diagnosis.observations.readings import FloatArray, IntArray
from deltactl.diagnosis.plants.candidate import Term
from deltactl.diagnosis.plants.contract import Model
from deltactl.diagnosis.plants.nuisance import Nuisance, given_back
from deltactl.models.effects import VOCABULARY

Made = TypeVar("Made")


class Fitter:
    """Fits terms to the readings of one model under one noise model."""

    def __init__(
        self,
        model: Model,
        whitener: Whitener,
        nuisances: Sequence[Nuisance],
        budget: Budget | None = None,
    ):
        self.model = model
        self.budget = budget or Budget()
        self.whiten = whitener
        self.nuisances = tuple(nuisances)
        self.observed = np.nan_to_num(model.readings.values)
        self._centre = _moved_values([n.term for n in nuisances])
        self.spread = np.array([x for n in nuisances for x in n.spread])
        self._sums = _sums(nuisances)
        self._kept: dict[tuple[int, int], FloatArray] = {}
        self._known_frees: dict[tuple[SplineTerm, ...], tuple[FloatArray, FloatArray]] = {}

    @property
    def rows(self) -> int:
        """Whitened readings; the rows of the priors come after them."""
        return len(self.whiten.weight)

    @property
    def blocks(self) -> IntArray:
        """Number (m,) of the block of time that each whitened reading lies in; sums over one are
        independent of the next, whatever the noise.
        """
        t_s, period_s = self.model.readings.t_s[self.whiten.rows], self.model.readings.period_s
        length_s = max(ESTIMATION.block_s, ESTIMATION.fewest_in_block * period_s)
        return np.asarray((t_s - t_s.min()) / length_s, dtype=np.intp)

    @property
    def _priors(self) -> int:
        """Rows of the priors: of each moved coordinate, then of each sum that is known better."""
        return len(self._centre) + len(self._sums)

    @cached_property
    def inputs(self) -> dict[str, csr_array]:
        """From values (n) at each location to what is new in the readings, (m, n)."""
        return {name: self.whiten.at_input(change) for name, change in self.model.inputs().items()}

    def vector(self, difference: FloatArray) -> FloatArray:
        """Whitened difference of the channels, with room for the priors of the nuisances."""
        white = self.whiten(difference)
        room = np.zeros((self._priors, *white.shape[1:]))
        return np.concatenate([white, room])

    def predict(self, terms: Sequence[Term]) -> FloatArray:
        """Channels (n, channels) with the terms at work."""
        self.budget.spend()
        return self.model.predict(terms)

    def change_by(self, solution: Solution, number: int, whole: FloatArray) -> FloatArray:
        """What term `number` adds to the channels, (n, channels); whole: predicted with all terms.

        Predictions for the answer, beyond the budget of the search.
        """
        rest = without(solution.terms, number)
        return whole - self.model.predict([*solution.nuisances, *rest])

    def in_noise(self, change: FloatArray) -> FloatArray:
        """A change of the channels (n, channels) in standard deviations of their noise."""
        scaled: FloatArray = change / np.array([noise.spread for noise in self.whiten.channels])
        return scaled

    def _residual(self, predicted: FloatArray, nuisances: Sequence[Term]) -> FloatArray:
        residual = self.vector(self.observed - predicted)
        away, last = self._centre - _moved_values(nuisances), self.rows + len(self._centre)
        residual[self.rows : last] = away / self.spread
        residual[last:] = self._sums @ away
        return residual

    def tangent(
        self,
        terms: Sequence[Term],
        nuisances: Sequence[Term],
        predicted: FloatArray,
        known: FloatArray | None = None,
    ) -> FloatArray:
        """Whitened derivatives of the prediction by every moved coordinate, (m, p).

        known: the first of them, where they are near enough (m, k).
        """
        everything = [*nuisances, *terms]
        columns: list[FloatArray] = [] if known is None else list(known.T)
        places = [(k, i) for k, term in enumerate(everything) for i in term.candidate.moved]
        # Build tolerances are linear, whatever else is fitted beside them.
        small = range(len(self.model.nuisances), len(nuisances))
        fresh = [place for place in places[len(columns) :] if place not in self._kept]
        tasks = [partial(self._column, everything, number, i, predicted) for number, i in fresh]
        many = len(tasks) >= ESTIMATION.many_columns
        with self.budget.not_counted():
            worked = self.side_by_side(tasks) if many else [task() for task in tasks]
        self.budget.spend(sum(number not in small for number, _ in places[len(columns) :]))
        new = dict(zip(fresh, worked, strict=True))
        for number, i in places[len(columns) :]:
            if (number, i) in self._kept:
                columns.append(self._kept[number, i])
                continue
            column = new[number, i]
            if number < len(nuisances):
                place = len(columns)
                column[self.rows + place] = 1.0 / self.spread[place]
                column[self.rows + len(self._centre) :] = self._sums[:, place]
            columns.append(column)
            if number in small:
                self._kept[number, i] = column
        return np.stack(columns).T if columns else np.zeros((self.rows + self._priors, 0))

    def _column(
        self, terms: Sequence[Term], number: int, i: int, predicted: FloatArray
    ) -> FloatArray:
        """The same derivative as `_slope`, whitened, (m,)."""
        return self.vector(self._slope(terms, number, i, predicted))

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
        return (self.predict(moved) - predicted) / step

    def free_tangent(self, frees: Sequence[SplineTerm]) -> FloatArray:
        """Whitened columns of spline terms, (m, q)."""
        inputs = self.model.inputs() if frees else {}
        blocks = [self.vector(free.columns(inputs[free.location])) for free in frees]
        rows = self.rows + self._priors
        return np.concatenate(blocks, axis=1) if blocks else np.zeros((rows, 0))

    def _linear(self, frees: tuple[SplineTerm, ...]) -> tuple[FloatArray, FloatArray]:
        """Whitened columns of spline terms, (m, q), and an orthonormal basis; the last are kept."""
        if frees not in self._known_frees:
            self._known_frees = {key: kept for key, kept in self._known_frees.items() if not key}
            linear = self.free_tangent(frees)
            self._known_frees[frees] = linear, orthonormal(linear)
        return self._known_frees[frees]

    def solve(
        self,
        terms: Sequence[Term],
        frees: Sequence[SplineTerm] = (),
        nuisances: Sequence[Term] | None = None,
        steps: int = ESTIMATION.fit_steps,
        known: FloatArray | None = None,
    ) -> Solution:
        """Levenberg-Marquardt from the given terms; spline terms are linear.

        known: derivatives by the first coordinates (m, k) that need not be worked out again; in
        a fit that is brought to its end only for the first step.
        """
        nuisances = tuple(n.term for n in self.nuisances) if nuisances is None else tuple(nuisances)
        nuisances, terms = given_back(self.model.nuisances, nuisances, tuple(terms))
        linear, basis = self._linear(tuple(frees))
        start = self._point(nuisances, aligned(terms), basis)
        found = self._descended(start, basis, steps, known)
        if steps >= ESTIMATION.retimed:
            found = self._with_better_moments(found, basis, steps)
        return self._finish(found, tuple(frees), linear)

    def _point(self, nuisances: Sequence[Term], terms: Sequence[Term], basis: FloatArray) -> Point:
        predicted = self.predict([*nuisances, *terms])
        residual = self._residual(predicted, nuisances)
        taken = basis.T @ residual
        cost = float(residual @ residual - taken @ taken)
        return Point(tuple(nuisances), tuple(terms), predicted, residual, taken, cost)

    def _descended(
        self, at: Point, basis: FloatArray, steps: int, known: FloatArray | None
    ) -> Point:
        if not any(term.candidate.moved for term in at.everything):
            return at
        damping, slopes, fresh = 1e-6, None, True
        for _ in range(steps):
            if slopes is None:
                tangent = self.tangent(at.terms, at.nuisances, at.predicted, known)
                columns = tangent.shape[1]
                self.budget.spend(columns * (columns + basis.shape[1]) / ESTIMATION.products)
                slopes, fresh = Slopes(tangent, basis), known is None
                known = known if steps < ESTIMATION.retimed else None
            step, promised = slopes.bounded_step(at.everything, at.residual, at.taken, damping)
            moved = moved_by(at.everything, step)
            count = len(at.nuisances)
            trial = self._point(moved[:count], aligned(moved[count:]), basis)
            gain = at.cost - trial.cost
            if gain > 0.0:
                at = trial
                damping, fresh = max(damping / 10, 1e-9), False
                if gain < ESTIMATION.close_enough:
                    break
                straight = abs(gain - promised) < ESTIMATION.straight * promised
                slopes = slopes if straight or gain < ESTIMATION.little_gain else None
            elif not fresh:
                slopes = None
            else:
                damping = max(damping, 1e-4) * 30
                if damping > 1e3:
                    break
        return at

    def _with_better_moments(self, at: Point, basis: FloatArray, steps: int) -> Point:
        """Events where they fit better, and all else fitted anew where that is much better."""
        while (better := self._retimed(at, basis)) is not None:
            if at.cost - better.cost < ESTIMATION.little_gain:
                return better
            at = self._descended(better, basis, steps, None)
        return at

    def _retimed(self, at: Point, basis: FloatArray) -> Point | None:
        """The same with one event a few readings earlier or later, where that fits better."""
        best, least = None, at.cost - ESTIMATION.close_enough
        for number in range(len(at.terms)):
            moved = better_moment(
                self.model.readings, self.predict, self.vector, at, number, basis, least
            )
            there = at if moved is None else self._point(at.nuisances, moved, basis)
            if there.cost < least:
                best, least = there, there.cost
        return best

    def _finish(self, at: Point, frees: tuple[SplineTerm, ...], linear: FloatArray) -> Solution:
        slopes = partial(self._slopes, at, frees)
        coefficients, residual, predicted = np.zeros(linear.shape[1]), at.residual, at.predicted
        if linear.shape[1]:
            coefficients = np.linalg.lstsq(linear, residual, rcond=1e-9)[0]
            residual = residual - linear @ coefficients
            inputs, first = self.model.inputs(), 0
            for free in frees:
                part = coefficients[first : first + free.size]
                predicted = predicted + inputs[free.location] * (free.basis @ part)[:, None]
                first += free.size
        cost = float(residual @ residual)
        return Solution(
            at.terms, at.nuisances, frees, coefficients, cost, residual, predicted, slopes
        )

    def _slopes(self, at: Point, frees: tuple[SplineTerm, ...]) -> FloatArray:
        with self.budget.not_counted():
            own = self.tangent(at.terms, at.nuisances, at.predicted)
        # One column after another, as whoever leaves some of them out copies them.
        return np.concatenate([own.T, self._linear(frees)[0].T]).T

    def side_by_side(
        self, tasks: Sequence[Callable[[], Made]], frees: Sequence[SplineTerm] = ()
    ) -> list[Made]:
        """What tasks return that hold solutions of this fitter, side by side if there is room.

        frees: spline terms in them that it has not fitted yet.
        """
        shapes = [*frees, *(free for known in self._known_frees for free in known)]
        model = self.model
        terms = [n.term for n in (*self.nuisances, *model.nuisances, *model.tolerances)]
        candidates = [*model.candidates, *model.groups, *(term.candidate for term in terms)]
        kinds = [*VOCABULARY.values(), *(one.kind for one in candidates)]
        known = [self, *terms, *candidates, *kinds, *shapes]
        return self.budget.side_by_side(tasks, known)


def _moved_values(terms: Sequence[Term]) -> FloatArray:
    return np.array([t.at[i] for t in terms for i in t.candidate.moved], dtype=np.float64)


def _sums(nuisances: Sequence[Nuisance]) -> FloatArray:
    """Rows that weigh sums of coordinates, (sums, coordinates)."""
    counts = [len(n.term.candidate.moved) for n in nuisances]
    first = np.concatenate([[0], np.cumsum(counts)]).astype(int)
    rows = np.zeros((sum(n.together is not None for n in nuisances), first[-1]))
    known = (k for k, n in enumerate(nuisances) if n.together is not None)
    for row, k in zip(rows, known, strict=True):
        row[first[k] : first[k + 1]] = 1.0 / (nuisances[k].together or 1.0)
    return rows
