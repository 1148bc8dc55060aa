"""The evidence of regressors: against closed forms, and on rigs of other code."""

from __future__ import annotations

from types import ModuleType

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from benchmarks.proofs.contradictions import contradictions
from deltactl.diagnosis.api import diagnose_recordings
from deltactl.diagnosis.evidence.effective_size import (
    Rows,
    TemperedNoise,
    runs_of_one_value,
    tempered,
)
from deltactl.diagnosis.evidence.laplace import Laplace
from deltactl.diagnosis.evidence.memory_given_back import autocorrelation_times, given_back
from deltactl.diagnosis.plants.lone.commanded_axis import CommandedAxis
from deltactl.diagnosis.plants.regression import RegressionPlant
from deltactl.diagnosis.plants.regressor import Columns, Regressor
from deltactl.diagnosis.plants.spline_terms import less_spanned, spline_basis, spline_over
from deltactl.diagnosis.report.in_words import in_words
from deltactl.diagnosis.report.next_run import hint
from deltactl.foundation.errors import RecordingError
from deltactl.models.robot import AxisGravity, RangeSensor, ServoAxis, StepperAxis
from deltactl.recording.tables.flat import FlatRecording, from_columns

FOLLOWS = ServoAxis(kind="servo_axis", name="follows", motion="rotary")
FORCED = ServoAxis(kind="servo_axis", name="forced", motion="rotary", inertia=2.0)


class Line(RegressionPlant):
    """A plant of two linear regressors and nothing else."""

    unit = "m"

    def __init__(self, rng: np.random.Generator, count: int, spread: float):
        self.t_s = np.arange(count) / 50.0
        self.shapes = rng.standard_normal((count, 2))
        self.observed = self.shapes @ rng.normal(0.0, spread, 2) + rng.standard_normal(count)
        self.rows = np.arange(count)
        self.groups = self.kinds = np.zeros(count, dtype=np.intp)
        self.regressors = (Regressor("a", "gear_ratio", -1.0), Regressor("b", "home_offset", -2.0))
        self.spread = spread

    def base(self, keys: frozenset[str], sizes: dict[str, float]) -> np.ndarray:
        return np.zeros(len(self.t_s))

    def columns(self, key: str, base: np.ndarray, sizes: dict[str, float]) -> Columns:
        one = self.shapes[:, ["ab".index(key)]]
        return Columns(one, np.array([self.spread]), (key,))


@pytest.mark.study
@settings(max_examples=15, deadline=None)
@given(st.integers(0, 10_000), st.integers(20, 60), st.floats(0.01, 3.0))
def test_laplace_is_exact_where_all_is_linear(seed: int, count: int, spread: float) -> None:
    """log p(y | a, b) - log p(y | nothing) of Gaussians, by their covariances."""
    plant = Line(np.random.default_rng(seed), count, spread)
    noise = tempered(
        np.random.default_rng(seed + 1).standard_normal(count),
        Rows(plant.rows, plant.groups, plant.kinds, plant.kinds, 1e-9),
    )
    evidence = Laplace(plant, noise)  # type: ignore[arg-type]
    gained = evidence("ab").log_evidence - evidence("").log_evidence
    white, shapes = noise.whiten(plant.observed), noise.whiten(plant.shapes)
    wide = np.eye(count) + spread**2 * shapes @ shapes.T
    exact = -0.5 * (white @ np.linalg.solve(wide, white) + np.linalg.slogdet(wide)[1])
    exact += 0.5 * white @ white - 3.0
    assert gained == pytest.approx(exact, rel=1e-6, abs=1e-6)


@pytest.mark.parametrize("rho", [0.0, 0.5, 0.8])
def test_memory_is_counted_as_the_textbook_says(rigs: ModuleType, rho: float) -> None:
    noise = rigs.correlated(np.random.default_rng(3), 40_000, 1.0, rho)
    (found,) = autocorrelation_times(noise[:, None], np.zeros(len(noise), dtype=np.intp))
    assert found == pytest.approx((1.0 + rho) / (1.0 - rho), rel=0.15)


