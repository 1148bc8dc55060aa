"""Findings of effects that were fitted together, with their sizes, alternatives and shares."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from functools import partial

import numpy as np

from deltactl.diagnosis.answer.options import VERDICT
from deltactl.diagnosis.answer.records import (
    Alternative,
    Channel,
    Evidence,
    Finding,
    ParameterResult,
    Picture,
    Table,
    Where,
)
from deltactl.diagnosis.answer.verdict import Rest, rather_unknown, seen
from deltactl.diagnosis.assessment import intervals
from deltactl.diagnosis.assessment.holdout import counted_columns, rms
from deltactl.diagnosis.assessment.intervals import covariance, parameters
from deltactl.diagnosis.assessment.options import ASSESSMENT
from deltactl.diagnosis.estimation.estimate import Solution, without
from deltactl.diagnosis.estimation.least_squares import Fitter
from deltactl.diagnosis.estimation.side_by_side import side_by_side
from deltactl.diagnosis.estimation.splines import SplineTerm
from deltactl.diagnosis.evidence.left_by_measured import held_to
from deltactl.diagnosis.observations.readings import (
    BoolArray,
    FloatArray,
    IntArray,
    without_outliers,
)
from deltactl.diagnosis.observations.stale_readings import Stale
from deltactl.diagnosis.pipelines.options import UNKNOWN
from deltactl.diagnosis.plants.traits import traits_of
from deltactl.diagnosis.priors.tolerances import within_tolerance
from deltactl.diagnosis.score_tests.change_points import moment
from deltactl.diagnosis.score_tests.chi2_tail import log_sf
from deltactl.diagnosis.score_tests.hysteresis import has_memory, tied_drivers
from deltactl.diagnosis.selection.ambiguity import Standing
from deltactl.diagnosis.selection.imitation import Beside
from deltactl.diagnosis.selection.model_choice import Explained
from deltactl.diagnosis.selection.options import CREDIBLE
from deltactl.models.effects import Search, found_by

LEAST_GAIN = 1e-30
REFIT_STEPS = 4


def left_without(fitter: Fitter, solution: Solution, number: int) -> float:
    """Root mean square without a term; number: of the term."""
    bare = fitter.solve(
        without(solution.terms, number), solution.frees, solution.nuisances, steps=REFIT_STEPS
    )
    return _left_by(fitter, solution, [bare.predicted])[0]


def share_and_left(
    fitter: Fitter, nominal: Solution, solution: Solution, number: int, whole: FloatArray
) -> tuple[float, float] | None:
    """Share of the model error, and what is left without it (root mean square); number: of the
    term.

    None of an effect of which the robot file holds nothing. nominal: as the file foretells. whole:
    prediction by all nuisances and terms.
    """
    key = solution.terms[number].candidate.key
    if key not in {nuisance.term.candidate.key for nuisance in held_to(fitter)}:
        return None
    others = [*solution.nuisances, *without(solution.terms, number)]
    left_out = fitter.model.predict(others) + solution.predicted - whole
    every = (nominal.predicted, solution.predicted, left_out)
    before, after, left = _left_by(fitter, solution, every)
    return (left**2 - after**2) / max(before**2 - after**2, LEAST_GAIN), left


def _left_by(fitter: Fitter, solution: Solution, every: Sequence[FloatArray]) -> list[float]:
    """By each prediction in the channels of the fit's figures, without the solution's outliers."""
    model, observed = fitter.model, fitter.observed
    valid = without_outliers(observed - solution.predicted, model.readings.valid)
    columns, _ = counted_columns(model)
    return [rms(observed - predicted, valid, columns) for predicted in every]


@dataclass(frozen=True, slots=True, eq=False)
class Outcome:
    """Everything the answer is made of."""

    explained: Explained
    fitter: Fitter
    solution: Solution
    stale: Sequence[Stale]


def findings(outcome: Outcome) -> list[Finding]:
    """All findings, the one that explains most first; what every machine may have comes last."""
    solution, model = outcome.solution, outcome.fitter.model
    cov = covariance(outcome.fitter, solution)
    total = max(outcome.explained.nominal.cost - outcome.explained.solution.cost, 1e-9)
    tasks = [
        *(partial(_free, outcome, number, total) for number in range(len(solution.frees))),
        *(
            partial(_named, outcome, k, cov, stand, total)
            for k, stand in enumerate(outcome.explained.stands)
        ),
    ]
    found = side_by_side(tasks)
    found += [_stale(outcome, run) for run in outcome.stale]
    small = {t.candidate.key[:2] for t in solution.terms if within_tolerance(model, t)}
    return sorted(
        found,
        key=lambda f: ((f.effect, f.component) in small, rather_unknown(f), -f.evidence.delta_chi2),
    )


def _named(
    outcome: Outcome, number: int, cov: FloatArray, stand: Standing, total: float
) -> Finding:
    solution, model = outcome.solution, outcome.fitter.model
    term = solution.terms[number]
    candidate = term.candidate
    part = solution.columns_of(number)
    rad_per_step = outcome.explained.search.rad_per_step
    jump = moment(outcome.fitter, solution, number, rad_per_step)
    profiled = intervals.by_profile(outcome.fitter, solution, number, cov[part, part])
    readings = model.readings
    times, numbers = readings.whole, list(range(1, len(readings.shift_s) + 1))
    if jump is not None:
        numbers = [readings.recording_of(jump.time_s)]
        begin, end = readings.whole[numbers[0] - 1]
        shift = readings.shift_s[numbers[0] - 1]
        low, high = (float(np.clip(x - shift, begin, end)) for x in jump.interval_s)
        profiled = {"time": (low, high)}
        times = [(jump.time_s - shift, end)]
    sizes = parameters(term, cov[part, part], profiled)
    if jump is not None:
        sizes["time"] = sizes["time"].model_copy(update={"value": times[0][0]})
    whole = model.predict([*solution.nuisances, *solution.terms])
    change = outcome.fitter.change_by(solution, number, whole)
    held = share_and_left(outcome.fitter, outcome.explained.nominal, solution, number, whole)
    share, left = held or (stand.gain / total, left_without(outcome.fitter, solution, number))
    chances = outcome.explained.credible
    other = chances.alternatives[number]
    return Finding(
        effect=candidate.effect,
        component=candidate.component,
        parameters=sizes,
        spread=intervals.spreads(solution, cov)[number],
        where=Where(
            axes=_axes(outcome.fitter, change),
            times_s=times,
            recordings=numbers,
        ),
        evidence=Evidence(delta_chi2=stand.gain, p=stand.p),
        share_of_mismatch=float(np.clip(share, 0.0, 1.0)),
        left_without_m=left,
        probability=chances.terms[number],
        alternatives=[
            *_imitated(chances.beside[number], stand.gain),
            *(
                one.model_copy(update={"probability": other.get((one.effect, one.component), 0.0)})
                for one in stand.alternatives
            ),
        ],
    )


def _imitated(beside: Beside, gain: float) -> list[Alternative]:
    """The unknown that a name rather imitates; gain: by which the fit worsens without the name."""
    if beside.own >= VERDICT.even:
        return []
    probability = (1.0 - beside.own) * (1.0 - CREDIBLE.lapse)
    return [
        Alternative(
            effect="unknown", component=beside.place, delta_chi2=gain, probability=probability
        )
    ]


def _axes(fitter: Fitter, change: FloatArray) -> list[str]:
    """Channels that show a change, in standard deviations of their noise."""
    power = np.mean(fitter.in_noise(change) ** 2, axis=0)
    names = fitter.model.readings.names
    order = np.argsort(-power)
    return [names[i] for i in order if power[i] >= ASSESSMENT.share_of_axis * power.sum()]


def _free(outcome: Outcome, number: int, total: float) -> Finding:
    solution, model = outcome.solution, outcome.fitter.model
    free = solution.frees[number]
    search = outcome.explained.search
    others = (*solution.frees[:number], *solution.frees[number + 1 :])
    bare = outcome.fitter.solve(solution.terms, others, solution.nuisances, steps=4)
    gain = max(bare.cost - solution.cost, 0.0)
    tied = tied_drivers(outcome.fitter, bare, free, search.prepared.shapes)
    instead = list(dict.fromkeys(name for covariate in tied for name in covariate.split(", ")))
    first = sum(f.size for f in solution.frees[:number])
    coefficients = solution.coefficients[first : first + free.size]
    values = free.basis @ coefficients
    size = float(np.std(values[_decided(outcome.fitter, free)]))
    unit = traits_of(model).units.get(free.location, model.readings.units[0])
    half = 1.96 * size / max(np.sqrt(gain), 1.0)
    change = model.inputs()[free.location] * values[:, None]
    return Finding(
        effect="unknown",
        component=free.location,
        parameters={
            "size_rms": ParameterResult(value=size, ci95=[size - half, size + half], unit=unit)
        },
        where=Where(
            axes=_axes(outcome.fitter, change),
            times_s=model.readings.whole,
            recordings=list(range(1, len(model.readings.shift_s) + 1)),
        ),
        evidence=Evidence(delta_chi2=gain, p=search.tests.p(log_sf(gain, free.size))),
        share_of_mismatch=float(np.clip(gain / total, 0.0, 1.0)),
        probability=outcome.explained.credible.shapes[number],
        depends_on=list(dict.fromkeys([*free.depends_on, *instead])),
        tied=[name for name in instead if name not in free.depends_on],
        has_memory=has_memory(outcome.fitter, solution, free, gain),
        table=_table(outcome.fitter, free, coefficients),
    )


def _table(fitter: Fitter, free: SplineTerm, coefficients: FloatArray) -> Table | None:
    """A spline as numbers over its covariate, where readings decided; None for other shapes."""
    if free.kind != "spline":
        return None
    model = fitter.model
    covariate = model.covariates()[free.covariate][_decided(fitter, free)]
    places = np.linspace(float(covariate.min()), float(covariate.max()), UNKNOWN.places_in_table)
    size = np.asarray(free.basis_for(places) @ coefficients)
    return Table(
        follows=free.covariate,
        lowest=float(places[0]),
        highest=float(places[-1]),
        size=size.tolist(),
    )


def _decided(fitter: Fitter, free: SplineTerm) -> IntArray:
    """Rows in which a valid reading tells the value of a spline term; none holds it elsewhere."""
    rows = fitter.whiten.rows
    moved = fitter.model.inputs()[free.location][rows, fitter.whiten.channel] != 0.0
    decided: IntArray = np.unique(rows[moved])
    return decided


def _stale(outcome: Outcome, run: Stale) -> Finding:
    readings = outcome.fitter.model.readings
    begin, end = (float(readings.t_s[i]) for i in (run.first, run.last))
    own_begin, own_end = readings.own_time_s(begin), readings.own_time_s(end)
    column = readings.names.index(run.channel)
    rows = slice(run.first, run.last + 1)
    noise = outcome.fitter.whiten.channels[column]
    miss = readings.values[rows, column] - outcome.solution.predicted[rows, column]
    # It began after the last reading that was new and ended before the next; neighbours that
    # happen to be equal make it look one or two longer, nothing makes it look shorter.
    number = [readings.recording_of(begin)]
    half, seconds = readings.period_s, end - begin + readings.period_s
    own_end += 0.5 * half
    own_begin -= 0.5 * half
    return Finding(
        effect=found_by(Search.REPEATS).name,
        component=run.channel,
        parameters={
            "times_s": ParameterResult(
                value=[own_begin, own_end],
                ci95=[[own_begin - half, own_begin + half], [own_end - half, own_end + half]],
                unit="s",
            ),
            "duration": ParameterResult(
                value=seconds, ci95=[seconds - 2.5 * half, seconds + half], unit="s"
            ),
        },
        where=Where(axes=[run.channel], times_s=[(own_begin, own_end)], recordings=number),
        evidence=Evidence(
            delta_chi2=float(np.nansum(miss**2)) / noise.spread**2, p=float(np.exp(run.log_p))
        ),
        probability=1.0 - float(np.exp(run.log_p)),
        share_of_mismatch=1.0 if not (outcome.solution.terms or outcome.solution.frees) else 0.0,
    )


def rest(outcome: Outcome) -> Rest:
    """What the tests say of what is left."""
    tests, solution = outcome.explained.search.tests, outcome.explained.solution
    scores = tests.scores(solution)
    ranked = [
        (entry.free, float(scores.gain[i]), float(scores.log_p[i]))
        for i, entry in enumerate(tests.prepared.library.entries)
        if entry.free
    ]
    free, gain, log_p = min([*ranked, *tests.fine_scores(solution)], key=lambda item: item[2])
    p = tests.p(float(min(log_p, scores.log_p.min())))
    if not seen(p):
        return Rest(p)
    share = float(np.clip(gain / solution.cost, 1e-9, 1.0))
    return Rest(p, tuple(free.depends_on), free.location, share)


def picture(outcome: Outcome, covariates: dict[str, FloatArray], counted: BoolArray) -> Picture:
    """Arrays for drawings. counted: readings (n, channels) that the figures of the fit are of."""
    readings = outcome.fitter.model.readings
    before, after = outcome.explained.nominal.predicted, outcome.solution.predicted.copy()
    for run in outcome.stale:
        column = readings.names.index(run.channel)
        after[run.first : run.last + 1, column] = readings.values[run.first, column]
    observed = np.where(readings.valid, readings.values, np.nan)
    channels = [
        Channel(
            name=name, unit=readings.units[i], observed=observed[:, i], before=before[:, i],
            after=after[:, i], noise=outcome.fitter.whiten.channels[i].spread,
            counted=counted[:, i].astype(np.float64),
        )
        for i, name in enumerate(readings.names)
    ]  # fmt: skip
    return Picture(
        t_s=readings.t_s, channels=channels, covariates=covariates, shift_s=readings.shift_s
    )
