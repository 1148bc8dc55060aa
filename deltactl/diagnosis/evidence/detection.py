"""Detecting: is anything missing at all, and what would each candidate explain of it."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass, field
from functools import partial
from typing import Any
from weakref import WeakKeyDictionary

import numpy as np

from deltactl.diagnosis.answer.verdict import ALARM
from deltactl.diagnosis.estimation.estimate import Solution
from deltactl.diagnosis.estimation.least_squares import Fitter
from deltactl.diagnosis.estimation.splines import Score
from deltactl.diagnosis.evidence.left_by_measured import LeftByMeasured, changed
from deltactl.diagnosis.evidence.noise_estimation import Prepared
from deltactl.diagnosis.plants.candidate import Candidate, Term
from deltactl.diagnosis.priors.penalties import Trial, penalty
from deltactl.diagnosis.score_tests.change_points import Jump, jumps
from deltactl.diagnosis.score_tests.chi2_tail import log_sf
from deltactl.diagnosis.score_tests.fine_scores import scores_of
from deltactl.diagnosis.score_tests.library import Entry
from deltactl.diagnosis.score_tests.pair_scores import start_of
from deltactl.diagnosis.score_tests.score_test import Calibration, Scores, calibrate

Progress = Callable[[str], None]


@dataclass(slots=True, eq=False)
class Detection:
    """Tests of one recording against what any solution leaves."""

    prepared: Prepared
    rad_per_step: float
    progress: Progress = lambda _: None
    known: Calibration | None = None
    """Calibration of the same library under nearly the same noise, where there is one."""
    calibration: Calibration = field(init=False)
    empty: Solution = field(init=False)
    left_by_measured: LeftByMeasured = field(init=False)
    scores_of_empty: Scores = field(init=False)
    # A solution is large: what is known of it must not keep it.
    _fine: WeakKeyDictionary[Solution, list[Score]] = field(default_factory=WeakKeyDictionary)
    _scored: WeakKeyDictionary[Solution, Scores] = field(default_factory=WeakKeyDictionary)
    _jumped: WeakKeyDictionary[Solution, list[Jump]] = field(default_factory=WeakKeyDictionary)

    def __post_init__(self) -> None:
        self.empty = self.fitter.solve(())
        self.left_by_measured = LeftByMeasured(self.fitter, self.empty)
        entries = [entry.candidate for entry in self.prepared.library.entries]
        self.prepared.scorer.left_by_measured = self.left_by_measured.of_all(entries)
        self.calibration = self.known or self._calibrated()
        self.scores_of_empty = self.scores(self.empty)

    def _calibrated(self) -> Calibration:
        """Calibration of the library, while the fine shapes are scored that are asked for first."""
        tasks: list[Callable[[], Any]] = [
            partial(calibrate, self.prepared.scorer, self.empty.basis),
            partial(self._score_fine, self.empty),
        ]
        calibration, fine = self.fitter.side_by_side(tasks, self.prepared.fine)
        self._fine[self.empty] = fine
        assert isinstance(calibration, Calibration)
        return calibration

    @property
    def fitter(self) -> Fitter:
        """The fitter of the prepared recording."""
        return self.prepared.fitter

    def scores(self, solution: Solution) -> Scores:
        """Scores of the whole library against a solution."""
        if solution not in self._scored:
            scores = self.prepared.scorer.against(solution.free_basis, solution.residual)
            self._scored[solution] = scores
        return self._scored[solution]

    @property
    def event_tests(self) -> float:
        """Independent moments a jump could have come at, over all joints; 0 without a scan."""
        joints = len(self._jumps(self.empty))
        return joints * self.prepared.model.readings.span_s

    def p(self, log_p: float) -> float:
        """Calibrated p of the smallest p of library and scan together."""
        tests = self.calibration.tests + self.event_tests
        return Calibration(tests).p(log_p)

    def tolerance_factor_of(self, candidate: Candidate) -> float:
        """How many times more an exact machine may show of it than noise does."""
        scorer, entries = self.prepared.scorer, self.prepared.library.entries
        own = [
            scorer.tolerance_factor[k]
            for k, entry in enumerate(entries)
            if entry.key == candidate.key
        ]
        return float(max(own, default=1.0))

    def first_p(self) -> float:
        """Calibrated p of 'nothing is missing'."""
        scan = [self._log_p(jump) for jump in self._jumps(self.empty)]
        fine = [log_p for _, _, log_p in self.fine_scores(self.empty)]
        other = [trial.log_p for trial in changed(self.fitter, self.empty)]
        return self.p(float(min([self.scores_of_empty.log_p.min(), *scan, *fine, *other])))

    def _jumps(self, solution: Solution) -> list[Jump]:
        if not self.rad_per_step:
            return []
        if solution not in self._jumped:
            self._jumped[solution] = jumps(self.fitter, solution, self.rad_per_step)
        return self._jumped[solution]

    def _log_p(self, jump: Jump) -> float:
        return log_sf(self._beyond(jump), 1)

    def _beyond(self, jump: Jump) -> float:
        """What a jump explains beyond what measured effects may leave."""
        return max(jump.gain - self.left_by_measured.of(jump.candidate), 0.0)

    def fine_scores(self, solution: Solution) -> list[Score]:
        """Fine spline terms and sinusoids with their gain and log p, best first."""
        if solution not in self._fine:
            self._fine[solution] = self._score_fine(solution)
        return self._fine[solution]

    def _score_fine(self, solution: Solution) -> list[Score]:
        small, left = self.prepared.small, self.left_by_measured.of()
        found = scores_of(self.prepared.fine, self.fitter, solution, small, left)
        return sorted(found, key=lambda item: item[2])

    def trials(
        self, solution: Solution, without: Sequence[tuple[str, ...]] = (), groups: bool = False
    ) -> list[Trial]:
        """The best start of every named candidate that is not in the solution, best first."""
        scores = self.scores(solution)
        taken = {term.candidate.key for term in solution.terms} | set(without)
        best: dict[tuple[str, ...], Trial] = {}
        for number, entry in enumerate(self.prepared.library.entries):
            if entry.candidate is None or entry.key in taken:
                continue
            if entry.candidate.members and not groups:
                continue
            left = float(self.prepared.scorer.left_by_measured[number])
            trial = _trial(entry, scores, number, left)
            if trial.log_p <= 0.0 and (entry.key not in best or trial.gain > best[entry.key].gain):
                best[entry.key] = trial
        for trial in changed(self.fitter, solution):
            if trial.start.candidate.key not in taken:
                best[trial.start.candidate.key] = trial
        found = [*best.values(), *self._jump_trials(solution, taken)]
        return sorted(found, key=lambda t: t.penalty - t.gain)

    def changed(self, solution: Solution, key: tuple[str, ...]) -> bool:
        """Whether a measured effect has another size than the robot file has."""
        own = [t for t in changed(self.fitter, solution) if t.start.candidate.key == key]
        return self.any_shows(own)

    def any_shows(self, trials: Sequence[Trial]) -> bool:
        """Whether some named candidate does more than chance of what a solution leaves."""
        return bool(trials) and self.p(min(trial.log_p for trial in trials)) <= ALARM

    def _jump_trials(self, solution: Solution, taken: set[tuple[str, ...]]) -> list[Trial]:
        found = []
        for jump in self._jumps(solution):
            if (candidate := jump.candidate).key not in taken:
                start = Term(candidate, np.array(candidate.shapes[0].origin))
                gain, log_p = self._beyond(jump), self._log_p(jump)
                found.append(Trial(start, gain, log_p, penalty(candidate)))
        return found


def _trial(entry: Entry, scores: Scores, number: int, left: float) -> Trial:
    """left: chi-square that measured effects may leave of it, which is no gain."""
    assert entry.candidate is not None
    start = start_of(entry, scores.step[number])
    gain = max(float(scores.gain[number]) - left, 0.0)
    log_p, cost = float(scores.log_p[number]), penalty(entry.candidate)
    if start is None:
        assert entry.shape is not None
        return Trial(Term(entry.candidate, np.array(entry.shape.origin)), 0.0, 0.0, cost)
    return Trial(start, gain, log_p if gain else 0.0, cost)