@pytest.mark.study
@pytest.mark.parametrize("rho", [0.0, 0.5, 0.85])
def test_what_a_spline_takes_of_noise_is_given_back(rigs: ModuleType, rho: float) -> None:
    """In the middle of thirty the variance and the memory of the noise itself."""
    rng, count = np.random.default_rng(8), 400
    groups = np.zeros(count, dtype=np.intp)
    shapes = 30.0 * spline_basis(np.arange(count) / count, 12, 0.0, 1.0)
    hat = shapes @ np.linalg.inv(np.eye(shapes.shape[1]) + shapes.T @ shapes) @ shapes.T
    noise = np.stack([rigs.correlated(rng, count, 1.0, rho) for _ in range(30)], axis=1)
    left = noise - hat @ noise
    seen = autocorrelation_times(left, groups)
    back = [given_back(shapes, groups, float(own)) for own in seen]
    variances = [one.variance * float(np.mean(x**2)) for one, x in zip(back, left.T, strict=True)]
    memories = [one.memory * own for one, own in zip(back, seen, strict=True)]
    assert np.median(variances) == pytest.approx(1.0, rel=0.15)
    assert np.median(memories) == pytest.approx((1.0 + rho) / (1.0 - rho), rel=0.3)


def test_a_value_that_stands_is_one_run() -> None:
    """Until the stretch ends, or what is expected leaps."""
    values = np.array([1.0, 1.0, 2.0, 2.0, 2.0, 2.0, 2.0])
    groups = np.array([0, 0, 0, 0, 1, 1, 1])
    rows, still = np.arange(7), np.zeros(7)
    assert runs_of_one_value(values, still, groups, rows).tolist() == [0, 0, 1, 1, 2, 2, 2]
    leaps = np.array([0.0, 0.0, 0.0, 0.0, 0.0, 5.0, 5.1])
    assert runs_of_one_value(values, leaps, groups, rows).tolist() == [0, 0, 1, 1, 2, 3, 3]


@settings(max_examples=20, deadline=None)
@given(st.integers(0, 10_000))
def test_spline_terms_cannot_take_the_place_of_named_ones(seed: int) -> None:
    rng = np.random.default_rng(seed)
    covariate = rng.uniform(-1.0, 1.0, 300)
    named = np.stack([np.ones(300), covariate, np.sin(9.0 * covariate)], axis=1)
    rows = np.arange(0, 300, 2)
    shapes = less_spanned(spline_over(covariate, 8, rows), named, rows)
    assert np.abs(named[rows].T @ shapes[rows]).max() < 1e-6


def pendulum(seed: int, span_s: float = 25.0) -> FlatRecording:
    """Let go at 1.2 rad: 0.05 kg m2, 2 N m at the horizontal, damping and dry friction."""
    rng = np.random.default_rng(seed)
    step_s, angle, speed, kept = 5e-4, 1.2, 0.0, []
    for k in range(int(span_s / step_s)):
        if k % 20 == 0:
            kept.append((k * step_s, angle))
        push = -2.0 * np.sin(angle) - 0.01 * speed
        free = speed + push / 0.05 * step_s
        speed = float(np.sign(free) * max(abs(free) - 0.02 / 0.05 * step_s, 0.0))
        angle += speed * step_s
    t_s, position = (np.array(column) for column in zip(*kept, strict=True))
    position = position + 1e-4 * rng.standard_normal(len(position))
    return from_columns({"t": t_s, "position": position, "effort": 0.0 * t_s}, "let go")


def test_a_mass_that_swings_free_is_a_recording_like_any_other() -> None:
    robot = ServoAxis(
        kind="servo_axis", name="swings", motion="rotary", inertia=0.05,
        gravity=AxisGravity(torque_nm=2.0),
    )  # fmt: skip
    answer = diagnose_recordings(robot, [pendulum(1)])
    sizes = {f.effect: next(iter(f.parameters.values())) for f in answer.findings}
    for effect, truth in (("viscous_friction", 0.01), ("joint_friction", 0.02)):
        ((_, low, high),) = sizes[effect].components
        assert low < truth < high
    assert "inertia" not in sizes
    assert contradictions(answer) == []


@pytest.mark.study
def test_a_joint_ruled_by_friction_is_not_refused(rigs: ModuleType) -> None:
    """Friction of 40 N m on 2 kg m2: of the effort hardly anything is acceleration."""
    rig, needless = rigs.ForcedRig(coulomb=40.0, viscous=20.0), 0
    for seed in range(2, 14):
        answer = diagnose_recordings(FORCED, [rig.record(seed, span_s=10.0)])
        found = {f.effect for f in answer.findings}
        assert {"joint_friction", "viscous_friction"} <= found
        needless += "inertia" in found
    assert needless <= 4
    # What lies behind the encoder shows in no effort.
    untold = {one.effect for one in answer.not_testable}
    assert {"gear_backlash", "joint_compliance"} <= untold
    assert not untold & found


