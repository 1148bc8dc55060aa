"""From a selection of regressors to the contract's findings: sizes, probabilities, alternatives."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from types import MappingProxyType

import numpy as np

from deltactl.diagnosis.answer.records import (
    Alternative,
    Evidence,
    Finding,
    ParameterResult,
    Table,
    Where,
)
from deltactl.diagnosis.answer.verdict import rather_unknown
from deltactl.diagnosis.assessment.intervals import NORMAL_95
from deltactl.diagnosis.assessment.regression_holdout import (
    as_file_says,
    over_what_it_follows,
    scaled_covariance,
)
from deltactl.diagnosis.assessment.significance import chance
from deltactl.diagnosis.evidence.effective_size import spare
from deltactl.diagnosis.evidence.explanation import Explanation
from deltactl.diagnosis.observations.readings import FloatArray, Readings
from deltactl.diagnosis.pipelines.options import REGRESSION
from deltactl.diagnosis.pipelines.regression_figures import rms_left
from deltactl.diagnosis.plants.options import SPLINE_TERMS, UNKNOWN
from deltactl.diagnosis.plants.regression import RegressionPlant
from deltactl.diagnosis.plants.regressor import Equivalent, Regressor, Shown
from deltactl.diagnosis.selection.named_first import Selected, named_sizes
from deltactl.diagnosis.selection.options import CREDIBLE, SELECTION

TABLED = {("position",), ("distance",)}
"""What an unknown follows where numbers over it can be subtracted."""


def findings(selected: Selected, readings: Readings) -> list[Finding]:
    """All findings, the one that explains most first."""
    by_key = {r.key: r for r in selected.plant.regressors}
    places: dict[tuple[str, str], list[Regressor]] = {}
    for key in sorted(selected.best.found):
        one = by_key[key]
        at_place = one.unknown and not one.left_over
        places.setdefault((one.component, "") if at_place else ("", key), []).append(one)
    found = [_finding(selected, together, readings) for together in places.values()]
    return sorted(filter(_likely, found), key=_first)


def _likely(finding: Finding) -> bool:
    """Whether it, or what may be instead of it, is rather there than not."""
    chances = [finding.probability, *(one.probability for one in finding.alternatives)]
    return sum(p or 0.0 for p in chances) >= SELECTION.likely


def _first(finding: Finding) -> tuple[bool, bool, float, float]:
    """What has a name comes first, and of those what most of the model error hangs on; last what
    is more probably a part of something unknown.
    """
    by_chi2, share = finding.evidence.delta_chi2, finding.share_of_mismatch
    return rather_unknown(finding), finding.effect == "unknown", -share, -by_chi2


def _finding(selected: Selected, together: Sequence[Regressor], readings: Readings) -> Finding:
    """together: an effect, or all that has no name at one place."""
    best, regressor, keys = selected.best, together[0], [one.key for one in together]
    without = selected.evidence(best.keys - set(keys), [best])
    bare = as_file_says(selected.plant, without)
    gain = max(without.chi2 - best.chi2, 0.0)
    apart = [_apart(selected, regressor, t) for t in regressor.equivalents]
    log_odds = [t.log_odds - 0.5 * d for t, d in zip(regressor.equivalents, apart, strict=True)]
    odds = np.exp([0.0, *log_odds])
    share = odds / odds.sum()
    probability = min(probability_of(selected, regressor), 1.0)
    whole = sum((_own(selected, key) for key in keys), np.zeros(len(best.base)))
    sized = sizes(selected, regressor.key)
    made, axes = whole[selected.noise.rows], selected.plant.shown_on(whole)
    alone_m, alone_ci95_m = _alone(selected, made, selected.plant.shown(regressor.key), sized)
    alternatives = [
        Alternative(
            effect=t.effect,
            component=regressor.component,
            delta_chi2=d,
            probability=float(probability * s),
        )
        for t, d, s in zip(regressor.equivalents, apart, share[1:], strict=True)
        if probability * s > REGRESSION.least_probability
    ]
    alternatives += _others(selected, regressor)
    imitated = _imitated(selected, regressor, probability, gain)
    if imitated is not None:
        alternatives.insert(0, imitated)
        probability *= CREDIBLE.beside_in_place
    found = Finding(
        effect=regressor.effect,
        component=regressor.component,
        says="",
        parameters=sized,
        spread=selected.plant.spread(
            regressor.key, best.linear[regressor.key], _covariance_of(selected, regressor.key)
        ),
        where=_where(regressor, readings, best, axes),
        evidence=Evidence(delta_chi2=gain, p=chance(selected, best, without)),
        share_of_mismatch=_share(selected, bare),
        own_share=_own_share(selected, made),
        left_without_m=rms_left(bare, selected.noise),
        alone_m=alone_m,
        alone_ci95_m=alone_ci95_m,
        probability=float(probability * share[0]),
        alternatives=alternatives,
        depends_on=list(regressor.follows),
        table=_table(selected, regressor),
    )
    return found.model_copy(update=selected.plant.described(found, keys, best, without))


def _share(selected: Selected, without: Explanation) -> float:
    """How much of the power that the set takes off the model error comes back without one of it.

    Of the model error as it is read: under noise with a memory a constant counts for next to
    nothing.
    """
    each = (as_file_says(selected.plant, selected.empty), selected.best, without)
    before, after, left = (rms_left(one, selected.noise) ** 2 for one in each)
    return float(np.clip((left - after) / max(before - after, 1e-300), 0.0, 1.0))


def _own(selected: Selected, key: str) -> FloatArray:
    """What one effect of the set makes by itself, (n,)."""
    plant, best = selected.plant, selected.best
    base = plant.base(best.keys, best.sizes)
    own = base - plant.base(best.keys - {key}, best.sizes)
    return own + plant.columns(key, base, best.sizes).values @ best.linear[key]


def _own_share(selected: Selected, own: FloatArray) -> float:
    """Share of the model error's power that is its own."""
    whole = rms_left(as_file_says(selected.plant, selected.empty), selected.noise)
    return (selected.noise.rms(own) / max(whole, 1e-150)) ** 2


