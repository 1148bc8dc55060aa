"""What is left without a finding: the others are fitted again and take over what they can.

Of a change of a size that the robot file knows, nothing is: what is known of it would move instead,
and take its place.
"""

from __future__ import annotations

from collections.abc import Sequence

from deltactl.diagnosis.assessment.holdout import counted_columns, rms
from deltactl.diagnosis.estimation.estimate import Solution
from deltactl.diagnosis.estimation.least_squares import Fitter
from deltactl.diagnosis.evidence.left_by_measured import held_to
from deltactl.diagnosis.observations.readings import FloatArray, without_outliers
from deltactl.diagnosis.plants.candidate import Term

LEAST_GAIN = 1e-30
REFIT_STEPS = 4


def left_without(fitter: Fitter, solution: Solution, number: int) -> float:
    """Root mean square without a term; number: of the term."""
    others = _others(solution, number)
    bare = fitter.solve(others, solution.frees, solution.nuisances, steps=REFIT_STEPS)
    return _left_by(fitter, solution, [bare.predicted])[0]


def share_and_left(
    fitter: Fitter, nominal: Solution, solution: Solution, number: int, whole: FloatArray
) -> tuple[float, float] | None:
    """Share of the mismatch, and what is left without it (root mean square); number: of the term.

    None of an effect of which the robot file holds nothing. nominal: as the file foretells. whole:
    prediction by all nuisances and terms.
    """
    key = solution.terms[number].candidate.key
    if key not in {nuisance.term.candidate.key for nuisance in held_to(fitter)}:
        return None
    by_others = fitter.model.predict([*solution.nuisances, *_others(solution, number)])
    without = by_others + solution.predicted - whole
    every = (nominal.predicted, solution.predicted, without)
    before, after, left = _left_by(fitter, solution, every)
    return (left**2 - after**2) / max(before**2 - after**2, LEAST_GAIN), left


def _others(solution: Solution, number: int) -> tuple[Term, ...]:
    return (*solution.terms[:number], *solution.terms[number + 1 :])


def _left_by(fitter: Fitter, solution: Solution, every: Sequence[FloatArray]) -> list[float]:
    """By each prediction in the channels of the figures of the fit, without the outliers of the
    solution.
    """
    model, observed = fitter.model, fitter.observed
    valid = without_outliers(observed - solution.predicted, model.readings.valid)
    columns, _ = counted_columns(model)
    return [rms(observed - predicted, valid, columns) for predicted in every]
