"""Whether recordings of one machine agree: the sizes of each by itself, and a chi-square of them.

The set of effects is the one chosen with all recordings. Where sizes differ by more than their
intervals, something differs between the recordings that the model does not know, and a common
size is only as sure as the recordings agree (Birge 1932, Phys. Rev. 40, 207-227).
"""

from __future__ import annotations

import math
from collections.abc import Iterable, Mapping, Sequence
from itertools import repeat

import numpy as np
from scipy.special import chdtrc

from deltactl.diagnosis.answer.records import Agreement, Finding, ParameterResult
from deltactl.diagnosis.assessment.intervals import NORMAL_95
from deltactl.diagnosis.assessment.regression_holdout import LASTING
from deltactl.diagnosis.evidence.explanation import Explanation
from deltactl.diagnosis.evidence.laplace import Laplace
from deltactl.diagnosis.evidence.tempering import saturated_noise
from deltactl.diagnosis.pipelines.options import REGRESSION
from deltactl.diagnosis.pipelines.regression_findings import drawn, own, parameter
from deltactl.diagnosis.plants.regression import RegressionPlant
from deltactl.diagnosis.selection.named_first import Selected

NOT_COMPARED = frozenset({"phase", "amplitude_2", "phase_2", "time_constant"})
"""Parameters that only say where or how fast something else is."""


def agreement(selected: Selected, singles: Sequence[RegressionPlant]) -> list[Agreement]:
    """The sizes of the named effects that each recording by itself can show, from one plant a
    recording; empty for one recording.
    """
    keys = frozenset(
        key for key in selected.best.found if key not in LASTING and selected.plant.shown(key)
    )
    if len(singles) < 2 or not keys:
        return []
    # A recording by itself may show less than all together: none of play if it never turns back.
    tried = [keys & {one.key for one in plant.regressors if not one.constant} for plant in singles]
    keys = frozenset.intersection(*tried)
    if not keys:
        return []
    fits = [_alone(selected, *one) for one in zip(singles, tried, strict=True)]
    by_key = {r.key: r for r in selected.plant.regressors}
    return [
        _compared(by_key[key].effect, by_key[key].component, name, known)
        for key in sorted(keys)
        for name, known in _in_all(map(_sizes, singles, fits, repeat(key))).items()
        if name not in NOT_COMPARED
    ]


def _in_all(sizes: Iterable[Mapping[str, ParameterResult]]) -> dict[str, list[ParameterResult]]:
    """The sizes that every recording has, by name."""
    each = list(sizes)
    return {
        name: [one[name] for one in each] for name in each[0] if all(name in one for one in each)
    }


def _alone(selected: Selected, plant: RegressionPlant, keys: frozenset[str]) -> Explanation:
    """The chosen set, or what of it one recording can show, on that recording."""
    plant.adopt(selected.plant)
    evidence = Laplace(plant, saturated_noise(plant))
    return evidence(keys, [evidence(())])


def _sizes(plant: RegressionPlant, fit: Explanation, key: str) -> dict[str, ParameterResult]:
    draws = drawn(fit, key, plant, REGRESSION.posterior_draws, np.random.default_rng(0))
    pairs = [(one.name, parameter(one, own(fit, key), draws)) for one in plant.shown(key)]
    return {name: result for name, result in pairs if result is not None}


def _compared(
    effect: str, component: str, name: str, sizes: Sequence[ParameterResult]
) -> Agreement:
    """Chi-square of one size over the recordings, each weighed by its interval."""
    values, errors = np.array([_value_and_error(size) for size in sizes]).T
    weight = 1.0 / errors**2
    common = float((weight @ values) / weight.sum())
    total = float(weight @ (values - common) ** 2)
    p = float(chdtrc(len(sizes) - 1, total))
    return Agreement(
        effect=effect, component=component, parameter=name, sizes=list(sizes), chi2=total, p=p
    )


def _value_and_error(size: ParameterResult) -> tuple[float, float]:
    """A size and its standard error; one without an upper end by its lower."""
    ((value, low, high),) = size.components
    ends = [abs(end - value) for end in (low, high) if math.isfinite(end)]
    return value, max(*ends, 1e-12 * max(abs(value), 1e-300)) / NORMAL_95


def widened(findings: Sequence[Finding], agreements: Sequence[Agreement]) -> list[Finding]:
    """Findings whose intervals hold how far the recordings are apart."""
    factors = {
        (a.effect, a.component, a.parameter): math.sqrt(a.chi2 / (len(a.sizes) - 1))
        for a in agreements
    }
    return [_widened(finding, factors) for finding in findings]


def _widened(finding: Finding, factors: Mapping[tuple[str, str, str], float]) -> Finding:
    parameters = {}
    for name, size in finding.parameters.items():
        factor = factors.get((finding.effect, finding.component, name), 1.0)
        parameters[name] = _wider(size, factor) if factor > 1.0 else size
    return finding.model_copy(update={"parameters": parameters})


def _wider(size: ParameterResult, factor: float) -> ParameterResult:
    """By a factor; a size that must be above zero stays there."""
    ((value, low, high),) = size.components
    below, above = factor * (value - low), factor * (high - value)
    new_low = value - below if low <= 0.0 else value / (1.0 + below / value)
    return size.model_copy(update={"ci95": [new_low, value + above]})
