"""Frequentist guards beside the posterior: the alarm keeps its own level."""

from __future__ import annotations

import numpy as np
from scipy.stats import f

from diagnosis.assessment.options import ASSESSMENT
from diagnosis.evidence.laplace import Explanation
from diagnosis.selection.named_first import Selected


def charge(selected: Selected) -> float:
    """Chi-square that effects of the robot file may leave of themselves (`Discrepancy`).

    Found in a recording, an effect and its discrepancy are weighed together. Once the file has it,
    the next diagnosis would take for a second effect what is the first.
    """
    whiten, left = selected.noise.whiten, selected.empty.residual
    now = float(np.sum(whiten(left) ** 2))
    parts = [(share, whiten(left + alone)) for share, alone in selected.plant.left_by_known]
    return sum(share * max(float(white @ white) - now, 0.0) for share, white in parts)


def chance(
    selected: Selected, better: Explanation, worse: Explanation, charged: float = 0.0
) -> float:
    """p of what one explanation gains over a smaller one, all that was tried counted.

    The noise is estimated from as many effective readings as there are (F test), and every
    regressor could have been the one (Sidak's correction, to first order). charged: chi-square
    that has to be explained before anything is (`charge`).
    """
    gain = worse.chi2 - better.chi2 - charged
    more = max(better.tangent.shape[1] - worse.tangent.shape[1], 1)
    left = max(selected.noise.effective - better.tangent.shape[1], 3.0)
    if gain <= 0.0:
        return 1.0
    scale = max(better.chi2 / left, 1.0)
    single = float(f.sf(gain / more / scale, more, left))
    return min(1.0, single * tests(selected))


def tests(selected: Selected) -> float:
    """Effective number of tests of a selection."""
    every = selected.plant.regressors
    return sum(ASSESSMENT.starts if r.places is None else r.places for r in every)
