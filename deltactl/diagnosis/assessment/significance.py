"""Frequentist guards beside the posterior: the alarm keeps its own level."""

from __future__ import annotations

from scipy.stats import f

from deltactl.diagnosis.assessment.options import ASSESSMENT
from deltactl.diagnosis.evidence.effective_size import TemperedNoise, spare
from deltactl.diagnosis.evidence.laplace import Explanation
from deltactl.diagnosis.plants.regression import RegressionPlant
from deltactl.diagnosis.selection.named_first import Selected


def charge(plant: RegressionPlant, noise: TemperedNoise, known: Explanation) -> float:
    """Chi-square that effects of the robot file may leave of themselves (`Discrepancy`).

    known: the explanation beyond which more is looked for, under this noise.

    Found in a recording, an effect and its discrepancy are weighed together. Once the file has it,
    the next diagnosis would take for a second effect what is the first.
    """
    charged = 0.0
    for share, alone in plant.left_by_known:
        without = known.white + noise.whiten(alone)
        charged += share * max(float(without @ without) - known.chi2, 0.0)
    return charged


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
    left = max(spare(selected.noise.effective, better.tangent.shape[1]), 3.0)
    if gain <= 0.0:
        return 1.0
    scale = max(better.chi2 / left, 1.0)
    single = float(f.sf(gain / more / scale, more, left))
    return min(1.0, single * tests(selected))


def tests(selected: Selected) -> float:
    """Effective number of tests of a selection."""
    every = selected.plant.regressors
    return sum(ASSESSMENT.starts if r.places is None else r.places for r in every)
