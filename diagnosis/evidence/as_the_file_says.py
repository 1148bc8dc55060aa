"""What a robot file foretells by its own sizes, without those that are fitted again."""

from __future__ import annotations

from dataclasses import replace

from diagnosis.estimation.estimate import Solution
from diagnosis.estimation.least_squares import Fitter


def as_the_file_says(fitter: Fitter, empty: Solution) -> Solution:
    """The fit of nothing, with measured effects and small errors as the file has them.

    Both are fitted in every solution; how far a machine is from its file must not hide in that.
    """
    model = fitter.model
    fixed = {n.term.candidate.key: n.term for n in fitter.nuisances if n.measured}
    if model.loosely_built:
        fixed = {n.term.candidate.key: n.term for n in model.tolerances} | fixed
    if not fixed:
        return empty
    nuisances = tuple(fixed.get(term.candidate.key, term) for term in empty.nuisances)
    predicted = model.predict(nuisances)
    left = fitter.vector(fitter.observed - predicted)
    return replace(
        empty, nuisances=nuisances, predicted=predicted, residual=left, cost=float(left @ left)
    )