def _alone(
    selected: Selected,
    own: FloatArray,
    shown: Sequence[Shown],
    sized: Mapping[str, ParameterResult],
) -> tuple[float, tuple[float, float] | None]:
    """The model error with one effect corrected alone, and its ends over the interval of a size."""
    empty = as_file_says(selected.plant, selected.empty)
    left, nothing = empty.residual[selected.noise.rows], shown[0].nothing if shown else 0.0
    known = [np.array(one.components[0]) for one in sized.values()][:1]
    with np.errstate(all="ignore"):  # the smaller a stiffness is, the more it does
        moved = [one - nothing if math.isfinite(nothing) else 1.0 / one for one in known]
        shares = [np.clip(np.nan_to_num(one / one[0], nan=1.0), 0.0, 2.0) for one in moved]
    each = [selected.noise.rms(left - own * x) for x in (1.0, *np.ravel(shares))]
    return each[0], (min(each), max(each)) if known else None


def _table(selected: Selected, regressor: Regressor) -> Table | None:
    """An unknown over the place of an axis or the distance of a target, as numbers."""
    plant, key = selected.plant, regressor.key
    if regressor.follows not in TABLED or not regressor.left_over:
        return None
    known = plant.followed(key)[plant.rows]
    low, high = (float(x) for x in np.quantile(known[np.isfinite(known)], SPLINE_TERMS.covered))
    count = max(plant.detail(key), UNKNOWN.places_in_table)
    size = over_what_it_follows(selected, key, np.linspace(low, high, count))
    follows = regressor.follows[0]
    return Table(follows=follows, lowest=low, highest=high, size=[float(x) for x in size])


def probability_of(selected: Selected, regressor: Regressor) -> float:
    """Probability of an effect at a component, in whichever of its forms (friction by load or
    not)."""
    forms = _forms(selected, regressor)
    own = selected.probability[regressor.key]
    if regressor.left_over or len(forms) == 1:
        return own
    pairs = zip(selected.posterior.explanations, selected.posterior.weights, strict=True)
    return max(own, float(sum(weight for one, weight in pairs if one.keys & forms)))


def _imitated(
    selected: Selected, regressor: Regressor, probability: float, gain: float
) -> Alternative | None:
    """The unknown of any shape in whose place a name is, which it rather imitates."""
    every = [r for r in selected.plant.regressors if r.key in selected.best.found]
    unknown = [r for r in every if r.unknown and not r.saturated]
    if regressor.unknown or regressor.component not in {r.component for r in unknown}:
        return None
    return Alternative(
        effect="unknown",
        component=regressor.component,
        delta_chi2=gain,
        probability=probability * (1.0 - CREDIBLE.beside_in_place),
    )


def _forms(selected: Selected, regressor: Regressor) -> set[str]:
    """Keys of all regressors that are this effect at this component."""
    name = (regressor.effect, regressor.component)
    return {r.key for r in selected.plant.regressors if (r.effect, r.component) == name}


