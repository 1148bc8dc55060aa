"""Build tolerances that a fit has used: what is off on the machine and no finding."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from scipy.special import chdtrc

from deltactl.diagnosis.answer.records import AllowedFor
from deltactl.diagnosis.assessment.intervals import parameters
from deltactl.diagnosis.assessment.options import ASSESSMENT
from deltactl.diagnosis.observations.readings import FloatArray
from deltactl.diagnosis.plants.delta.point import key_of
from deltactl.diagnosis.plants.nuisance import Nuisance
from deltactl.diagnosis.priors.options import PENALTIES


def allowed_for(
    tolerances: Sequence[Nuisance], sizes: dict[str, FloatArray], known: dict[str, FloatArray]
) -> list[AllowedFor]:
    """Tolerances that are clearly not nothing, the one farthest off first.

    sizes: fitted (k,), with their covariances (k, k), by the names of the free columns.
    """
    found = []
    for nuisance in tolerances:
        candidate, key = nuisance.term.candidate, key_of(nuisance.term.candidate)
        off, covariance = sizes.get(key, np.zeros(0)), known.get(key, np.zeros((0, 0)))
        if len(off) != len(candidate.moved) or not _clear(off, covariance):
            continue
        at = nuisance.term.at.copy()
        at[candidate.moved] += off
        usual = PENALTIES.within * max(nuisance.spread)
        found.append(
            AllowedFor(
                effect=candidate.effect,
                component=candidate.component,
                parameters=parameters(nuisance.term.moved_to(at), covariance),
                usual=usual,
                times_usual=float(np.linalg.norm(off)) / usual,
            )
        )
    return sorted(found, key=lambda one: -one.times_usual)


def _clear(off: FloatArray, covariance: FloatArray) -> bool:
    """Whether fitted numbers (k,) are as far off nothing as chance hardly brings them."""
    gain = float(off @ np.linalg.pinv(covariance, hermitian=True) @ off)
    return bool(chdtrc(len(off), gain) < chdtrc(1, ASSESSMENT.clearly_off**2))
