"""The whole way of a lone machine's recording: plant, noise, selection, sizes, held-out, answer."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import replace

import numpy as np

from diagnosis.admission.regression_plausibility import (
    check_direction,
    check_force,
    check_times,
    check_together,
)
from diagnosis.answer.assembly import assembled
from diagnosis.answer.records import (
    Channel,
    Diagnosis,
    Finding,
    Fit,
    NotTestable,
    Picture,
    SmallestDetectable,
)
from diagnosis.answer.verdict import ALARM, Rest, seen
from diagnosis.assessment.regression_holdout import on_blocks, on_other_runs
from diagnosis.assessment.significance import chance
from diagnosis.evidence.laplace import Explanation
from diagnosis.observations.readings import IntArray
from diagnosis.pipelines.regression_findings import findings, scaled_covariance, sizes
from diagnosis.plants.lone.commanded_axis import CommandedAxis
from diagnosis.plants.lone.forced_axis import ForcedAxis
from diagnosis.plants.lone.range_sensor import RangeSensorPlant
from diagnosis.plants.lone.servo_delta import CHANNEL, ServoDelta
from diagnosis.report.sentences.lone_sentences import kinds_of, spoken
from diagnosis.selection.model_posterior import Posterior
from diagnosis.selection.named_first import OPEN, Progress, Selected, select
from foundation.errors import RecordingError
from models.effects.kind import MOTORS
from models.effects.servo_joints import SERVO_EFFECTS
from models.robot import DeltaRobot, RangeSensor, ServoAxis, StepperAxis
from recording.flat import FlatRecording

LoneRobot = StepperAxis | ServoAxis | RangeSensor
LonePlant = CommandedAxis | ForcedAxis | RangeSensorPlant
Plant = LonePlant | ServoDelta
POWER = 4.2
"""Standard deviations of a size at which it is found in four recordings of five: 3.3 to overcome
its Occam factor and its odds, 0.84 for the power."""


def plant_of(robot: LoneRobot, recordings: Sequence[FlatRecording]) -> LonePlant:
    """The plant that fits robot and columns. Raises RecordingError for bad input."""
    if not recordings:
        raise RecordingError("no recording was given")
    if isinstance(robot, RangeSensor):
        return RangeSensorPlant(robot, recordings)
    forced = all(r.has("effort") and np.isfinite(r.columns["effort"]).any() for r in recordings)
    if forced and isinstance(robot, ServoAxis) and robot.inertia is not None:
        return ForcedAxis(robot, recordings)
    return CommandedAxis(robot, recordings)


def diagnose_axis(
    robot: LoneRobot,
    recordings: Sequence[FlatRecording],
    holdout: Sequence[FlatRecording] = (),
    progress: Progress = lambda _: None,
) -> Diagnosis:
    """Diagnose one or several recordings of a lone machine. Raises RecordingError."""
    plant = plant_of(robot, recordings)
    others, left_out = _held_out(lambda r: plant_of(robot, [r]), holdout)
    source = recordings[0].source
    check_times(plant.readings, source)
    if isinstance(plant, CommandedAxis):
        check_direction(plant, source)
    if isinstance(plant, ForcedAxis):
        check_force(plant)
    answer = diagnose_plant(plant, others, progress)
    if isinstance(plant, CommandedAxis):
        check_together(plant, answer.fit, answer.findings, source)
    return spoken(answer, kinds_of(robot, answer), left_out)


def diagnose_servo(
    robot: DeltaRobot,
    recordings: Sequence[FlatRecording],
    holdout: Sequence[FlatRecording] = (),
    progress: Progress = lambda _: None,
) -> Diagnosis:
    """Diagnose a servo delta by its disturbance estimates. Raises RecordingError, ConfigError."""
    plant = ServoDelta(robot, recordings)
    others, left_out = _held_out(lambda r: ServoDelta(robot, [r]), holdout)
    answer = diagnose_plant(plant, others, progress)
    first = float(plant.readings.t_s[0])
    found = [_of_joint(one, first, plant.span_s) for one in answer.findings]
    pictured = answer.model_copy(update={"findings": found, "picture": joint_channels(answer)})
    return spoken(pictured, SERVO_EFFECTS, left_out)


def _of_joint(finding: Finding, first_s: float, span_s: float) -> Finding:
    """Its place in the recording's own time, on the channels of its joint."""
    joints = finding.component[-1] if finding.component in MOTORS else "123"
    axes = [f"{CHANNEL}_{joint}" for joint in joints]
    where = finding.where.model_copy(
        update={"axes": axes, "times_s": [(first_s, first_s + span_s)], "recordings": [1]}
    )
    return finding.model_copy(update={"where": where})


