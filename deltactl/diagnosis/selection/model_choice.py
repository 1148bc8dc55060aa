"""Which explanation to accept: few effects, these beside build tolerances, or unknown physics."""

from __future__ import annotations

from dataclasses import dataclass, replace

from deltactl.diagnosis.estimation.budget import Until
from deltactl.diagnosis.estimation.estimate import Solution
from deltactl.diagnosis.estimation.least_squares import Fitter
from deltactl.diagnosis.estimation.noise import Whitener, estimate
from deltactl.diagnosis.estimation.options import ESTIMATION
from deltactl.diagnosis.evidence.detection import Progress
from deltactl.diagnosis.evidence.left_by_measured import held_to
from deltactl.diagnosis.evidence.noise_estimation import Prepared, once_more
from deltactl.diagnosis.observations.readings import BoolArray, FloatArray
from deltactl.diagnosis.priors.options import OPTIONS
from deltactl.diagnosis.search.exchange import best_of, group_instead, pairs_for_one
from deltactl.diagnosis.search.search import Search
from deltactl.diagnosis.selection.ambiguity import Standing, in_parts, resolved, stands_of
from deltactl.diagnosis.selection.credible_set import Credible, credible, preferred
from deltactl.diagnosis.selection.nonparametric import (
    explains_it_all,
    named_instead,
    shape_promises,
    with_spline_terms,
)
from deltactl.diagnosis.selection.tolerance_or_cause import Needed, ToleranceOrCause


@dataclass(frozen=True, slots=True, eq=False)
class Explained:
    """The outcome: a search (with its fitter) and the solution it settled on."""

    search: Search
    solution: Solution
    first_p: float
    """Calibrated p of 'nothing is missing' before any finding."""
    with_tolerances: bool
    """Build tolerances are fitted everywhere beside the findings."""
    nominal: Solution
    """The machine of the robot file, without even the tolerances."""
    stands: list[Standing]
    """How each term of the solution compares with its alternatives, in their order."""
    credible: Credible
    """How probable all that is."""


def explain(prepared: Prepared, rad_per_step: float, progress: Progress) -> Explained:
    """Search for few effects; then let tolerances everywhere and spline terms compete."""
    search = Search(prepared, rad_per_step, progress)
    first_p = search.tests.first_p()
    search, solution = calmed(search, search.run())
    search.prepared.library.forget_raw()
    nominal = as_the_file_says(search.fitter, search.tests.empty)
    tolerances = ToleranceOrCause(search)
    told, solution = _told(tolerances, *_reviewed(tolerances, solution))
    solution, in_place = named_instead(told, solution)
    progress("what else it could be")
    settled, stands = resolved(told, in_parts(told, solution))
    alternative = preferred(told, settled, stands)
    if alternative is not None:
        settled = in_parts(told, alternative)
        stands = stands_of(told, settled)
    chances = credible(told, settled, stands, in_place if settled is solution else None)
    return Explained(told, settled, first_p, told is not search, nominal, stands, chances)


def _told(
    tolerances: ToleranceOrCause, solution: Solution, needed: Needed | None
) -> tuple[Search, Solution]:
    """The better explanation, few effects or these beside build tolerances, with its spline terms.

    One shape that explains it all is no machine that is a little off everywhere: where the scores
    promise one, it is asked first.
    """
    search, shaped = tolerances.search, None
    if needed is not None:
        if shape_promises(search, solution, needed.penalised):
            shaped = with_spline_terms(search, solution)
            if explains_it_all(search, shaped, needed.penalised):
                return search, shaped
        search.progress("comparing with a machine that is a little off everywhere")
        lasts = search.budget.lasts(Until.TOLERANCES)
        other = tolerances.instead(solution, needed) if lasts else None
        if other is not None:
            return tolerances.other, with_spline_terms(tolerances.other, other)
    return search, with_spline_terms(search, solution) if shaped is None else shaped


def _reviewed(tolerances: ToleranceOrCause, solution: Solution) -> tuple[Solution, Needed | None]:
    """A solution or what is better as two causes for one or as a group; and what of it is needed
    beside build tolerances, where these may be better still.
    """
    search = tolerances.search
    if tolerances.likely(solution) and not search.budget.lasts(Until.REVIEWED):
        return solution, None
    if len(solution.terms) > 1 and not search.budget.lasts(Until.PAIRED):
        return solution, tolerances.needed(solution)
    pairs = search.fitter.side_by_side(pairs_for_one(search, solution))
    finished = best_of(search, solution, pairs)
    group = group_instead(search, finished)
    chosen = finished if group is None else group
    return chosen, tolerances.needed(chosen)


def calmed(search: Search, solution: Solution) -> tuple[Search, Solution]:
    """Search on where the noise had model error in it: what rings or sticks looks like noise with a
    memory, and whitening by that takes it, and much beside it, away.
    """
    for _ in range(search.options.most_noise_rounds):
        prepared = search.prepared
        if not solution.terms or not _calmer(
            left_noise(search.fitter, solution, prepared.valid), search.fitter.whiten
        ):
            break
        if not search.budget.lasts(Until.CALMED):
            break
        search.progress("noise of the readings, once more")
        again = once_more(prepared, solution.predicted)
        search = Search(again, search.rad_per_step, search.progress, search.tests.calibration)
        solution = search.resumed(solution.terms, solution.nuisances)
    return search, solution


def left_noise(fitter: Fitter, solution: Solution, valid: BoolArray) -> Whitener:
    """Noise model of what a solution leaves."""
    left: FloatArray = fitter.observed - solution.predicted
    return estimate(fitter.model.readings, valid, left)


def _calmer(new: Whitener, old: Whitener) -> bool:
    """Whether any channel is less noisy than was thought."""
    pairs = zip(new.channels, old.channels, strict=True)
    return any(len(a.rows) and a.sigma < OPTIONS.calmer * b.sigma for a, b in pairs)


def final_fit(explained: Explained, valid: BoolArray) -> tuple[Fitter, Solution]:
    """Fit again under the noise that the chosen explanation itself leaves, until both agree."""
    fitter, solution = explained.search.fitter, explained.solution
    for _ in range(explained.search.options.most_final_fits):
        whitener = left_noise(fitter, solution, valid)
        calmer = _calmer(whitener, fitter.whiten)
        fitter = Fitter(fitter.model, whitener, fitter.nuisances)
        most = ESTIMATION.steps_to_the_end
        solution = fitter.solve(solution.terms, solution.frees, solution.nuisances, steps=most)
        if not calmer:
            break
    return fitter, solution


def as_the_file_says(fitter: Fitter, empty: Solution) -> Solution:
    """The fit of nothing, with measured effects and small errors as the file has them.

    Both are fitted in every solution; how far a machine is from its file must not hide in that.
    """
    fixed = {nuisance.term.candidate.key: nuisance.term for nuisance in held_to(fitter)}
    if not fixed:
        return empty
    nuisances = tuple(fixed.get(term.candidate.key, term) for term in empty.nuisances)
    predicted = fitter.model.predict(nuisances)
    left = fitter.vector(fitter.observed - predicted)
    return replace(
        empty, nuisances=nuisances, predicted=predicted, residual=left, cost=float(left @ left)
    )
