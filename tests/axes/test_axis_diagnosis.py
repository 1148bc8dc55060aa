"""The diagnosis of single axes on rigs of other code: nulls silent, effects named and sized."""

from __future__ import annotations

from types import ModuleType

import numpy as np
import pytest

from deltactl.diagnosis.answer.records import Diagnosis
from deltactl.diagnosis.api import diagnose_recordings
from deltactl.diagnosis.report.next_run import hint
from deltactl.models.robot import AxisGravity, Drive, RangeSensor, ServoAxis, StepperAxis
from deltactl.recording.tables.flat import from_columns

FORCED = ServoAxis(kind="servo_axis", name="forced", motion="linear", inertia=2.0)
HEAVY = FORCED.model_copy(
    update={"motion": "rotary", "gravity": AxisGravity(torque_nm=5.0, zero_rad=0.2)}
)
FOLLOWS = ServoAxis(kind="servo_axis", name="follows", motion="rotary")
ANYWHERE = FOLLOWS.model_copy(update={"zero": "arbitrary"})
STEPS = StepperAxis(
    kind="stepper_axis", name="steps", drive=Drive(microsteps_per_rev=1600, gear_ratio=10)
)
RANGES = RangeSensor(kind="range_sensor", name="ranges")
STEPPER = {"names": "command_1 theta_1"}


def named(answer: Diagnosis) -> set[str]:
    return {finding.effect for finding in answer.findings}


def check_size(answer: Diagnosis, effect: str, parameter: str, truth: float) -> None:
    """The interval holds the truth, or misses it by no more than its own half width."""
    finding = next(f for f in answer.findings if f.effect == effect)
    size = finding.parameters[parameter]
    low, high = (float(end) for end in size.ci95)  # type: ignore[arg-type]
    half = 0.5 * (high - low)
    assert low - half < truth < high + half
    assert half < 0.5 * abs(truth)


@pytest.mark.study
def test_the_limit_of_a_ratio_is_that_over_the_stroke(rigs: ModuleType) -> None:
    """Far from zero a ratio looks like an offset, of which its limit was the limit told again."""
    recording = rigs.FollowingRig().record(1, span_s=8.0)
    far = {name: values + 20.0 for name, values in recording.columns.items()}
    limits = [
        {one.effect: one.value for one in diagnose_recordings(FOLLOWS, [read]).smallest_detectable}
        for read in (recording, from_columns({"t": recording.t_s, **far}, "far"))
    ]
    near, away = (one["gear_ratio"] for one in limits)
    assert away == pytest.approx(near, rel=0.2)


@pytest.mark.parametrize("seed", [1, *(pytest.param(n, marks=pytest.mark.study) for n in (2, 3))])
@pytest.mark.parametrize(
    ("robot", "rig", "setup", "names"),
    [
        (FORCED, "ForcedRig", {}, {}),
        (HEAVY, "ForcedRig", {"gravity": 5.0, "zero": 0.2, "noise": 1e-4, "rho": 0.5}, {}),
        (FOLLOWS, "FollowingRig", {"rho": 0.7}, {}),
        (FOLLOWS, "FollowingRig", {"noise": 1e-4, "encoder_step": 1.5e-3}, {}),
        (ANYWHERE, "FollowingRig", {"offset": 0.4}, {}),
        (STEPS, "FollowingRig", {}, STEPPER),
        (RANGES, "RangingRig", {"rho": 0.6}, {}),
    ],
)
def test_a_perfect_axis_is_said_to_miss_nothing(
    rigs: ModuleType, robot: ServoAxis, rig: str, setup: dict[str, float], names: dict[str, str],
    seed: int,
) -> None:  # fmt: skip
    span_s = 20.0 if rig == "ForcedRig" else 60.0
    recording = getattr(rigs, rig)(**setup).record(seed, span_s=span_s, **names)
    answer = diagnose_recordings(robot, [recording])
    assert answer.verdict == "nothing_missing"
    assert answer.findings == []
    assert answer.false_alarm_p > 0.01


