"""The run that tells tied explanations apart, designed with a Jacobian of all that is refitted."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from deltactl.diagnosis.evidence.autoregression import ChannelNoise, Whitener, history
from deltactl.diagnosis.experiment.ties import Explanation, Key, Tie
from deltactl.diagnosis.observations.readings import FloatArray, Readings
from deltactl.diagnosis.plants.candidate import Term
from deltactl.diagnosis.plants.delta.next_runs import DeltaRun
from deltactl.models.effects import CARDS
from deltactl.models.effects.kind import MOTORS


@dataclass(frozen=True, slots=True)
class ExperimentOptions:
    """What a run must tell, and how long it may take."""

    settles: float = 40.0
    """Expected chi-square that a run must give: it then leaves less than the limit of a tie (11)
    once in a hundred times, as chi-square scatters by twice its root."""
    holds_back: float = 1.5
    """Evidence aimed at over `settles`: the machine is never quite what the model says."""
    longest_min: float = 8.0
    """A tie that needs a longer run is left open."""
    shortest_min: float = 1.0
    """Repeated up to this: homing and starting take as long as a shorter run."""
    most_ties: int = 4
    """Ties that one run is designed for, the closest first: each is simulated both ways."""
    refined: int = 2
    """Runs whose evidence is worked out again with everything else refitted to the end."""


EXPERIMENT = ExperimentOptions()
"""As the engine is used."""


class Run:
    """One candidate motion as the engine would see it, with the noise of the recording."""

    def __init__(self, candidate: DeltaRun, recorded: Readings, noise: Whitener):
        self.candidate = candidate
        self.minutes = candidate.minutes
        self.model = candidate.model
        self._whiten = _noise(self.model.readings, recorded, noise, candidate.period_s)
        self._columns: dict[tuple[Key, int], FloatArray] = {}
        self._known: dict[Explanation, tuple[FloatArray, bool]] = {}

    def seen(self, terms: Sequence[Term]) -> FloatArray:
        """Whitened readings (m,) with the terms at work."""
        return self._whiten(self.model.predict(_lasting(terms)))

    def of(self, explanation: Explanation) -> tuple[FloatArray, bool]:
        """Whitened readings (m,) of an explanation as it was fitted, and whether the machine
        holds together all along with it.
        """
        if explanation not in self._known:
            predicted = self.model.predict(_lasting(explanation.everything))
            whole = self.candidate.holds_together(predicted)
            self._known[explanation] = self._whiten(predicted), whole
        return self._known[explanation]

    def tangent(self, terms: Sequence[Term], here: FloatArray, fresh: set[Key]) -> FloatArray:
        """Whitened derivatives (m, p); those of terms outside `fresh` are worked out only once.

        here: the readings as they are seen with the terms, (m,).
        """
        columns = []
        for number, term in enumerate(terms):
            for i in term.candidate.moved:
                key = (term.candidate.key, i)
                if term.candidate.key in fresh or key not in self._columns:
                    self._columns[key] = self._derivative(terms, number, i, here)
                columns.append(self._columns[key])
        return np.stack(columns, axis=1) if columns else np.zeros((len(here), 0))

    def _derivative(
        self, terms: Sequence[Term], number: int, i: int, here: FloatArray
    ) -> FloatArray:
        term = terms[number]
        coordinate, at = term.candidate.coordinates[i], term.at.copy()
        step = coordinate.step if at[i] + coordinate.step <= coordinate.high else -coordinate.step
        at[i] += step
        moved = [*terms[:number], Term(term.candidate, at), *terms[number + 1 :]]
        return (self.seen(moved) - here) / step


def _lasting(terms: Sequence[Term]) -> list[Term]:
    """What happened once does not come back."""
    return [term for term in terms if not term.candidate.kind.event]


def _noise(designed: Readings, recorded: Readings, noise: Whitener, period_s: float) -> Whitener:
    """The recording's noise on the samples of a run, with its share of valid readings."""
    valid = np.ones(designed.values.shape, dtype=bool)
    channels, weights = [], []
    coarser = period_s / recorded.period_s
    for rows, seen in zip(history(designed, valid), noise.channels, strict=True):
        phi, sigma = seen.phi, seen.sigma
        if coarser > 1.0 + 1e-9:
            sigma = sigma / max(1.0 - float(np.sum(phi)), 0.02) / np.sqrt(coarser)
            phi = np.zeros_like(phi)
        share = min(1.0, len(seen.rows) / max(len(recorded.t_s), 1))
        channels.append(ChannelNoise(rows, phi, sigma, seen.spread))
        weights.append(np.full(len(rows), np.sqrt(share)))
    return Whitener(tuple(channels), np.concatenate(weights))


def expected(
    run: Run, truth: Explanation, alternative: Explanation, repeats: float = 1.0, steps: int = 1
) -> float:
    """Chi-square that separates alternative from truth after the run, all of the alternative
    refitted.

    steps: refits after the first linear one that are checked against the chain itself.
    """
    own = {t.candidate.key for t in alternative.terms} - {t.candidate.key for t in truth.terms}
    target, weight = run.of(truth)[0], float(np.sqrt(repeats))
    at = best_at = alternative.at
    terms, here = alternative.everything, run.of(alternative)[0]
    left = weight * (target - here)
    best = float(left @ left)
    for _ in range(steps):
        if at is best_at:
            jac = np.concatenate([weight * run.tangent(terms, here, own), alternative.root])
            held = alternative.root @ (alternative.at - at)
            at = at + _least_squares(jac, np.concatenate([left, held]))
        else:
            at = 0.5 * (at + best_at)
        terms = alternative.moved_to(at)
        at = np.array([t.at[i] for t in terms for i in t.candidate.moved])
        here = run.seen(terms)
        rest, off = weight * (target - here), alternative.root @ (at - alternative.at)
        cost = float(rest @ rest + off @ off)
        if cost < best:
            best, best_at, left = cost, at, rest
    return best


def _least_squares(jac: FloatArray, residual: FloatArray) -> FloatArray:
    scale = np.maximum(np.linalg.norm(jac, axis=0), 1e-30)
    step: FloatArray = np.linalg.lstsq(jac / scale, residual, rcond=1e-8)[0] / scale
    return step


def both_ways(run: Run, tie: Tie, repeats: float = 1.0, steps: int = 1) -> tuple[float, float]:
    """Expected evidence when the first explanation is true, and when the second one is.

    Both are 0 where the machine would not hold together if one of them is true.
    """
    if not (run.of(tie.first)[1] and run.of(tie.second)[1]):
        return 0.0, 0.0
    return (
        0.0
        if contains(tie.only_second, tie.only_first)
        else expected(run, tie.first, tie.second, repeats, steps),
        0.0
        if contains(tie.only_first, tie.only_second)
        else expected(run, tie.second, tie.first, repeats, steps),
    )


def contains(alternative: Sequence[Term], truth: Sequence[Term]) -> bool:
    """Whether an alternative can be the truth exactly, on every motion, by the effects' cards."""
    effects = [t.candidate.effect for t in alternative for _ in t.candidate.members or (0,)]
    able = set()
    for term in alternative:
        name = term.candidate.effect
        for one in CARDS[name].confusions:
            if one.exactly:
                able.add((one.other, term.candidate.component))
            if one.exactly_together_at and effects.count(name) == len(MOTORS):
                able.add((one.other, one.exactly_together_at))
    return all((t.candidate.effect, t.candidate.component) in able for t in truth)