def diagnose_plant(
    plant: Plant, others: Sequence[Plant], progress: Progress = lambda _: None
) -> Diagnosis:
    """The method: noise, selection, alarm, sizes, held-out, what is left, the answer."""
    selected = select(plant, progress)
    first_p = _first_p(selected)
    selected = _nothing(selected) if first_p > ALARM else _without_doubtful(selected)
    progress("what else it could be")
    rest = _rest(selected)
    return assembled(
        findings(selected, plant.readings, list(plant.readings.names)),
        _fit(selected, others, rest),
        first_p,
        rest,
        probability_nothing_missing=float(np.clip(selected.nothing, 0.0, 1.0)),
        not_testable=_not_testable(plant),
        smallest_detectable=_detection_limits(selected),
        picture=_picture(selected, plant),
    )


def _held_out(
    make: Callable[[FlatRecording], Plant], holdout: Sequence[FlatRecording]
) -> tuple[list[Plant], list[str]]:
    """Plants of the held-out recordings; those too short or broken to tell are left out, named."""
    others: list[Plant] = []
    left_out: list[str] = []
    for recording in holdout:
        try:
            others.append(make(recording))
        except RecordingError as error:
            left_out.append(str(error))
    return others, left_out


def _first_p(selected: Selected) -> float:
    """Calibrated p of 'nothing is missing', before any finding."""
    best, empty = selected.best, selected.empty
    if best.keys:
        return chance(selected, best, empty)
    tried = [e for e in selected.evidence.evaluated if len(e.keys) == 1]
    return min([chance(selected, one, empty) for one in tried], default=1.0)


def _nothing(selected: Selected) -> Selected:
    """The same, with nothing claimed."""
    return Selected(
        selected.plant, selected.evidence, Posterior([selected.empty], [1.0]),
        selected.probability, selected.nothing, selected.empty, selected.named,
        {}, selected.left_over,
    )  # fmt: skip


SIGNED = frozenset(
    {
        "inertia", "effort_gain", "effort_offset", "gear_ratio", "home_offset", "sensor_offset",
        "sensor_scale", "sensor_crosstalk",
    }
)  # fmt: skip
"""Effects that correct a figure of the robot file, up or down."""


def _without_doubtful(selected: Selected) -> Selected:
    """The same less corrections of the file whose interval holds what the file says."""
    by_key = {r.key: r for r in selected.plant.regressors}
    doubtful = set()
    for key in selected.best.keys:
        shown = selected.plant.shown(key)
        if by_key[key].effect in SIGNED and shown:
            ((_, low, high),) = sizes(selected, key)[shown[0].name].components
            if low <= shown[0].nothing <= high:
                doubtful.add(key)
    if not doubtful:
        return selected
    rest = selected.evidence(selected.best.keys - doubtful, [selected.best])
    return replace(selected, posterior=Posterior([rest], [1.0]))


def _rest(selected: Selected) -> Rest:
    """What the tests say of the residual, of spline terms that are not out of the question."""
    free, best = selected.left_over, selected.best
    known = free(best.keys, [best])
    unknown = [
        r
        for r in selected.plant.regressors
        if r.left_over and r.key not in best.keys and selected.probability[r.key] > OPEN
    ]
    if not unknown:
        return Rest(1.0)
    asked = [(r, free(best.keys | {r.key}, [known])) for r in unknown]
    pairs = [(chance(selected, more, known), r, more) for r, more in asked]
    p, regressor, more = min(pairs, key=lambda item: item[0])
    share = max(known.chi2 - more.chi2, 0.0) / max(known.chi2, 1e-12)
    return Rest(p, regressor.follows, "", share)


