"""What a robot file foretells by its own sizes, without those that are fitted again."""

from __future__ import annotations

from dataclasses import replace

from deltactl.diagnosis.estimation.estimate import Solution
from deltactl.diagnosis.estimation.least_squares import Fitter
from deltactl.diagnosis.evidence.left_by_measured import held_to


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
