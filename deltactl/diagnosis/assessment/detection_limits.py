"""From which size on an effect would have been seen in a recording."""

from __future__ import annotations

import math
from collections.abc import Iterator

import numpy as np

from deltactl.diagnosis.answer.records import SmallestDetectable
from deltactl.diagnosis.assessment.options import ASSESSMENT
from deltactl.diagnosis.assessment.regression_holdout import scaled_covariance
from deltactl.diagnosis.assessment.significance import charge
from deltactl.diagnosis.observations.readings import FloatArray
from deltactl.diagnosis.plants.regressor import Regressor, Shown, Size
from deltactl.diagnosis.selection.named_first import Selected


def detection_limits(selected: Selected) -> list[SmallestDetectable]:
    """Size of each absent effect that raises the alarm with 80 % power.

    It must gain what effects of the file may leave as well: so much is not held against a file.
    """
    best = selected.best
    charged = charge(selected.plant, selected.noise, best)
    at_sigma = math.hypot(ASSESSMENT.found_at_sigma, math.sqrt(charged))
    found: dict[tuple[str, str], SmallestDetectable] = {}
    for regressor in selected.plant.regressors:
        if regressor.key in best.keys or regressor.left_over or regressor.beside:
            continue
        for one in _limits(selected, regressor, at_sigma):
            found.setdefault((one.effect, one.component), one)
    named = {(r.effect, r.component) for r in selected.plant.regressors if r.key in best.keys}
    return [one for name, one in found.items() if name not in named]


def _limits(
    selected: Selected, regressor: Regressor, at_sigma: float
) -> Iterator[SmallestDetectable]:
    """Detection limits of one regressor, under every name that it may go by."""
    shown = selected.plant.shown(regressor.key)
    if not shown:
        return
    names = [regressor.effect]
    if regressor.sizes:
        more = ASSESSMENT.of_a_second_size if len(regressor.sizes) > 1 else 0.0
        value = _by_secant(selected, regressor, shown[0], math.hypot(at_sigma, more))
        names += [same.effect for same in regressor.equivalents if not same.only_if_zero]
    else:
        value = _by_covariance(selected, regressor, shown[0], at_sigma)
    if value is None:
        return
    for effect in names:
        yield SmallestDetectable(
            effect=effect,
            component=regressor.component,
            parameter=shown[0].name,
            value=value,
            unit=shown[0].unit,
        )


def _by_covariance(
    selected: Selected, regressor: Regressor, shown: Shown, at_sigma: float
) -> float | None:
    best, with_it = selected.best, selected.best.keys | {regressor.key}
    beside = {one.key for one in selected.plant.regressors if one.key in regressor.apart_from}
    more = selected.evidence(with_it | beside, [best])
    at = [i for i, name in enumerate(more.names) if name.startswith(f"{regressor.key}.")]
    if len(at) != 1:
        return None
    spread = at_sigma * float(np.sqrt(scaled_covariance(more, beside)[at[0], at[0]]))
    name = more.names[at[0]][len(regressor.key) + 1 :]
    return abs(float(shown.of({name: np.asarray(spread)})) - shown.nothing)


def _by_secant(
    selected: Selected, regressor: Regressor, shown: Shown, at_sigma: float
) -> float | None:
    """None where no size that was looked for would show."""
    size = next((one for one in regressor.sizes if one.name == shown.name), None)
    if size is None or size.prior != "half":
        return None
    resolution = selected.plant.rounding * math.sqrt(12.0)
    at = size.spread
    for _ in range(ASSESSMENT.secant_rounds):
        information = _information(selected, regressor, size, at)
        if not information > 0.0:
            return None
        at = min(at_sigma / math.sqrt(information), size.high)
    return max(at, resolution) if at < size.high else None


def _information(selected: Selected, regressor: Regressor, size: Size, at: float) -> float:
    """Information on a size, from its secant, less what the chosen set would take over."""
    plant, best, key = selected.plant, selected.best, regressor.key
    own = {f"{key}.{one.name}": max(one.low, 0.0) for one in regressor.sizes}
    own[f"{key}.{size.name}"] = at
    bent = plant.base(best.keys | {key}, {**best.sizes, **own})
    change = selected.noise.whiten(bent - plant.base(best.keys, best.sizes)) / at
    left = change - best.tangent @ _most_probable(change, best.tangent)
    return float(change @ left)


def _most_probable(white: FloatArray, shapes: FloatArray) -> FloatArray:
    """Sizes (p,) of whitened shapes (m, p), each times its prior spread, given values (m,)."""
    gram = shapes.T @ shapes
    return np.linalg.solve(gram + np.eye(len(gram)), shapes.T @ white)