def _fit(selected: Selected, others: Sequence[Plant], rest: Rest) -> Fit:
    """Figures of the fit; what no test can tell from noise is the noise floor."""
    rows, after_m = selected.noise.rows, _rms(selected.best, selected.noise.rows)
    free_m = float(np.sqrt(np.mean(selected.left_over.noise.sigma**2)))
    before, after = on_other_runs(selected, others) if others else on_blocks(selected)
    return Fit(
        rms_before_m=_rms(selected.empty, rows),
        rms_after_m=after_m,
        noise_floor_m=min(free_m, after_m) if seen(rest.p) else after_m,
        holdout_rms_before_m=before,
        holdout_rms_after_m=after,
        unit=selected.plant.unit,
        holdout="run" if others else "blocks",
    )


def _rms(explanation: Explanation, rows: IntArray) -> float:
    return float(np.sqrt(np.mean(np.square(explanation.residual[rows]))))


def _not_testable(plant: Plant) -> list[NotTestable]:
    if not isinstance(plant, CommandedAxis):
        return []
    untested = []
    offered = {r.effect for r in plant.regressors}
    if "joint_compliance" not in offered:
        why = "the load on the axis is not known (no gravity, no load column)"
        untested.append(NotTestable(effect="joint_compliance", component="axis", why=why))
    if "home_offset" not in offered:
        why = "the zero of the reading is arbitrary"
        untested.append(NotTestable(effect="home_offset", component="axis", why=why))
    return untested


def _detection_limits(selected: Selected) -> list[SmallestDetectable]:
    """Size of each absent effect that would be found with 80 % power, from its covariance."""
    best, found = selected.best, []
    for regressor in selected.plant.regressors:
        if regressor.key in best.keys or regressor.left_over or regressor.beside:
            continue
        shown = selected.plant.shown(regressor.key)
        with_it = best.keys | {regressor.key}
        if not shown or len(regressor.sizes) > 0 or with_it not in selected.evidence:
            continue
        more = selected.evidence(with_it)
        at = [i for i, name in enumerate(more.names) if name.startswith(f"{regressor.key}.")]
        if len(at) != 1:
            continue
        spread = POWER * float(np.sqrt(scaled_covariance(more)[at[0], at[0]]))
        name = more.names[at[0]][len(regressor.key) + 1 :]
        size = abs(float(shown[0].of({name: np.asarray(spread)})) - shown[0].nothing)
        found.append(
            SmallestDetectable(
                effect=regressor.effect, component=regressor.component,
                parameter=shown[0].name, value=size, unit=shown[0].unit,
            )
        )  # fmt: skip
    return found


def _picture(selected: Selected, plant: Plant) -> Picture:
    """Arrays for drawings."""
    readings, on = plant.readings, plant.drawn_on
    good = np.zeros(len(plant.t_s), dtype=bool)
    good[plant.rows] = True
    name = "effort" if isinstance(plant, ForcedAxis) else readings.names[0]
    channel = Channel(
        name=name, unit=plant.unit, observed=np.where(good, plant.observed + on, np.nan),
        before=selected.empty.predicted + on, after=selected.best.predicted + on,
        noise=float(np.median(selected.left_over.noise.sigma)),
    )  # fmt: skip
    return Picture(
        t_s=plant.t_s,
        channels=[channel],
        covariates=dict(plant.covariates),
        shift_s=readings.shift_s,
    )


def joint_channels(answer: Diagnosis) -> Picture | None:
    """One channel a joint, in the recording's own time, of three that stood end to end."""
    picture = answer.picture
    if picture is None:
        return None
    (whole,) = picture.channels
    third = len(picture.t_s) // 3
    parts = [slice(third * j, third * (j + 1)) for j in range(3)]
    channels = [
        Channel(
            name=f"{CHANNEL}_{j + 1}", unit=whole.unit, observed=whole.observed[rows],
            before=whole.before[rows], after=whole.after[rows], noise=whole.noise,
        )
        for j, rows in enumerate(parts)
    ]  # fmt: skip
    names = {"position": "theta", "velocity": "speed"}
    covariates = {
        f"{new}_{j + 1}": picture.covariates[old][rows]
        for old, new in names.items()
        for j, rows in enumerate(parts)
    }
    return Picture(t_s=picture.t_s[:third], channels=channels, covariates=covariates)
