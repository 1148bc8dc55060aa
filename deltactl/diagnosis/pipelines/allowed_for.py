"""How large the small errors are that were fitted beside the findings, where they clearly show."""

from __future__ import annotations

import numpy as np
from scipy.stats import chi2

from deltactl.diagnosis.answer.records import AllowedFor
from deltactl.diagnosis.assessment.covariance import covariance, parameters
from deltactl.diagnosis.assessment.options import ASSESSMENT
from deltactl.diagnosis.estimation.estimate import Solution
from deltactl.diagnosis.estimation.least_squares import Fitter
from deltactl.diagnosis.observations.readings import FloatArray
from deltactl.diagnosis.priors.options import PENALTIES


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
                effect=candidate.effect, component=candidate.component,
                parameters=parameters(term, cov[part, part]), usual=usual,
                times_usual=float(np.linalg.norm(off)) / usual,
            )
        )  # fmt: skip
    return sorted(found, key=lambda one: -one.times_usual)


def _clear(off: FloatArray, cov: FloatArray) -> bool:
    """Whether fitted numbers (k,) are as far off nothing as chance hardly brings them."""
    gain = float(off @ np.linalg.pinv(cov, hermitian=True) @ off)
    return bool(chi2.sf(gain, len(off)) < chi2.sf(ASSESSMENT.clearly_off**2, 1))