def _apart(selected: Selected, regressor: Regressor, same: Equivalent) -> float:
    """By how much in chi-square the fit is worse with the size at zero that an equivalent needs."""
    if not same.only_if_zero:
        return 0.0
    best, name = selected.best, f"{regressor.key}.{same.only_if_zero}"
    at = best.names.index(name)
    known = math.sqrt(float(scaled_covariance(best)[at, at]))
    least_s = max(
        REGRESSION.as_good_as_none_s, REGRESSION.of_a_row * selected.plant.readings.period_s
    )
    spread = math.hypot(known, selected.shift.get(name, 0.0), least_s)
    return (best.sizes[name] / spread) ** 2


def _others(selected: Selected, regressor: Regressor) -> list[Alternative]:
    """Other regressors that are in sets without this one, with their posterior."""
    posterior, best = selected.posterior, selected.best
    by_key = {r.key: r for r in selected.plant.regressors}
    own = {regressor.key} if regressor.left_over else _forms(selected, regressor)
    weights: dict[str, float] = {}
    worse: dict[str, float] = {}
    for explanation, weight in zip(posterior.explanations, posterior.weights, strict=True):
        if own & explanation.keys:
            continue
        for key in explanation.keys - best.keys:
            weights[key] = weights.get(key, 0.0) + weight
            worse.setdefault(key, explanation.chi2 - best.chi2)
    named = {regressor.effect, *(t.effect for t in regressor.equivalents)}
    return [
        Alternative(
            effect=by_key[key].effect,
            component=component,
            delta_chi2=max(worse[key], 0.0),
            together=bool(by_key[key].members),
            probability=weight,
        )
        for key, weight in sorted(weights.items(), key=lambda pair: -pair[1])
        for component in by_key[key].members or (by_key[key].component,)
        if weight > REGRESSION.least_probability and by_key[key].effect not in named
    ]


def _where(regressor: Regressor, readings: Readings, best: Explanation, axes: list[str]) -> Where:
    times, numbers = readings.whole, list(range(1, len(readings.shift_s) + 1))
    moment = best.sizes.get(f"{regressor.key}.moment")
    if moment is not None:
        number = readings.recording_of(moment)
        times, numbers = [(readings.own_time_s(moment), readings.end_s(number))], [number]
    return Where(axes=axes, times_s=times, recordings=numbers, regime="")


# ---- sizes with intervals ----------------------------------------------------------------------


def sizes(selected: Selected, key: str) -> dict[str, ParameterResult]:
    """Parameters of one regressor at the best set, their intervals over the credible sets."""
    plant, best = selected.plant, selected.best
    known = plant.parameters(key, best.linear[key], _covariance_of(selected, key))
    if known is not None:
        return known
    shown = plant.shown(key)
    if not shown:
        return {"size_rms": _size_of_unknown(selected, key)}
    values = own(best, key)
    draws = _mixture(selected, key)
    found = {}
    for one in shown:
        result = parameter(one, values, draws)
        if result is not None:
            found[one.name] = result
    return found


def _covariance_of(selected: Selected, key: str) -> FloatArray:
    """Covariance (k, k) of the sizes of one regressor, with what they differ by between blocks."""
    best = selected.best
    rows = [i for i, name in enumerate(best.names) if name.startswith(f"{key}.")]
    shift = np.array([selected.shift.get(best.names[i], 0.0) for i in rows])
    found: FloatArray = covariance_as_left(selected)[np.ix_(rows, rows)] + np.diag(shift**2)
    return found


def covariance_as_left(selected: Selected) -> FloatArray:
    """Covariance (p, p) of all sizes under the noise, or what is left where that is more."""
    best = selected.best
    left = max(spare(selected.noise.effective, best.tangent.shape[1]), 3.0)
    return scaled_covariance(best) * max(best.chi2 / left, 1.0)


def parameter(
    shown: Shown, values: Mapping[str, FloatArray], draws: Mapping[str, FloatArray]
) -> ParameterResult | None:
    value = float(shown.of(values))
    drawn = np.asarray(shown.of(draws))
    if shown.name in ("phase", "phase_2"):
        drawn = value + np.angle(np.exp(1j * (drawn - value)))
    low, high = (float(x) for x in np.quantile(drawn, [0.025, 0.975]))
    if shown.name in ("stiffness",) and low < 0.0:
        # One over a number that may be zero: the stiffness has no upper end.
        positive = drawn[drawn > 0.0]
        low, high = float(np.quantile(positive, 0.025)), math.inf
    if not low < high or value == shown.as_without:
        return None
    return ParameterResult(value=value, ci95=[min(low, value), max(high, value)], unit=shown.unit)


