"""How likely chance is, and how far a probability hangs on the priors of sizes."""

from __future__ import annotations

import math
from collections.abc import Sequence

import numpy as np
from scipy.special import fdtrc

from deltactl.diagnosis.answer.records import Finding, PriorSensitivity
from deltactl.diagnosis.assessment.options import ASSESSMENT
from deltactl.diagnosis.evidence.effective_size import TemperedNoise, spare
from deltactl.diagnosis.evidence.explanation import Explanation
from deltactl.diagnosis.observations.readings import FloatArray
from deltactl.diagnosis.plants.regression import RegressionPlant
from deltactl.diagnosis.plants.regressor import Regressor
from deltactl.diagnosis.priors.options import SIZE_PRIORS
from deltactl.diagnosis.selection.named_first import Selected, named_sizes
from deltactl.diagnosis.selection.options import CREDIBLE


def charge(plant: RegressionPlant, noise: TemperedNoise, known: Explanation) -> float:
    """Chi-square that effects of the robot file may leave of themselves (`Discrepancy`).

    known: the explanation beyond which more is looked for, under this noise.

    Found in a recording, an effect and its discrepancy are weighed together. Once the file has it,
    the next diagnosis would take for a second effect what is the first.
    """
    if plant.messy:  # which charges each set for itself
        return 0.0
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
    gain = _cost(worse) - _cost(better) - charged - (better.charged - worse.charged)
    more = max(better.tangent.shape[1] - worse.tangent.shape[1], 1)
    left = max(spare(selected.noise.effective, better.tangent.shape[1]), 3.0)
    if gain <= 0.0:
        return 1.0
    scale = max(better.chi2 / left, 1.0)
    single = float(fdtrc(more, left, gain / more / scale))
    return min(1.0, single * tests(selected))


def _cost(explanation: Explanation) -> float:
    """Chi-square with that of tolerances, each of which is a reading of zero: what they are
    stretched for is not explained.
    """
    free = explanation.linear[""]
    stretched = free / explanation.spreads[: len(free)]
    return explanation.chi2 + float(stretched @ stretched)


def calibrated(probability: float, p: float) -> float:
    """At most how probable a hypothesis still is that a test rejects with p.

    By the bound -e p log p on the Bayes factor for it (Sellke, Bayarri and Berger 2001, Am. Stat.
    55, 62-71).
    """
    if p >= 1.0 / math.e:
        return probability
    factor = -math.e * p * math.log(p)
    probability = min(probability, 1.0 - CREDIBLE.lapse)  # no certainty beside what has no name
    return factor * probability / (factor * probability + 1.0 - probability)


def tests(selected: Selected) -> float:
    """Effective number of tests of a selection."""
    every = selected.plant.regressors
    return sum(ASSESSMENT.starts if r.places is None else r.places for r in every)


def prior_sensitivity(selected: Selected) -> list[PriorSensitivity]:
    """Each regressor whose probability depends on the spread of the priors."""
    found = []
    by_key = {r.key: r for r in selected.plant.regressors}
    factors = (1.0 / SIZE_PRIORS.known_to, SIZE_PRIORS.known_to, 1.0)
    narrower, wider, here = probabilities(selected, factors)
    for key in sorted(selected.best.found & here.keys()):
        now = here[key]
        if max(abs(narrower[key] - now), abs(wider[key] - now)) > ASSESSMENT.matters:
            one = by_key[key]
            found.append(
                PriorSensitivity(
                    effect=one.effect,
                    component=one.component,
                    probability=now,
                    narrower=narrower[key],
                    wider=wider[key],
                )
            )
    return found


def as_found(
    changes: Sequence[PriorSensitivity], found: Sequence[Finding]
) -> list[PriorSensitivity]:
    """Those of findings, on the scale of the probability that each finding states.

    An effect that acts like others shares its probability with them, under any prior.
    """
    stated = {(one.effect, one.component): one.probability for one in found}
    told = []
    for one in changes:
        now = stated.get((one.effect, one.component))
        if now is not None and one.probability > 0.0:
            share = now / one.probability
            narrower, wider = min(share * one.narrower, 1.0), min(share * one.wider, 1.0)
            update = {"probability": now, "narrower": narrower, "wider": wider}
            if max(abs(narrower - now), abs(wider - now)) > ASSESSMENT.matters:
                told.append(one.model_copy(update=update))
    return told


def probabilities(selected: Selected, factors: Sequence[float]) -> list[dict[str, float]]:
    """Posterior of each regressor in the counted sets, under spreads times each factor."""
    by_key = {r.key: r for r in selected.plant.regressors}
    counted = [e for e in selected.posterior.explanations if np.isfinite(e.log_evidence)]
    changes = np.array([_changes(e, by_key, factors) for e in counted])
    keys = sorted(set().union(*(e.keys for e in counted)))
    found = []
    for change in changes.T:
        evidence = np.array([e.log_evidence for e in counted]) + change
        weights = np.exp(evidence - evidence.max())
        weights /= weights.sum()
        pairs = list(zip(counted, weights, strict=True))
        found.append({key: float(sum(w for e, w in pairs if key in e.keys)) for key in keys})
    return found


def _changes(
    explanation: Explanation, by_key: dict[str, Regressor], factors: Sequence[float]
) -> list[float]:
    """By how much the log evidence of a set changes with the spreads of its sizes."""
    has_spread = np.array(_has_spread(explanation, by_key), dtype=bool)
    sizes = _in_spreads(explanation)
    gram = explanation.gram
    each = [shape.T @ explanation.white for shape in explanation.shapes]
    along = np.concatenate([np.zeros(0), *each])
    along[explanation.taken] = 0.0
    found = []
    for factor in factors:
        scale = np.where(has_spread, factor, 1.0)
        target = along + gram @ np.where(has_spread & (factor != 1.0), sizes, 0.0)
        now = _log_evidence(gram * np.outer(scale, scale), scale * target)
        found.append(now - _log_evidence(gram, target))
    return found


def _log_evidence(gram: FloatArray, along: FloatArray) -> float:
    """Log evidence of a linear model whose sizes have unit spread, but for a constant.

    gram: products (p, p) of the shapes; along: with the model error, (p,).
    """
    known = np.eye(len(gram)) + gram
    explained = float(along @ np.linalg.solve(known, along))
    return 0.5 * (explained - float(np.linalg.slogdet(known)[1]))


def _has_spread(explanation: Explanation, by_key: dict[str, Regressor]) -> list[bool]:
    """Which columns of the tangent have a prior of size: not what is free, nor places and
    periods, of which any is as likely.
    """
    flat = {
        f"{key}.{size.name}"
        for key in explanation.keys
        for size in by_key[key].sizes
        if size.prior == "flat"
    }
    return [not name.startswith(".") and name not in flat for name in explanation.names]


def _in_spreads(explanation: Explanation) -> FloatArray:
    """Sizes (p,) in prior spreads, in the order of the tangent's columns."""
    sizes = named_sizes(explanation)
    return np.array([sizes[n] for n in explanation.names]) / explanation.spreads