def test_degrees_in_place_of_radians_are_named_as_that(rigs: ModuleType) -> None:
    recording = rigs.ForcedRig().record(3, span_s=20.0)
    recording.columns["position"] *= 180.0 / np.pi
    with pytest.raises(RecordingError, match=r"57\.3.*units") as caught:
        diagnose_recordings(FORCED, [recording])
    assert "\n" not in str(caught.value)


@pytest.mark.parametrize(
    "seed", [21, *(pytest.param(n, marks=pytest.mark.study) for n in (22, 23))]
)
def test_rounding_alone_is_no_effect(rigs: ModuleType, seed: int) -> None:
    rig = rigs.FollowingRig(noise=1e-4, encoder_step=1.5e-3, rho=0.0)
    answer = diagnose_recordings(FOLLOWS, [rig.record(seed, span_s=15.0)])
    assert answer.findings == []
    assert answer.probability_nothing_missing is not None
    assert answer.probability_nothing_missing > 0.5


def drooping() -> FlatRecording:
    """A servo of 14 N m/rad that swings a weight of 1.5 N m."""
    rng = np.random.default_rng(5)
    fine, step_s = 40, 5e-4
    t_s = np.arange(700 * fine) * step_s
    command = 1.1 * np.sin(0.7 * t_s) + 0.4 * np.sin(1.9 * t_s)
    seen, at = np.empty_like(command), command[0]
    for k, asked in enumerate(command):
        seen[k] = at
        at += (asked - 1.5 * np.sin(at) / 14.0 - at) * step_s / 0.08
    t_s, command, seen = t_s[::fine], command[::fine], seen[::fine]
    seen = seen + 2e-3 * rng.standard_normal(len(seen))
    return from_columns({"t": t_s, "command": command, "position": seen}, "droop")


@pytest.mark.study
def test_a_servo_that_droops_under_gravity_is_said_to_yield() -> None:
    robot = FOLLOWS.model_copy(update={"gravity": AxisGravity(torque_nm=1.5)})
    answer = diagnose_recordings(robot, [drooping()])
    sizes = {f.effect: f.parameters for f in answer.findings}
    assert sizes["joint_compliance"]["stiffness"].value == pytest.approx(14.0, rel=0.1)
    total_s = sizes["following_lag"]["total"].components[0][0]
    assert total_s == pytest.approx(0.08, rel=0.05)
    assert "gear_ratio" not in sizes
    assert contradictions(answer) == []


@pytest.mark.study
def test_where_no_weight_is_given_a_servo_s_ratio_may_as_well_be_a_droop() -> None:
    answer = in_words(diagnose_recordings(FOLLOWS, [drooping()]))
    (ratio,) = [f for f in answer.findings if f.effect == "gear_ratio"]
    (droop,) = [one for one in ratio.alternatives if one.effect == "joint_compliance"]
    assert ratio.probability == pytest.approx(droop.probability)
    assert "enter `gravity` in the robot file" in " ".join(answer.says)
    assert "enter `gravity` in the robot file" in hint(ratio, answer)


def rise_and_fall(seed: int) -> FlatRecording:
    """A servo lifts a pendulum once and lowers it; what its gear carries rubs: 0.05 rad per N m."""
    rng = np.random.default_rng(seed)
    t_s = np.arange(240) / 40.0
    command = np.interp(t_s, [0.0, 0.3, 3.2, 3.4, 5.8, 6.0], [0.0, 0.0, 1.5, 1.5, 0.2, 0.2])
    seen, late, at = np.empty_like(command), 0.0, 0.0
    for k, asked in enumerate(command):
        late += (asked - late) * 0.025 / 0.09
        pull = 1.7 * np.sin(at)
        half = 0.5 * (0.02 + 0.05 * abs(pull))
        goal = late - pull / 13.0
        at = min(max(at, goal - half), goal + half)
        seen[k] = at
    seen += 2e-3 * rng.standard_normal(len(seen))
    return from_columns({"t": t_s, "command": command, "position": seen}, "up and down")