def own(explanation: Explanation, key: str) -> dict[str, FloatArray]:
    """Best sizes, those of one regressor by their own names."""
    found = named_sizes(explanation).items()
    return {name.removeprefix(f"{key}."): np.asarray(size) for name, size in found}


def _mixture(selected: Selected, key: str) -> dict[str, FloatArray]:
    """Draws (n,) of each size of a regressor from the sets of the posterior that have it."""
    pairs = zip(selected.posterior.explanations, selected.posterior.weights, strict=True)
    chosen = [(e, w) for e, w in pairs if key in e.keys]
    total = sum(w for _, w in chosen)
    rng = np.random.default_rng(0)
    parts: list[dict[str, FloatArray]] = []
    for explanation, weight in chosen:
        count = round(REGRESSION.posterior_draws * weight / total)
        if count:
            parts.append(drawn(explanation, key, selected.plant, count, rng, selected.shift))
    return {name: np.concatenate([part[name] for part in parts]) for name in parts[0]}


def drawn(
    explanation: Explanation, key: str, plant: RegressionPlant, count: int,
    rng: np.random.Generator, shift: Mapping[str, float] = MappingProxyType({}),
) -> dict[str, FloatArray]:  # fmt: skip
    """Draws from the Gaussian around one set's best sizes, within what a machine can have.

    shift: standard deviation that discrepancy of the model adds to a size, by `key.size`.
    """
    regressor = next(r for r in plant.regressors if r.key == key)
    found, values = _in_gaussian(explanation, regressor, count, rng, shift), own(explanation, key)
    if regressor.measured_by:
        found.setdefault(regressor.measured_by, np.zeros(count))
    for size in regressor.sizes:
        if size.name not in found:
            half = 2.0 * float(np.median(np.diff(plant.t_s)))
            found[size.name] = values[size.name] + half * rng.uniform(-1.0, 1.0, count)
        elif size.prior == "half":
            found[size.name] = np.maximum(found[size.name], 0.0)
    others = {*(size.name for size in regressor.sizes), regressor.measured_by}
    linear = [name for name in found if name not in others]
    least = dict.fromkeys(linear[:1], regressor.above) | dict.fromkeys(regressor.positive, 0.0)
    for name, low in least.items():
        above = found[name][found[name] > low]
        instead = rng.choice(above, count) if len(above) else np.abs(found[name])
        found[name] = np.where(found[name] > low, found[name], instead)
    return found


def _in_gaussian(
    explanation: Explanation,
    regressor: Regressor,
    count: int,
    rng: np.random.Generator,
    shift: Mapping[str, float],
) -> dict[str, FloatArray]:
    """Draws of the sizes that have a covariance; where one would be below zero, it is zero."""
    covariance, values = scaled_covariance(explanation), own(explanation, regressor.key)
    names, prefix = explanation.names, f"{regressor.key}."
    rows = [i for i, n in enumerate(names) if n.startswith(prefix) or n == regressor.measured_by]
    part = covariance[np.ix_(rows, rows)]
    across, spread = np.linalg.eigh(part)[::-1]
    noise = rng.standard_normal((count, len(rows))) * np.sqrt(np.maximum(spread, 0.0))
    moved = noise @ across.T
    halves = {size.name for size in regressor.sizes if size.prior == "half"}
    for at, name in enumerate(names[row].removeprefix(prefix) for row in rows):
        if name in halves and part[at, at] > 0.0:
            # A size below zero becomes zero, and the others change as they correlate with it.
            short = np.minimum(values[name] + moved[:, at], 0.0)
            moved -= short[:, None] * part[at] / part[at, at]
    found = {}
    for i, off in zip(rows, moved.T, strict=True):
        off = off + shift.get(names[i], 0.0) * rng.standard_normal(count)
        found[names[i].removeprefix(prefix)] = values[names[i].removeprefix(prefix)] + off
    return found


def _size_of_unknown(selected: Selected, key: str) -> ParameterResult:
    """Root mean square of a spline term over the rows that count."""
    best = selected.best
    base = selected.plant.base(best.keys, best.sizes)
    columns = selected.plant.columns(key, base, best.sizes)
    shape = (columns.values @ best.linear[key])[selected.plant.rows]
    size = float(np.std(shape))
    without = selected.evidence(best.keys - {key}, [best])
    gain = max(without.chi2 - best.chi2, 1.0)
    half = NORMAL_95 * size / float(np.sqrt(gain))
    unit = selected.plant.unit
    return ParameterResult(value=size, ci95=[max(size - half, 0.0), size + half], unit=unit)
