"""The whole way from a lone axis (or sensor) with its recording to the answer."""

from __future__ import annotations

from collections.abc import Callable, Sequence

import numpy as np

from diagnosis.admission.axis_plausibility import check_direction, check_outcome, check_times
from diagnosis.answer.records import Diagnosis, Finding, Fit, NotTestable, Verdict
from diagnosis.estimation.estimate import Solution
from diagnosis.evidence.noise_estimation import Prepared, prepare
from diagnosis.lone_axes.axis_answer import AxisOutcome, doubtful, findings, picture, unexplained
from diagnosis.lone_axes.axis_holdout import held_blocks, other_run
from diagnosis.lone_axes.axis_prepare import prepare_again, prepare_axis
from diagnosis.lone_axes.axis_search import AxisSearch
from diagnosis.lone_axes.axis_words import summary
from diagnosis.observations.readings import FloatArray
from diagnosis.plants.candidate import Term
from diagnosis.plants.commanded_axis import AxisModel
from diagnosis.plants.contract import Model
from diagnosis.plants.forced_axis import EffortAxisModel
from diagnosis.plants.range_sensor import RangeSensorModel
from diagnosis.selection.detection_limits import limits
from foundation.errors import RecordingError
from models.effects.lone_axis import COMPONENT
from models.robot import RangeSensor, ServoAxis, StepperAxis
from recording.flat import FlatRecording

Progress = Callable[[str], None]
LoneRobot = StepperAxis | ServoAxis | RangeSensor
LoneModel = AxisModel | EffortAxisModel | RangeSensorModel
MISSING = 0.01
REST_SHARE = 0.05
FOLLOWING_SHARE = 1e-4
FORCED_SHARE = 2e-3
"""Least share of the mismatch for a finding; friction at a measured speed is less exact."""
FORCED_BLUR = 0.015
"""Chi-square per reading that sampling may make: nobody knows what an effort did in between."""
NOT_SEEN = {"joint_compliance": "the load on the axis is not known (no gravity, no load column)"}
LIKELIER = {
    "stepper_axis": (("joint_friction", 4.0),),
    "servo_axis": (("gear_backlash", 10.0),),
    "range_sensor": (("sensor_latency", -8.0),),
}
"""Of two operators that are one in the data, what is said first; the other is an alternative."""


def model_of(robot: LoneRobot, recordings: Sequence[FlatRecording]) -> LoneModel:
    """The model that fits robot and columns. Raises RecordingError for bad input."""
    if not recordings:
        raise RecordingError("no recording was given")
    if isinstance(robot, RangeSensor):
        return RangeSensorModel(robot, recordings)
    forced = all(r.has("effort") and np.isfinite(r.columns["effort"]).any() for r in recordings)
    if forced and isinstance(robot, ServoAxis) and robot.inertia is not None:
        return EffortAxisModel(robot, recordings)
    return AxisModel(robot, recordings)


def diagnose_axis(
    robot: LoneRobot,
    recordings: Sequence[FlatRecording],
    holdout: Sequence[FlatRecording] = (),
    progress: Progress = lambda _: None,
) -> Diagnosis:
    """Diagnose one or several recordings of a lone axis or sensor. Raises RecordingError."""
    model = model_of(robot, recordings)
    others = [model_of(robot, [recording]) for recording in holdout]
    forced = isinstance(model, EffortAxisModel)
    source = recordings[0].source
    check_times(model, source)
    if not forced:
        check_direction(model, source)
    progress("noise of the readings")
    prepare_ = prepare if forced else prepare_axis
    prepared = prepare_(model, model.readings.valid)
    rad_per_step = model.rad_per_step if isinstance(model, AxisModel) else 0.0
    progress("searching for what is missing")
    search = AxisSearch(
        prepared, rad_per_step, progress,
        unlikely=LIKELIER[robot.kind], least_share=FORCED_SHARE if forced else FOLLOWING_SHARE,
        blur=FORCED_BLUR if forced else 0.0,
    )  # fmt: skip
    solution = search.run()
    first_p = search.first_p_of_all(solution)
    hidden, smallest = limits(search)
    outcome = _settled(search, solution, model, forced)
    while (number := doubtful(outcome)) is not None:
        kept = outcome.solution
        others_kept = (*kept.terms[:number], *kept.terms[number + 1 :])
        bare = outcome.search.fitter.solve(others_kept, kept.frees, kept.nuisances)
        outcome = AxisOutcome(outcome.search, bare, outcome.first_cost, outcome.unit)
    progress("what else it could be")
    found = findings(outcome)
    free_zero = not isinstance(robot, RangeSensor) and robot.zero == "arbitrary"
    fit = _fit(outcome, others, free_zero and not forced)
    check_outcome(model, fit, found, getattr(robot, "inertia", None), source)
    share = _left(fit)
    rest, rest_p = unexplained(outcome, share)
    return Diagnosis(
        verdict=_verdict(found, first_p, rest_p, share),
        false_alarm_p=first_p,
        fit=fit,
        findings=found,
        unexplained=rest,
        not_testable=[*hidden, *_not_offered(model)],
        smallest_detectable=smallest,
        says=summary(found, fit, rest, first_p),
        picture=picture(outcome),
    )