def test_friction_that_grows_with_the_load_is_no_softer_spring() -> None:
    robot = FOLLOWS.model_copy(update={"gravity": AxisGravity(torque_nm=1.7), "zero": "absolute"})
    plant = CommandedAxis(robot, [rise_and_fall(1)])
    noise = TemperedNoise(plant.rows, np.full(240, 1.0 / 2e-3), np.full(240, 2e-3), 1.0, 240.0)
    evidence = Laplace(plant, noise)
    known = evidence({"droop", "rubbing", "lag"}, [evidence({"droop", "lag"})])
    (stiffness,) = 1.0 / known.linear["droop"]
    assert stiffness == pytest.approx(13.0, rel=0.1)
    assert known.sizes["rubbing.grip"] == pytest.approx(0.05, rel=0.2)
    assert known.sizes["rubbing.width"] == pytest.approx(0.02, abs=0.01)


def test_readings_at_one_place_share_their_error() -> None:
    """36 places with 30 readings each: the interval is that of 36, not of 1080."""
    rng = np.random.default_rng(6)
    places = np.repeat(rng.uniform(1.0, 12.0, 36), 30)
    shared = np.repeat(0.06 * rng.standard_normal(36), 30)
    reading = 0.99 * places - 0.15 + shared + 0.02 * rng.standard_normal(1080)
    reading[[5, 400]] = 338e3
    t_s = np.arange(1080) / 10.0
    segment = np.repeat(np.arange(36.0), 30)
    columns = {"t": t_s, "distance": places, "range": reading, "segment": segment}
    robot = RangeSensor(kind="range_sensor", name="rooms")
    answer = diagnose_recordings(robot, [from_columns(columns, "rooms")])
    (offset,) = [f for f in answer.findings if f.effect == "sensor_offset"]
    ((value, low, high),) = offset.parameters["offset"].components
    assert low < -0.15 < high
    assert 0.5 * (high - low) > 0.02
    assert value == pytest.approx(-0.15, abs=0.06)


@pytest.mark.study
def test_slow_noise_of_a_healthy_sensor_is_no_drift(rigs: ModuleType) -> None:
    """Correlation 0.9 at 20 Hz, a quarter of a minute: every fourth such sensor had an unknown."""
    robot = RangeSensor(kind="range_sensor", name="ranges")
    rig = rigs.RangingRig(rho=0.9)
    answers = [diagnose_recordings(robot, [rig.record(seed, span_s=15.0)]) for seed in range(16)]
    assert sum(bool(answer.findings) for answer in answers) <= 1


def test_an_axis_that_turns_at_one_speed_has_no_lag_and_no_play() -> None:
    """A first reading that is off is not how a drive starts."""
    rng = np.random.default_rng(2)
    t_s = np.arange(300) / 2.0
    command = 7.3e-5 * t_s
    seen = command + 2e-6 * rng.standard_normal(len(t_s))
    seen[0] += 3e-5
    columns = {"t": t_s, "command_1": command, "theta_1": seen}
    robot = StepperAxis(kind="stepper_axis", name="mount", zero="arbitrary")
    answer = diagnose_recordings(robot, [from_columns(columns, "mount")])
    of_turns = {"following_lag", "gear_backlash", "joint_friction"}
    assert of_turns <= {one.effect for one in answer.not_testable}
    assert not of_turns & {one.effect for one in answer.findings}


@pytest.mark.study
@pytest.mark.parametrize("rho", [0.0, 0.97])
def test_how_long_the_rest_goes_on_is_told(rigs: ModuleType, rho: float) -> None:
    """An autoregression of first order at 50 Hz forgets within 20 ms / -ln(rho)."""
    answer = in_words(
        diagnose_recordings(FOLLOWS, [rigs.FollowingRig(lag_s=0.1, rho=rho).record(4)])
    )
    fit = answer.fit
    apart_s = fit.left_apart_s
    assert apart_s is not None
    assert fit.left_correlation == pytest.approx(rho ** (apart_s / 0.02), abs=0.05)
    forgotten_s = 0.02 / -np.log(rho) if rho else 0.0
    assert fit.left_lasts_s == pytest.approx(max(forgotten_s, apart_s), rel=0.25)
    assert ("err alike" in answer.unexplained.says) == (rho > 0.0)
    assert not contradictions(answer)
