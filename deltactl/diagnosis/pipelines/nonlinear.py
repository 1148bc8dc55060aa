"""The way of a recording whose effects are fitted together: searched, settled, answered."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from functools import partial
from typing import Any

import numpy as np
from scipy.special import chdtrc

from deltactl.diagnosis.answer.assembly import allowing, as_far_as_rows_tell
from deltactl.diagnosis.answer.records import (
    AllowedFor,
    Diagnosis,
    Finding,
    Fit,
    Picture,
    PriorSensitivity,
)
from deltactl.diagnosis.answer.verdict import seen
from deltactl.diagnosis.assessment.detection_limits import limits
from deltactl.diagnosis.assessment.holdout import counted_columns, on_another_run, on_blocks, rms
from deltactl.diagnosis.assessment.impossible import beyond_physics, first_impossible, lacking, less
from deltactl.diagnosis.assessment.intervals import covariance, parameters
from deltactl.diagnosis.assessment.options import ASSESSMENT
from deltactl.diagnosis.estimation.budget import Budget
from deltactl.diagnosis.estimation.estimate import Solution
from deltactl.diagnosis.estimation.least_squares import Fitter
from deltactl.diagnosis.estimation.side_by_side import side_by_side
from deltactl.diagnosis.evidence.detection import Progress
from deltactl.diagnosis.evidence.noise_estimation import Prepared, prepare
from deltactl.diagnosis.experiment.propose import Proposal, propose
from deltactl.diagnosis.observations.readings import BoolArray, FloatArray
from deltactl.diagnosis.observations.stale_readings import without_stale
from deltactl.diagnosis.pipelines.findings import Outcome, findings, picture, rest
from deltactl.diagnosis.pipelines.way import Figures, Limits, answered
from deltactl.diagnosis.plants.contract import Model
from deltactl.diagnosis.plants.next_run import NextRuns
from deltactl.diagnosis.plants.traits import traits_of
from deltactl.diagnosis.priors.options import PENALTIES
from deltactl.diagnosis.selection.model_choice import Explained, explain, final_fit
from deltactl.models.effects import Search, found_by


def allowed_for(fitter: Fitter, solution: Solution) -> list[AllowedFor]:
    """Fitted build tolerances that are clearly not nothing, the one farthest off first."""
    tolerances = {nuisance.term.candidate.key: nuisance for nuisance in fitter.model.tolerances}
    cov = covariance(fitter, solution)
    found: list[AllowedFor] = []
    first = 0
    for term in solution.nuisances:
        candidate = term.candidate
        part = slice(first, first + len(candidate.moved))
        first = part.stop
        tolerance = tolerances.get(candidate.key)
        if tolerance is None:
            continue
        off = (term.at - tolerance.term.at)[candidate.moved]
        if not _clear(off, cov[part, part]):
            continue
        usual = PENALTIES.within * max(tolerance.spread)
        found.append(
            AllowedFor(
                effect=candidate.effect,
                component=candidate.component,
                parameters=parameters(term, cov[part, part]),
                usual=usual,
                times_usual=float(np.linalg.norm(off)) / usual,
            )
        )
    return sorted(found, key=lambda one: -one.times_usual)


def _clear(off: FloatArray, cov: FloatArray) -> bool:
    """Whether fitted numbers (k,) are as far off nothing as chance hardly brings them."""
    gain = float(off @ np.linalg.pinv(cov, hermitian=True) @ off)
    return bool(chdtrc(len(off), gain) < chdtrc(1, ASSESSMENT.clearly_off**2))


def diagnose_model(
    model: Model,
    rad_per_step: float,
    held_out: Sequence[Model],
    progress: Progress,
    next_runs: NextRuns | None = None,
    thorough: bool = False,
) -> Diagnosis:
    """Detect, locate, name, resolve, size, hold out.

    next_runs: what the machine may do next; without it no run is proposed.
    thorough: compare everything, however much work it is.
    """
    progress("noise of the readings")
    valid, runs = without_stale(model.readings, traits_of(model).repeating)
    while True:
        budget = Budget() if thorough else Budget.for_rows(len(model.readings.t_s))
        prepared = prepare(model, valid, budget)
        progress("searching for what is missing")
        explained, fitter, solution = _settled(prepared, rad_per_step, progress)
        if (effect := beyond_physics(fitter, solution)) is None:
            break
        model = lacking(model, effect)
    outcome = Outcome(explained, fitter, solution, runs)
    return answered(FittedTogether(outcome, prepared, held_out, budget, next_runs), progress)


def _settled(
    prepared: Prepared, rad_per_step: float, progress: Progress
) -> tuple[Explained, Fitter, Solution]:
    """The accepted explanation, without what no machine can have."""
    explained = explain(prepared, rad_per_step, progress)
    fitter, solution = final_fit(explained, prepared.valid)
    while (number := first_impossible(solution)) is not None:
        explained = less(explained, number)
        fitter, solution = final_fit(explained, prepared.valid)
    return explained, fitter, solution


@dataclass(frozen=True, slots=True, eq=False)
class FittedTogether:
    """An explanation whose terms are fitted together, see `Settled`."""

    outcome: Outcome
    prepared: Prepared
    held_out: Sequence[Model]
    budget: Budget
    next_runs: NextRuns | None

    def figures(self) -> Figures:
        """See Settled; side by side, since each fits anew."""
        outcome, prepared = self.outcome, self.prepared
        floor = outcome.explained.search.prepared.floor
        tasks: list[Callable[[], Any]] = [
            partial(findings, outcome),
            partial(_fit, outcome, prepared.valid, floor, self.held_out),
            partial(rest, outcome),
        ]
        found, fit, left = side_by_side(tasks)
        period_s = self.outcome.fitter.model.readings.period_s
        found = [as_far_as_rows_tell(one, period_s) for one in found]
        if not seen(left.p):
            fit = allowing(fit, self._left_by_measured())
        return Figures(found, fit, left)

    def _left_by_measured(self) -> float:
        """How large what effects of the file may leave is, root mean square."""
        size = self.outcome.explained.search.tests.left_by_measured.size
        columns, _ = counted_columns(self.outcome.fitter.model)
        return rms(size, self.prepared.valid, columns)

    def chance(self, found: Sequence[Finding]) -> float:
        """See Settled."""
        return min([self.outcome.explained.first_p, *(one.evidence.p for one in _stale(found))])

    def nothing_missing(self, found: Sequence[Finding]) -> float:
        """See Settled: no effect, and no reading that was repeated."""
        stale = [one.probability or 0.0 for one in _stale(found)]
        return self.outcome.explained.credible.nothing * (1.0 - max(stale, default=0.0))

    def by_priors(self, found: Sequence[Finding]) -> list[PriorSensitivity]:
        """See Settled."""
        chances = self.outcome.explained.credible
        terms = self.outcome.explained.solution.terms
        every = zip(terms, chances.terms, chances.under, strict=True)
        return [
            PriorSensitivity(
                effect=term.candidate.effect,
                component=term.candidate.component,
                probability=now,
                narrower=narrower,
                wider=wider,
            )
            for term, now, (narrower, wider) in every
            if max(abs(narrower - now), abs(wider - now)) > ASSESSMENT.matters
        ]

    def limits(self) -> Limits:
        """See Settled."""
        return Limits(*limits(self.outcome.explained.search.tests))

    def next_run(self) -> Proposal:
        """See Settled."""
        searched = self.outcome.explained.search
        searched.prepared.library.forget_white()
        return propose(
            self.outcome.fitter.model.readings,
            searched.fitter.whiten,
            self.outcome.explained.stands,
            self.outcome.explained.solution,
            self.next_runs,
        )

    def picture(self) -> Picture:
        """See Settled."""
        return picture(self.outcome, self.outcome.fitter.model.covariates(), self.prepared.valid)

    def remarks(self) -> dict[str, Any]:
        """Build tolerances if they were needed, and whether the limit of work was reached."""
        outcome = self.outcome
        loose = outcome.explained.with_tolerances or outcome.fitter.model.loosely_built
        return {
            "loosely_built": loose,
            "allowed_for": allowed_for(outcome.fitter, outcome.solution) if loose else [],
            "ended_early": self.budget.ended,
        }


def _stale(found: Sequence[Finding]) -> list[Finding]:
    return [one for one in found if one.effect == found_by(Search.REPEATS).name]


def _fit(outcome: Outcome, valid: BoolArray, floor: FloatArray, held_out: Sequence[Model]) -> Fit:
    model, solution = outcome.fitter.model, outcome.solution
    columns, unit = counted_columns(model)
    observed = outcome.fitter.observed
    empty = outcome.explained.nominal
    if held_out:
        pairs = [on_another_run(other, empty, solution, columns) for other in held_out]
        before, after = (float(np.sqrt(np.mean(np.square(x)))) for x in zip(*pairs, strict=True))
    else:
        before, after = on_blocks(outcome.fitter, empty, solution, valid, columns)
    return Fit(
        rms_before_m=rms(observed - empty.predicted, valid, columns),
        rms_after_m=rms(observed - solution.predicted, valid, columns),
        noise_floor_m=rms(floor, valid, columns),
        holdout_rms_before_m=before,
        holdout_rms_after_m=after,
        unit=unit,
        holdout="run" if held_out else "blocks",
    )
