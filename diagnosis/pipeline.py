"""The whole way from a model with its recording to the answer."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from functools import partial
from typing import Any

import numpy as np

from diagnosis.admission.plausibility import check_input
from diagnosis.answer import Outcome, findings, picture, unexplained
from diagnosis.estimation.budget import Patience
from diagnosis.estimation.side_by_side import side_by_side
from diagnosis.evidence.change_points import stale_runs, without_stale
from diagnosis.evidence.detection import Progress
from diagnosis.evidence.noise_estimation import prepare
from diagnosis.experiment import MotionLimits, propose
from diagnosis.observations.readings import BoolArray, FloatArray
from diagnosis.plants.contract import Model
from diagnosis.report.sentences import summary
from diagnosis.result import Diagnosis, Finding, Fit, Unexplained, Verdict
from diagnosis.selection.detection_limits import limits
from diagnosis.selection.holdout import on_another_run, on_blocks, rms
from diagnosis.selection.model_choice import Explained, explain, final_fit

MISSING = 0.005
REST_SHARE = 0.05
"""More than this share left unexplained is said to be only partly explained."""
ENDED_EARLY = (
    "The search ended at its limit of work, with the best it had: not everything was compared "
    "(--thorough compares the rest, which takes longer)."
)


def diagnose_model(
    model: Model,
    rad_per_step: float,
    held_out: Sequence[Model],
    progress: Progress,
    motion_limits: MotionLimits | None = None,
    thorough: bool = False,
) -> Diagnosis:
    """Detect, locate, name, settle, size, hold out. Raises RecordingError for bad input.

    thorough: compare everything, however much work it is.
    """
    check_input(model)
    progress("noise of the readings")
    runs = stale_runs(model.readings)
    patience = Patience() if thorough else Patience.for_rows(len(model.readings.t_s))
    prepared = prepare(model, without_stale(model.readings.valid, model.readings, runs), patience)
    progress("searching for what is missing")
    explained = explain(prepared, rad_per_step, progress)
    fitter, solution = final_fit(explained, prepared.valid)
    outcome = Outcome(explained, fitter, solution, runs)
    tasks: list[Callable[[], Any]] = [
        partial(findings, outcome),
        partial(_fit_and_rest, outcome, prepared.valid, held_out),
    ]
    found, (fit, rest, rest_p) = side_by_side(tasks)
    share = rest.share_of_mismatch
    hidden, smallest = limits(explained.search)
    progress("what run would tell more")
    searched = explained.search
    searched.prepared.bank.forget_white()
    plan = propose(model, searched.fitter.whiten, outcome.stands, explained.solution, motion_limits)
    p = min([explained.first_p, *(run_p for run_p in _stale_p(found))])
    return Diagnosis(
        verdict=_verdict(found, p, rest_p, share),
        false_alarm_p=p,
        fit=fit,
        findings=found,
        unexplained=rest,
        loosely_built=explained.loosely_built,
        ended_early=patience.ended,
        next_experiment=plan.experiment,
        not_testable=hidden,
        smallest_detectable=smallest,
        says=[
            *summary(found, fit, rest, p, explained.loosely_built),
            *([ENDED_EARLY] if patience.ended else []),
            *plan.says,
        ],
        picture=picture(outcome, model.drivers()),
    )


def _stale_p(found: list[Finding]) -> list[float]:
    return [f.evidence.p for f in found if f.effect == "stale_reading"]


def _columns(model: Model) -> tuple[list[int], str]:
    """Channels the RMS is taken over: those in metres, else all."""
    units = model.readings.units
    metres = [i for i, unit in enumerate(units) if unit == "m"]
    return (metres, "m") if metres else (list(range(len(units))), units[0])


def _fit_and_rest(
    outcome: Outcome, valid: BoolArray, held_out: Sequence[Model]
) -> tuple[Fit, Unexplained, float]:
    """How well it fits, here and on held-out data; what is left, and its p."""
    fit = _fit(outcome, valid, outcome.explained.search.prepared.floor, held_out)
    return fit, *unexplained(outcome, _left(fit))


def _fit(outcome: Outcome, valid: BoolArray, floor: FloatArray, held_out: Sequence[Model]) -> Fit:
    model, solution = outcome.fitter.model, outcome.solution
    columns, unit = _columns(model)
    observed = outcome.fitter.observed
    empty = outcome.explained.nominal
    if held_out:
        pairs = [on_another_run(other, empty, solution, columns) for other in held_out]
        before, after = (float(np.sqrt(np.mean(np.square(x)))) for x in zip(*pairs, strict=True))
    else:
        before, after = on_blocks(outcome.fitter, solution, valid, columns)
    return Fit(
        rms_before_m=rms(observed - empty.predicted, valid, columns),
        rms_after_m=rms(observed - solution.predicted, valid, columns),
        noise_floor_m=rms(floor, valid, columns),
        holdout_rms_before_m=before,
        holdout_rms_after_m=after,
        unit=unit,
        holdout="run" if held_out else "blocks",
    )


def _left(fit: Fit) -> float:
    """Share of the mismatch's power that is left above the noise."""
    missing = fit.rms_before_m**2 - fit.noise_floor_m**2
    left = fit.rms_after_m**2 - fit.noise_floor_m**2
    return float(np.clip(left / missing, 0.0, 1.0)) if missing > 1e-30 else 0.0


def _verdict(found: list[Finding], p: float, rest_p: float, share: float) -> Verdict:
    if not found:
        return "nothing_missing" if p > MISSING else "unexplained"
    if all(finding.effect == "unknown" for finding in found):
        return "unexplained"
    if any(finding.effect == "unknown" for finding in found):
        return "partly_explained"
    return "partly_explained" if rest_p < MISSING and share > REST_SHARE else "explained"


__all__ = ["Explained", "diagnose_model"]