@pytest.mark.study
@pytest.mark.parametrize(
    ("setup", "effects", "sizes"),
    [
        (
            {"coulomb": 1.5, "viscous": 3.0, "offset": 0.5},
            {"joint_friction", "viscous_friction", "effort_offset"},
            [("joint_friction", "torque", 1.5), ("viscous_friction", "coefficient", 3.0),
             ("effort_offset", "offset", 0.5)],
        ),
        ({"mass": 2.3}, {"inertia"}, [("inertia", "inertia", 2.3)]),
        ({"coulomb": 0.1}, {"joint_friction"}, [("joint_friction", "torque", 0.1)]),
    ],
)  # fmt: skip
def test_missing_forces_come_out_with_their_sizes(
    rigs: ModuleType, setup: dict[str, float], effects: set[str],
    sizes: list[tuple[str, str, float]],
) -> None:  # fmt: skip
    rig = rigs.ForcedRig(**setup)
    answer = diagnose_recordings(FORCED, [rig.record(5, 40.0)], [rig.record(6, 15.0)])
    assert named(answer) == effects
    for effect, parameter, truth in sizes:
        check_size(answer, effect, parameter, truth)
    assert answer.fit.holdout == "run"
    assert answer.fit.holdout_rms_after_m < 0.1 * answer.fit.holdout_rms_before_m


@pytest.mark.study
def test_stribeck_friction_is_told_from_coulomb_friction(rigs: ModuleType) -> None:
    rig = rigs.ForcedRig(coulomb=1.0, stribeck=0.8, stribeck_speed=0.05)
    answer = diagnose_recordings(FORCED, [rig.record(7, span_s=12.0)])
    assert named(answer) == {"joint_friction", "stribeck_friction"}


def test_without_a_known_force_mass_and_gain_are_each_other_s_alternative(
    rigs: ModuleType,
) -> None:
    answer = diagnose_recordings(FORCED, [rigs.ForcedRig(gain=0.9).record(8, span_s=10.0)])
    (finding,) = answer.findings
    assert {finding.effect, *(a.effect for a in finding.alternatives)} >= {"inertia", "effort_gain"}
    assert finding.where.axes == ["effort"]  # what is in N m shows in no position
    assert finding.probability is not None
    assert finding.probability < 0.9


@pytest.mark.study
def test_with_known_gravity_the_gain_is_told_from_the_mass(rigs: ModuleType) -> None:
    rig = rigs.ForcedRig(gravity=5.0, zero=0.2, gain=0.9)
    (finding,) = diagnose_recordings(HEAVY, [rig.record(9, span_s=10.0)]).findings
    assert finding.effect == "effort_gain"
    assert not finding.alternatives


@pytest.mark.study
@pytest.mark.parametrize(
    ("setup", "effect", "parameter", "truth", "alternative"),
    [
        ({"lag_s": 0.05}, "following_lag", "time", 0.049, "viscous_friction"),
        ({"dead_s": 0.04}, "following_lag", "dead_time", 0.04, "sensor_latency"),
        ({"play": 0.01}, "joint_friction", "width", 0.01, "gear_backlash"),
        ({"offset": 0.003}, "home_offset", "angle", 0.003, None),
        ({"scale": 1.01}, "gear_ratio", "scale", 1.01, None),
    ],
)
def test_what_a_follower_lacks_is_named(
    rigs: ModuleType, setup: dict[str, float], effect: str, parameter: str, truth: float,
    alternative: str | None,
) -> None:  # fmt: skip
    span_s = 60.0 if parameter == "dead_time" else 20.0  # as its size has to be within 4 %
    answer = diagnose_recordings(FOLLOWS, [rigs.FollowingRig(**setup).record(11, span_s)])
    assert named(answer) == {effect}
    size = answer.findings[0].parameters[parameter]
    assert size.value == pytest.approx(truth, rel=0.04)
    others = [a.effect for a in answer.findings[0].alternatives]
    assert alternative is None or alternative in others
    if alternative == "gear_backlash":
        assert any("weight that always pulls one way" in line for line in answer.says)
    assert answer.verdict == "explained"


