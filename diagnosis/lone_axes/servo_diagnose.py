"""The whole way from a servo delta's recording to the answer, by its disturbance estimates."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import replace

import numpy as np

from diagnosis.answer.records import Channel, Diagnosis, Finding, Fit, Picture, Verdict
from diagnosis.estimation.estimate import Solution
from diagnosis.lone_axes.axis_answer import AxisOutcome, doubtful, findings, unexplained
from diagnosis.lone_axes.axis_holdout import held_blocks, other_run
from diagnosis.lone_axes.axis_prepare import prepare_again, prepare_axis
from diagnosis.lone_axes.axis_search import AxisSearch
from diagnosis.lone_axes.axis_words import summary
from diagnosis.lone_axes.servo_rivals import rivals, swapped
from diagnosis.observations.readings import FloatArray
from diagnosis.plants.candidate import Term
from diagnosis.plants.servo_delta import CHANNEL, UNIT, ServoModel
from diagnosis.selection.detection_limits import limits
from models.robot import DeltaRobot
from recording.flat import FlatRecording

Progress = Callable[[str], None]
MISSING = 0.01
REST_SHARE = 0.05
LEAST_SHARE = 2e-3
BLUR = 0.015
UNLIKELY = (("inertia", 3.0), ("effort_offset", 5.0), ("gravity_error", 1.0))
"""Of causes that fit alike, what is named later."""
REGIMES = {
    "joint_friction": "in motion, with the sign of the speed",
    "gravity_error": "everywhere, by the cosine of the arm's angle",
    "payload": "at all joints, with weight and acceleration of the platform",
    "effort_gain": "wherever there is torque",
}


def diagnose_servo(
    robot: DeltaRobot,
    recordings: Sequence[FlatRecording],
    holdout: Sequence[FlatRecording] = (),
    progress: Progress = lambda _: None,
) -> Diagnosis:
    """Diagnose recordings by angles and disturbances. Raises RecordingError or ConfigError."""
    model = ServoModel(robot, recordings)
    others = [ServoModel(robot, [recording]) for recording in holdout]
    progress("noise of the disturbance estimates")
    prepared = prepare_axis(model, model.readings.valid)
    progress("searching for what is missing")
    search = AxisSearch(
        prepared, 0.0, progress, unlikely=UNLIKELY, least_share=LEAST_SHARE, blur=BLUR
    )
    solution = swapped(search, search.run())
    first_p = search.first_p_of_all(solution)
    hidden, smallest = limits(search)
    outcome = _settled(search, solution.terms, solution)
    while (number := doubtful(outcome)) is not None:
        terms = outcome.solution.terms
        outcome = _settled(search, (*terms[:number], *terms[number + 1 :]), outcome.solution)
    progress("what else it could be")
    found = [_in_own_time(one, model, outcome) for one in findings(outcome)]
    fit = _fit(outcome, model, others)
    share = _left(fit)
    rest, rest_p = unexplained(outcome, share)
    return Diagnosis(
        verdict=_verdict(found, first_p, rest_p, share),
        false_alarm_p=first_p,
        fit=fit,
        findings=found,
        unexplained=rest,
        not_testable=hidden,
        smallest_detectable=smallest,
        says=summary(found, fit, rest, first_p),
        picture=_picture(outcome, model),
    )


def _settled(search: AxisSearch, terms: Sequence[Term], start: Solution) -> AxisOutcome:
    """Fit once more under the noise that the explanation itself leaves."""
    solution = search.fitter.solve(terms, start.frees, start.nuisances)
    left = search.fitter.observed - solution.predicted
    last = AxisSearch(
        prepare_again(search.prepared, left, forced=False), 0.0, search.progress,
        unlikely=search.unlikely, least_share=search.least_share, blur=search.blur,
    )  # fmt: skip
    final = last.fitter.solve(solution.terms, solution.frees, solution.nuisances)
    return AxisOutcome(last, final, last.empty.cost, UNIT)


def _in_own_time(finding: Finding, model: ServoModel, outcome: AxisOutcome) -> Finding:
    """Its place in the recording's own time, and what else it could be at which joint."""
    first = float(model.readings.t_s[0])
    where = finding.where.model_copy(
        update={
            "axes": _axes(finding.component),
            "times_s": [(first, first + model.span_s)],
            "regime": REGIMES.get(finding.effect, finding.where.regime),
        }
    )
    return finding.model_copy(update={"where": where, "alternatives": rivals(outcome, finding)})


def _axes(component: str) -> list[str]:
    if component.startswith("motor"):
        return [f"{CHANNEL}_{component[-1]}"]
    return [f"{CHANNEL}_{joint}" for joint in (1, 2, 3)]


def _fit(outcome: AxisOutcome, model: ServoModel, others: Sequence[ServoModel]) -> Fit:
    search, solution = outcome.search, outcome.solution
    observed, valid = search.fitter.observed, model.readings.valid[:, 0]

    def rms(values: FloatArray) -> float:
        return float(np.sqrt(np.mean(np.square(values[valid, 0]))))

    starts = [nuisance.term for nuisance in model.nuisances]
    believed = model.predict(starts)
    if others:
        pairs = [_other(other, solution) for other in others]
        before, after = (float(np.sqrt(np.mean(np.square(x)))) for x in zip(*pairs, strict=True))
    else:
        before, after = held_blocks(search.fitter, solution, believed, model.readings.valid)
    last = rms(observed - solution.predicted)
    return Fit(
        rms_before_m=rms(observed - believed),
        rms_after_m=last,
        noise_floor_m=min(rms(search.prepared.floor), last),
        holdout_rms_before_m=before,
        holdout_rms_after_m=after,
        unit=UNIT,
        holdout="run" if others else "blocks",
    )


def _other(other: ServoModel, solution: Solution) -> tuple[float, float]:
    """RMS before and after on another recording, nothing refitted.

    Lateness is a term of the model it was made by, so it is handed on by its value.
    """
    starts = [nuisance.term for nuisance in other.nuisances]
    late = [
        Term(new.candidate, old.at) for new, old in zip(starts, solution.nuisances, strict=True)
    ]
    fitted = replace(solution, nuisances=tuple(late))
    return other_run(other, starts, fitted, free_zero=False)


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


def _picture(outcome: AxisOutcome, model: ServoModel) -> Picture:
    """One channel a joint, in the recording's own time."""
    readings, noise = model.readings, outcome.search.fitter.whiten.channels[0].spread
    observed = np.where(readings.valid, readings.values, np.nan)[:, 0]
    third = len(observed) // 3
    channels = [
        Channel(
            name=f"{CHANNEL}_{joint + 1}", unit=UNIT, observed=observed[rows],
            before=outcome.search.empty.predicted[rows, 0],
            after=outcome.solution.predicted[rows, 0], noise=noise,
        )
        for joint, rows in enumerate(slice(third * j, third * (j + 1)) for j in range(3))
    ]  # fmt: skip
    names = {"position": "theta", "velocity": "speed"}
    drivers = {
        f"{new}_{joint + 1}": model.drivers()[old][third * joint : third * (joint + 1)]
        for old, new in names.items()
        for joint in range(3)
    }
    return Picture(t_s=readings.t_s[:third], channels=channels, drivers=drivers)
