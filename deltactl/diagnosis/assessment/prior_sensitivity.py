"""How the posterior changes when every prior of a size is three times narrower or wider.

From Laplace's quantities of the sets that count, no fit anew: around the best fit the prediction is
linear, and with S the evidence of a set under spreads s S is known in closed form.
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from deltactl.diagnosis.answer.records import Finding, PriorSensitivity
from deltactl.diagnosis.assessment.options import ASSESSMENT
from deltactl.diagnosis.evidence.laplace import Explanation
from deltactl.diagnosis.observations.readings import FloatArray
from deltactl.diagnosis.plants.regression import Regressor
from deltactl.diagnosis.priors.options import SIZE_PRIORS
from deltactl.diagnosis.selection.named_first import Selected, named_sizes


def prior_sensitivity(selected: Selected) -> list[PriorSensitivity]:
    """Of each regressor whose probability hangs on the spread of the priors."""
    found = []
    by_key = {r.key: r for r in selected.plant.regressors}
    narrower = probabilities(selected, 1.0 / SIZE_PRIORS.known_to)
    wider = probabilities(selected, SIZE_PRIORS.known_to)
    here = probabilities(selected, 1.0)
    for key in sorted(selected.best.keys & here.keys()):
        now = here[key]
        if max(abs(narrower[key] - now), abs(wider[key] - now)) > ASSESSMENT.matters:
            one = by_key[key]
            found.append(
                PriorSensitivity(
                    effect=one.effect, component=one.component, probability=now,
                    narrower=narrower[key], wider=wider[key],
                )
            )  # fmt: skip
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


def probabilities(selected: Selected, factor: float) -> dict[str, float]:
    """Posterior of each regressor in the counted sets under spreads times a factor."""
    by_key = {r.key: r for r in selected.plant.regressors}
    counted = [e for e in selected.posterior.explanations if np.isfinite(e.log_evidence)]
    evidence = np.array([e.log_evidence + _change(e, by_key, factor) for e in counted])
    weights = np.exp(evidence - evidence.max())
    weights /= weights.sum()
    keys = sorted(set().union(*(e.keys for e in counted)))
    return {
        key: float(sum(w for e, w in zip(counted, weights, strict=True) if key in e.keys))
        for key in keys
    }


def _change(explanation: Explanation, by_key: dict[str, Regressor], factor: float) -> float:
    """By how much the log evidence of a set changes with the spreads of its sizes."""
    scale = np.where(_has_spread(explanation, by_key), factor, 1.0)
    theta = np.where(scale == factor, _in_spreads(explanation), 0.0)
    target = explanation.white + explanation.tangent @ theta
    return _log_evidence(explanation.tangent * scale, target) - _log_evidence(
        explanation.tangent, target
    )


def _log_evidence(shapes: FloatArray, target: FloatArray) -> float:
    """Of a linear model whose sizes have unit spread, but for a constant."""
    gram = np.eye(shapes.shape[1]) + shapes.T @ shapes
    along = shapes.T @ target
    explained = float(along @ np.linalg.solve(gram, along))
    return 0.5 * (explained - float(np.linalg.slogdet(gram)[1]))


def _has_spread(explanation: Explanation, by_key: dict[str, Regressor]) -> list[bool]:
    """Which columns of the tangent have a prior of size: not what is free, nor places and
    periods, of which any is as likely.
    """
    flat = {
        f"{key}.{size.name}" for key in explanation.keys for size in by_key[key].sizes
        if size.prior == "flat"
    }  # fmt: skip
    return [not name.startswith(".") and name not in flat for name in explanation.names]


def _in_spreads(explanation: Explanation) -> FloatArray:
    """Sizes (p,) in prior spreads, in the order of the tangent's columns."""
    sizes = named_sizes(explanation)
    theta: FloatArray = np.array([sizes[n] for n in explanation.names]) / explanation.spreads
    return theta
