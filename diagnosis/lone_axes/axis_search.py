"""The search on a lone axis: the engine's scores and fits, with proof that survives a rough model.

One channel, much data and little noise: on real axes every model leaves a structure that noise
does not have, and plain chi-squares would name it all. So the chi-square is scaled by what is
left over, each effect must lower the mismatch in many blocks of time alike, and it must explain
a part of what is left.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from scipy.special import log_ndtr

from diagnosis.answer.verdict import ALARM
from diagnosis.estimation.estimate import Solution
from diagnosis.estimation.penalties import Trial, penalty
from diagnosis.estimation.splines import FreeShape
from diagnosis.evidence.chi2_tail import log_sf, log_sfs
from diagnosis.evidence.detection import Detection as Search
from diagnosis.lone_axes.axis_jumps import scan
from diagnosis.lone_axes.axis_tidy import ALIKE, tidied
from diagnosis.observations.readings import IntArray
from diagnosis.plants.candidate import Term

MOST_TERMS = 6
TRIED = 6
TOGETHER = 3
WORTH_TRYING = 0.4
FREE_PRICE = 20.0
FREE_ADVANTAGE = 10.0
"""Scaled chi-square by which an explanation with a free shape must fit better."""
FREE_LEAST_A_READING = 0.03
"""Chi-square per reading that a free shape must gain."""
FREE_LEAST = 0.04
"""Share of the whole mismatch by which it must fit better: slight shapes are nobody's news."""
LEAST_OF_REST = 0.06
"""Share of what is left above the noise that a further effect must explain."""
FREE_LEAST_OF_REST = 0.2
WAVES = ("transmission_error", "encoder_error")
SAME_PERIOD = 0.3
BLOCKS = 40
SHORTEST_BLOCK_S = 1.0
FEWEST_IN_BLOCK = 4
LEAST_Z = 4.0
RELUCTANCE = {
    "sensor_latency": 10.0, "resonance": 6.0, "encoder_error": 12.0, "transmission_error": 8.0,
    "viscous_friction": 1.0, "stribeck_friction": 4.0, "effort_gain": 2.0,
}  # fmt: skip
"""Chi-square by which the likelier of two that fit alike is preferred."""