def _settled(search: AxisSearch, solution: Solution, model: LoneModel, forced: bool) -> AxisOutcome:
    """Fit once more under the noise that the explanation itself leaves."""
    left = search.fitter.observed - solution.predicted
    last = AxisSearch(
        prepare_again(search.prepared, left, forced), search.rad_per_step, search.progress,
        unlikely=search.unlikely, least_share=search.least_share, blur=search.blur,
    )  # fmt: skip
    final = last.lasting(last.fitter.solve(solution.terms, solution.frees, solution.nuisances))
    return AxisOutcome(last, final, last.empty.cost, model.unit)


def _not_offered(model: LoneModel) -> list[NotTestable]:
    offered = {candidate.effect for candidate in model.candidates}
    return [
        NotTestable(effect=effect, component=COMPONENT, why=why)
        for effect, why in NOT_SEEN.items()
        if isinstance(model, AxisModel) and effect not in offered
    ]


def _fit(outcome: AxisOutcome, others: Sequence[LoneModel], free_zero: bool) -> Fit:
    search, solution = outcome.search, outcome.solution
    prepared: Prepared = search.prepared
    observed, valid = search.fitter.observed, prepared.valid[:, 0]

    def rms(values: FloatArray) -> float:
        return float(np.sqrt(np.mean(np.square(values[valid, 0])))) if valid.any() else 0.0

    believed = prepared.model.predict(_starts(prepared.model))
    if others:
        pairs = [other_run(m, _starts(m), solution, free_zero) for m in others]
        before, after = (float(np.sqrt(np.mean(np.square(x)))) for x in zip(*pairs, strict=True))
    else:
        before, after = held_blocks(search.fitter, solution, believed, prepared.valid)
    last = rms(observed - solution.predicted)
    return Fit(
        rms_before_m=rms(observed - believed),
        rms_after_m=last,
        noise_floor_m=min(rms(prepared.floor), last),
        holdout_rms_before_m=before,
        holdout_rms_after_m=after,
        unit=outcome.unit,
        holdout="run" if others else "blocks",
    )


def _starts(model: Model) -> list[Term]:
    """What the robot file as it stands says of everything that is always fitted."""
    return [nuisance.term for nuisance in model.nuisances]


def _left(fit: Fit) -> float:
    """Share of the mismatch's power that is left above the noise."""
    missing = fit.rms_before_m**2 - fit.noise_floor_m**2
    left = fit.rms_after_m**2 - fit.noise_floor_m**2
    return float(np.clip(left / missing, 0.0, 1.0)) if missing > 0.0 else 0.0


def _verdict(found: list[Finding], p: float, rest_p: float, share: float) -> Verdict:
    if not found:
        return "nothing_missing" if p > MISSING else "unexplained"
    if all(finding.effect == "unknown" for finding in found):
        return "unexplained"
    if any(finding.effect == "unknown" for finding in found):
        return "partly_explained"
    return "partly_explained" if rest_p < MISSING and share > REST_SHARE else "explained"