@pytest.mark.study
def test_play_and_lag_are_both_found_through_a_coarse_encoder(rigs: ModuleType) -> None:
    rig = rigs.FollowingRig(play=0.01, lag_s=0.06, encoder_step=1.5e-3)
    answer = diagnose_recordings(FOLLOWS, [rig.record(12, span_s=15.0)])
    assert named(answer) == {"joint_friction", "following_lag"}
    check_size(answer, "joint_friction", "width", 0.01)


@pytest.mark.study
def test_what_no_effect_looks_like_is_unknown_and_says_what_it_follows(rigs: ModuleType) -> None:
    answer = diagnose_recordings(FOLLOWS, [rigs.FollowingRig(bend=0.1).record(13)])
    unknown = [one for one in answer.findings if one.effect == "unknown"]
    assert [one.depends_on for one in unknown] == [["position"]]
    # Over its whole travel a cubic is a line for the most part: named effects come first.
    assert named(answer) <= {"gear_ratio", "unknown"}
    assert answer.verdict == "partly_explained"


@pytest.mark.study
def test_a_stepper_that_lost_steps_is_told_when(rigs: ModuleType) -> None:
    rig = rigs.FollowingRig(lost=0.004, lost_at_s=15.0)
    (finding,) = diagnose_recordings(STEPS, [rig.record(14, **STEPPER)]).findings
    assert finding.effect == "lost_steps"
    assert finding.parameters["time"].value == pytest.approx(15.0, abs=0.1)
    assert finding.parameters["steps"].value == pytest.approx(
        0.004 / STEPS.drive.rad_per_step, 0.02
    )


@pytest.mark.study
def test_a_stepper_s_gear_error_and_offset_come_out_together(rigs: ModuleType) -> None:
    rig = rigs.FollowingRig(wave=0.002, period=0.0628, offset=0.01)
    answer = diagnose_recordings(STEPS, [rig.record(15, **STEPPER)])
    assert named(answer) == {"transmission_error", "home_offset"}
    check_size(answer, "transmission_error", "amplitude", 0.002)
    check_size(answer, "transmission_error", "period", 0.0628)


@pytest.mark.parametrize(
    ("setup", "effect", "parameter", "truth"),
    [
        ({"offset": 0.01}, "sensor_offset", "offset", 0.01),
        ({"scale": 1.03}, "sensor_scale", "scale", 1.03),
        ({"curvature": 0.08}, "sensor_crosstalk", "curvature", 0.08),
        ({"drift": 0.01}, "sensor_drift", "offset", 0.01),
        ({"late_s": 0.1}, "sensor_latency", "time", 0.1),
    ],
)
def test_a_range_sensor_s_error_is_named(
    rigs: ModuleType, setup: dict[str, float], effect: str, parameter: str, truth: float
) -> None:
    answer = diagnose_recordings(RANGES, [rigs.RangingRig(**setup).record(16)])
    assert named(answer) == {effect}
    check_size(answer, effect, parameter, truth)


@pytest.mark.study
def test_the_same_recording_gives_the_same_answer(rigs: ModuleType) -> None:
    recording = rigs.RangingRig(scale=1.03).record(17)
    first, second = (diagnose_recordings(RANGES, [recording]).to_json() for _ in range(2))
    assert first == second


def test_at_one_speed_a_ratio_looks_like_a_drift() -> None:
    rng = np.random.default_rng(3)
    t_s = 4.0 * np.arange(200)
    command = 7.3e-5 * t_s
    seen = 1.001 * command + 1e-6 * rng.standard_normal(200)
    recording = from_columns({"t": t_s, "command": command, "position": seen}, "rig")
    answer = diagnose_recordings(FOLLOWS, [recording])
    (ratio,) = answer.findings
    assert ratio.effect == "gear_ratio"
    assert ratio.probability is not None
    assert ratio.probability < 0.5
    assert "unknown" in [one.effect for one in ratio.alternatives]
    assert "at another speed" in hint(ratio, answer)