@dataclass(slots=True, eq=False)
class AxisSearch(Search):
    """Finds the set of effects on one axis. `unlikely`: further reluctance, by effect."""

    unlikely: tuple[tuple[str, float], ...] = ()
    least_share: float = 1e-4
    """Share of the whole mismatch that an effect must explain: operators are approximations."""
    blur: float = 0.0
    """Chi-square per reading that the model's own approximations may make."""

    @property
    def event_tests(self) -> float:
        """Moments at which a loss could have come."""
        return self.prepared.model.readings.span_s if self.rad_per_step else 0.0

    def toll(self, term: Term) -> float:
        """What a term must earn."""
        effect = term.candidate.effect
        return (
            penalty(term.candidate)
            + RELUCTANCE.get(effect, 0.0)
            + dict(self.unlikely).get(effect, 0)
        )

    def first_p_of_all(self, found: Solution) -> float:
        """Calibrated p of 'nothing is missing' before any finding.

        Where nothing could be proven, the p is no smaller than the strongest candidate's gain
        block by block allows: an encoder's steps are no white noise.
        """
        scores = self.scores_of_empty
        gain = np.maximum(scores.gain - self.blur * self.fitter.rows, 0.0)
        df = np.array([entry.df for entry in self.prepared.library.entries])
        p = self.p(float(log_sfs(gain, df).min(initial=0.0)))
        if found.terms or found.frees or p > ALARM:
            return p
        steady = max((self.steadiness(self.empty, s) for s in self._tried(self.empty)), default=0.0)
        return max(p, self.p(float(log_ndtr(-steady) + np.log(2.0))))

    def excess(self, solution: Solution) -> float:
        """How much more is left than noise would leave, at least 1."""
        return max(1.0, solution.cost / max(self.fitter.rows, 1))

    def value(self, solution: Solution, scale: float) -> float:
        """Scaled cost with the tolls: the smaller the better."""
        tolls = sum(self.toll(term) for term in solution.terms)
        return solution.cost / scale + tolls + FREE_PRICE * len(solution.frees)

    def run(self) -> Solution:
        """The best set of named effects, with free shapes where they do clearly better."""
        named = self._extended(self.empty)
        best = named
        for freed in [*self._freed(named), *(self._freed(self.empty, 2) if named.terms else [])]:
            bare = named if freed.terms else self.empty
            if not self.proven(bare, freed, freed.frees[-1].size):
                continue
            rival = self._extended(self._pruned(freed))
            scale = self.excess(min(rival, best, key=lambda s: s.cost))
            needed = FREE_ADVANTAGE * scale + FREE_LEAST * (self.empty.cost - self.fitter.rows)
            if best.cost - rival.cost < needed:
                continue
            if self.value(rival, scale) < self.value(best, scale):
                best = rival
        return tidied(self.fitter, self.lasting(best), self.excess(best))

    def lasting(self, solution: Solution) -> Solution:
        """An event gives way to whatever lasts and fits alike."""
        for number, term in enumerate(solution.terms):
            if not term.candidate.kind.event:
                continue
            rest = (*solution.terms[:number], *solution.terms[number + 1 :])
            bare = self.fitter.solve(rest, solution.frees, solution.nuisances)
            starts = [t.start for t in self.trials(bare) if not t.start.candidate.kind.event]
            others = [
                self.fitter.solve((*rest, start), solution.frees, solution.nuisances)
                for start in starts[:TRIED]
            ]
            best = min(others, key=lambda s: s.cost, default=None)
            if best is not None and best.cost < solution.cost + ALIKE * self.excess(solution):
                return best
        return solution

    def _extended(self, solution: Solution) -> Solution:
        """Effect after effect until none is proven."""
        for _ in range(MOST_TERMS):
            grown = self._grown(solution)
            if grown is None or len(grown.terms) > MOST_TERMS:
                break
            solution = self._pruned(grown)
        joint = self._jointly(solution) if not solution.terms else None
        return self._pruned(joint) if joint is not None else solution

    def _jointly(self, solution: Solution) -> Solution | None:
        """Effects that do little alone and much together, as the terms of a curve do."""
        lasting = [t.start for t in self.trials(solution) if not t.start.candidate.kind.event]
        if len(lasting) < TOGETHER or self.p(self.smallest_log_p(solution)) > ALARM:
            return None
        terms = (*solution.terms, *lasting[:TOGETHER])
        grown = self.fitter.solve(terms, solution.frees, solution.nuisances)
        df = max(self._numbers(grown) - self._numbers(solution), 1)
        return grown if self.proven(solution, grown, df) else None

    def smallest_log_p(self, solution: Solution) -> float:
        """Logarithm of the smallest p of the library, scaled by what is left over."""
        df = np.array([entry.df for entry in self.prepared.library.entries])
        gain = self.scores(solution).gain / self.excess(solution)
        return float(log_sfs(gain, df).min(initial=0.0))

    def _grown(self, solution: Solution) -> Solution | None:
        tried = self._tried(solution)
        if not tried:
            return None
        scale = self.excess(min(tried, key=lambda s: s.cost))
        for grown in sorted(tried, key=lambda s: self.value(s, scale)):
            df = self._numbers(grown) - self._numbers(solution)
            if self.proven(solution, grown, max(df, 1)) and self._no_plainer(grown, tried):
                return grown
        return None

    def _no_plainer(self, grown: Solution, tried: Sequence[Solution]) -> bool:
        """An event must beat what lasts in many blocks of time; anything may happen in one."""
        if not grown.terms[-1].candidate.kind.event:
            return True
        lasting = [s for s in tried if not s.terms[-1].candidate.kind.event]
        best = min(lasting, key=lambda s: s.cost, default=None)
        return best is None or self.steadiness(best, grown) > LEAST_Z

    def _tried(self, solution: Solution) -> list[Solution]:
        trials = self.trials(solution)[:TRIED]
        if not trials:
            return []
        strongest = max(trial.gain for trial in trials)
        self.progress(f"trying {len(trials)} explanations")
        return [
            self.fitter.solve((*solution.terms, t.start), solution.frees, solution.nuisances)
            for t in trials
            if t.gain > WORTH_TRYING * strongest
        ]

    def _freed(self, solution: Solution, most: int = 1) -> list[Solution]:
        """The solution with a free shape that explains much of the rest."""
        return [
            self.fitter.solve(solution.terms, (*solution.frees, free), solution.nuisances)
            for free in self._free_trials(solution, most)
        ]

    def _free_trials(self, solution: Solution, most: int) -> list[FreeShape]:
        scores, entries = self.scores(solution), self.prepared.library.entries
        taken = {free.driver for free in solution.frees}
        ranked = sorted(
            (n for n, e in enumerate(entries) if e.free is not None and e.free.driver not in taken),
            key=lambda n: -scores.gain[n],
        )
        least = FREE_LEAST_OF_REST * (solution.cost - self.fitter.rows)
        found = [entries[n].free for n in ranked[:most] if scores.gain[n] > least]
        return [free for free in found if free is not None]

    def _pruned(self, solution: Solution) -> Solution:
        for number in range(len(solution.terms)):
            if len(solution.terms) + len(solution.frees) < 2:
                break
            rest = (*solution.terms[:number], *solution.terms[number + 1 :])
            bare = self.fitter.solve(rest, solution.frees, solution.nuisances)
            df = max(len(solution.terms[number].candidate.moved), 1)
            if not self.proven(bare, solution, df):
                return self._pruned(bare)
        return solution

    def proven(self, bare: Solution, full: Solution, df: int) -> bool:
        """Whether `full` explains significantly more, by scaled chi-square and block by block."""
        gain = bare.cost - full.cost
        if gain <= 0.0:
            return False
        if len(full.frees) > len(bare.frees) and gain < FREE_LEAST_A_READING * self.fitter.rows:
            return False
        scale = self.excess(full)
        gain = max(gain - self.blur * self.fitter.rows, 0.0)
        if self.p(log_sf(gain / scale, df)) > ALARM:
            return False
        if gain < self.least_share * (self.empty.cost - self.fitter.rows):
            return False
        rest = bare.cost - self.fitter.rows
        if scale > 1.3 and gain < LEAST_OF_REST * rest:
            return False
        return self.steadiness(bare, full) > LEAST_Z

    def steadiness(self, bare: Solution, full: Solution) -> float:
        """z of the gain from its scatter over blocks of time (Vuong 1989, in blocks)."""
        rows = self.fitter.rows
        gained = bare.residual[:rows] ** 2 - full.residual[:rows] ** 2
        sums = np.bincount(self.blocks(), weights=gained)
        spread = float(np.sqrt(np.sum(sums**2)))
        return 2.0 * float(sums.sum()) / spread if spread > 0.0 else 0.0

    def blocks(self) -> IntArray:
        """Blocks of equal time and travel: what happens happens in motion."""
        model = self.prepared.model
        driver = next(iter(model.drivers().values()))
        travel = np.cumsum(np.abs(np.diff(driver, prepend=driver[0])))
        t_s = model.readings.t_s - model.readings.t_s[0]
        share = 0.5 * t_s / t_s[-1] + 0.5 * travel / max(float(travel[-1]), 1e-300)
        count = min(
            BLOCKS, int(model.readings.span_s / SHORTEST_BLOCK_S), len(t_s) // FEWEST_IN_BLOCK
        )
        blocks: IntArray = (share * 0.999999 * max(count, 4)).astype(np.intp)
        return blocks[self.fitter.whiten.rows]

    @staticmethod
    def _numbers(solution: Solution) -> int:
        named = sum(len(term.candidate.moved) for term in solution.terms)
        return named + sum(free.size for free in solution.frees)

    def trials(
        self, solution: Solution, without: Sequence[tuple[str, ...]] = (), groups: bool = False
    ) -> list[Trial]:
        """As the engine's, in the order of this search's tolls."""
        # The engine's own scan for lost steps knows the motors of a delta only.
        rad_per_step, self.rad_per_step = self.rad_per_step, 0.0
        found = Search.trials(self, solution, without)
        self.rad_per_step = rad_per_step
        scale = self.excess(solution)
        if self.rad_per_step and not any(
            t.candidate.effect == "lost_steps" for t in solution.terms
        ):
            found = [*found, *scan(self.fitter, solution, self.prepared.model, self.rad_per_step)]
        found = [t for t in found if t.gain > 0.0 and not _same_wave(t.start, solution.terms)]
        return sorted(found, key=lambda t: self.toll(t.start) - t.gain / scale)


def _same_wave(start: Term, terms: Sequence[Term]) -> bool:
    """Gear and encoder errors of nearly one period would only cancel each other."""
    if start.candidate.effect not in WAVES:
        return False
    return any(
        term.candidate.effect in WAVES and abs(term.at[2] - start.at[2]) < SAME_PERIOD
        for term in terms
    )
