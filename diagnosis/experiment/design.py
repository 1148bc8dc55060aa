"""How much a run is expected to tell: one explanation's readings, the other one refitted to them.

T-optimality (Atkinson and Fedorov 1975, 'The design of experiments for discriminating between
two rival models'): the evidence a run gives is the chi-square that is left when the rival has
been refitted to what the other explanation predicts. Here the rival is refitted with all
nuisances and all effects both share, and stays answerable to the recording there is already.
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from diagnosis.candidate import Term
from diagnosis.delta_model import DeltaModel
from diagnosis.experiment.motions import Motion
from diagnosis.experiment.ties import Explanation, Key, Tie
from diagnosis.experiment.timeline import as_recording, duration_s
from diagnosis.noise import ChannelNoise, Whitener, history
from diagnosis.readings import FloatArray, Readings
from models.robot import ARMS

CONTAINED = {"gear_backlash": "joint_friction"}
"""An effect that can be another one exactly: play in which the arm stays where it is pushed."""
CONTAINED_BY_ALL = {"following_lag": "sensor_latency"}
"""The same of an effect on all motors together: equal dead times everywhere."""
SHORTEST_PERIOD_S = 0.01
"""Recordings sampled faster are thought of as sampled this fast, noise averaged."""


class Run:
    """One candidate motion as the engine would see it, with the noise of the recording."""

    def __init__(self, motion: Motion, recorded: DeltaModel, noise: Whitener):
        assert recorded.robot.drive is not None
        step = recorded.robot.drive.rad_per_step
        period_s = max(recorded.readings.period_s, SHORTEST_PERIOD_S)
        readings = recorded.readings
        self.motion = motion
        self.minutes = duration_s(motion, step) / 60.0
        blank = as_recording(motion, step, period_s, readings.names)
        self.model = DeltaModel(recorded.robot, [blank])
        self._whiten = _noise(self.model.readings, readings, noise, period_s)
        self._columns: dict[tuple[Key, int], FloatArray] = {}

    def seen(self, terms: Sequence[Term]) -> FloatArray:
        """Whitened readings (m,) with the terms at work."""
        return self._whiten(self.model.predict(_lasting(terms)))

    def possible(self, terms: Sequence[Term]) -> bool:
        """Whether the linkage stays together all along with the terms at work."""
        predicted = self.model.predict(_lasting(terms))
        metres = [i for i, unit in enumerate(self.model.readings.units) if unit == "m"]
        # Where it cannot be assembled the model puts zeros.
        return not metres or bool(predicted[:, metres].any(axis=1).all())

    def tangent(self, terms: Sequence[Term], fresh: set[Key]) -> FloatArray:
        """Whitened derivatives (m, p); those of terms outside `fresh` are worked out only once."""
        here = self.seen(terms)
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
    run: Run, truth: Explanation, rival: Explanation, repeats: float = 1.0, steps: int = 1
) -> float:
    """Chi-square that separates rival from truth after the run, all of the rival refitted.

    steps: refits after the first linear one that are checked against the chain itself.
    """
    own = {t.candidate.key for t in rival.solution.terms} - {
        t.candidate.key for t in truth.solution.terms
    }
    target, weight = run.seen(truth.everything), float(np.sqrt(repeats))
    at = best_at = rival.at
    best = np.inf
    for _ in range(steps + 1):
        terms = rival.moved_to(at)
        at = np.array([t.at[i] for t in terms for i in t.candidate.moved])
        left = weight * (target - run.seen(terms))
        off = rival.root @ (at - rival.at)
        cost = float(left @ left + off @ off)
        if cost >= best:
            at = 0.5 * (at + best_at)
            continue
        best, best_at = cost, at
        jac = np.concatenate([weight * run.tangent(terms, own), rival.root])
        at = at + _least_squares(jac, np.concatenate([left, -off]))
    return best


def _least_squares(jac: FloatArray, residual: FloatArray) -> FloatArray:
    scale = np.maximum(np.linalg.norm(jac, axis=0), 1e-30)
    step: FloatArray = np.linalg.lstsq(jac / scale, residual, rcond=1e-8)[0] / scale
    return step


def both_ways(run: Run, tie: Tie, repeats: float = 1.0, steps: int = 1) -> tuple[float, float]:
    """Expected evidence when the first explanation is true, and when the second one is.

    None where the platform would get lost if one of them is true.
    """
    if not (run.possible(tie.first.everything) and run.possible(tie.second.everything)):
        return 0.0, 0.0
    return (
        0.0 if contains(tie.only_second, tie.only_first)
        else expected(run, tie.first, tie.second, repeats, steps),
        0.0 if contains(tie.only_first, tie.only_second)
        else expected(run, tie.second, tie.first, repeats, steps),
    )  # fmt: skip


def contains(rival: Sequence[Term], truth: Sequence[Term]) -> bool:
    """Whether a rival can be the truth exactly, on every motion."""
    effects = [t.candidate.effect for t in rival for _ in t.candidate.members or (0,)]
    able = {(CONTAINED.get(t.candidate.effect, ""), t.candidate.component) for t in rival}
    able |= {(n, "sensors") for e, n in CONTAINED_BY_ALL.items() if effects.count(e) == ARMS}
    return all((t.candidate.effect, t.candidate.component) in able for t in truth)
