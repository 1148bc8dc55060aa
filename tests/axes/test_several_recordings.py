"""Recordings of one machine that agree or do not, gross outliers, priors, forces by position."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from benchmarks.proofs.contradictions import contradictions
from deltactl.diagnosis.api import diagnose_recordings
from deltactl.diagnosis.assessment.significance import _changes
from deltactl.diagnosis.evidence.laplace import Laplace
from deltactl.diagnosis.evidence.tempering import saturated_noise
from deltactl.diagnosis.observations.outliers import gross_outliers
from deltactl.diagnosis.plants.lone.range_sensor import RangeSensorPlant
from deltactl.diagnosis.plants.regressor import Columns
from deltactl.models.robot import RangeSensor, ServoAxis
from tests.axes.axis_rigs import FollowingRig, ForcedRig, RangingRig

pytestmark = pytest.mark.study

RANGES = RangeSensor(kind="range_sensor", name="ranges")
FORCED = ServoAxis(kind="servo_axis", name="forced", motion="linear", inertia=2.0)


def test_two_recordings_of_one_sensor_agree() -> None:
    rig = RangingRig(offset=0.02, scale=1.01)
    answer = diagnose_recordings(RANGES, [rig.record(1), rig.record(2)])
    assert {one.effect for one in answer.agreement} == {"sensor_offset", "sensor_scale"}
    assert min(one.p for one in answer.agreement) > 0.001
    assert [len(one.sizes) for one in answer.agreement] == [2, 2]
    assert any("agree on all sizes" in line for line in answer.says)


def test_recordings_that_differ_are_said_to_and_the_interval_holds_both() -> None:
    answer = diagnose_recordings(
        RANGES, [RangingRig(offset=0.02).record(1), RangingRig(offset=0.03).record(2)]
    )
    (one,) = [a for a in answer.agreement if a.effect == "sensor_offset"]
    assert one.p < 1e-6
    assert any("do not agree on the offset" in line for line in answer.says)
    (offset,) = [f for f in answer.findings if f.effect == "sensor_offset"]
    ((_, low, high),) = offset.parameters["offset"].components
    assert low < 0.021 < 0.029 < high
    assert contradictions(answer) == []


def test_one_recording_is_compared_with_none() -> None:
    assert diagnose_recordings(RANGES, [RangingRig(offset=0.02).record(1)]).agreement == []


def test_what_one_recording_cannot_show_is_not_compared() -> None:
    """The second goes one way only, and can show no play; the ratio is compared all the same."""
    rig = FollowingRig(play=0.01, scale=1.02)
    there_and_back, other = rig.record(1), rig.record(2)
    way = np.maximum.accumulate(other.columns["command"])
    seen = 1.02 * way + rig.noise * np.random.default_rng(3).standard_normal(len(way))
    one_way = replace(other, columns={"command": way, "position": seen})
    robot = ServoAxis(kind="servo_axis", name="axis", motion="rotary")
    answer = diagnose_recordings(robot, [there_and_back, one_way])
    assert "joint_friction" in {one.effect for one in answer.findings}
    compared = {one.effect for one in answer.agreement}
    assert "gear_ratio" in compared
    assert "joint_friction" not in compared


class WideSensor(RangeSensorPlant):
    """Priors of all sizes three times wider."""

    def columns(self, key: str, base: np.ndarray, sizes: dict[str, float]) -> Columns:  # type: ignore[override, type-arg]
        """As before, wider."""
        narrow = super().columns(key, base, sizes)
        return replace(narrow, spread=3.0 * narrow.spread)


def test_evidence_under_wider_priors_is_that_of_a_fit_with_them() -> None:
    recording = RangingRig(offset=0.02, scale=1.01).record(3, span_s=60.0)
    plain, wide = RangeSensorPlant(RANGES, [recording]), WideSensor(RANGES, [recording])
    noise = saturated_noise(plain)
    by_key = {r.key: r for r in plain.regressors}
    for keys in ((), ("offset",), ("offset", "scale", "crosstalk")):
        narrow, other = Laplace(plain, noise)(keys), Laplace(wide, noise)(keys)
        expected = other.log_evidence - narrow.log_evidence
        assert _changes(narrow, by_key, [3.0])[0] == pytest.approx(expected, abs=1e-6)


def test_a_faint_effect_says_how_it_hangs_on_the_priors() -> None:
    answer = diagnose_recordings(RANGES, [RangingRig(offset=0.0009, noise=0.004).record(4)])
    said = [line for line in answer.says if "three times larger" in line]
    assert len(said) == len(answer.prior_sensitivity)
    for one in answer.prior_sensitivity:
        changes = abs(one.narrower - one.probability), abs(one.wider - one.probability)
        assert max(changes) > 0.1


def test_no_size_is_usual_of_what_has_no_name() -> None:
    """An unknown at 91 %, 99 % and 53 % by the spread of its curve: no reader can use that."""
    rec = FollowingRig(noise=1e-3, rho=0.0).record(1, span_s=60.0)
    t_s = rec.t_s[:800]
    columns = {name: values[:800] for name, values in rec.columns.items()}
    columns["position"] = columns["position"] + 0.0006 * np.sin(3.0 * np.pi * t_s / np.ptp(t_s))
    robot = ServoAxis(kind="servo_axis", name="axis", motion="rotary")
    answer = diagnose_recordings(robot, [replace(rec, t_s=t_s, columns=columns, extra={})])
    assert "unknown" in {one.effect for one in answer.findings}
    assert "unknown" not in {one.effect for one in answer.prior_sensitivity}


@settings(max_examples=20, deadline=None)
@given(st.integers(0, 10_000), st.floats(0.0, 0.02), st.integers(1, 4))
def test_gross_outliers_are_found_and_nothing_else_is(seed: int, noise: float, count: int) -> None:
    rng = np.random.default_rng(seed)
    motion = np.sin(np.arange(400) / 15.0) + noise * rng.standard_normal(400)
    assert not gross_outliers(motion).any()
    at = 20 + 90 * np.arange(count)
    motion[at] += 40.0
    assert np.flatnonzero(gross_outliers(motion)).tolist() == at.tolist()


def test_a_step_is_no_outlier() -> None:
    assert not gross_outliers(np.repeat([0.0, 1.0, 0.0, 1.0], 50)).any()


def test_a_weight_that_the_file_leaves_out_is_unknown_and_takes_no_friction_with_it() -> None:
    rig = ForcedRig(coulomb=1.5, viscous=3.0, gravity=6.0)
    answer = diagnose_recordings(FORCED, [rig.record(5, span_s=15.0)])
    sizes = {f.effect: f.parameters for f in answer.findings}
    assert sizes["joint_friction"]["torque"].value == pytest.approx(1.5, abs=0.15)
    assert sizes["viscous_friction"]["coefficient"].value == pytest.approx(3.0, abs=0.6)
    assert "inertia" not in sizes
    (unknown,) = [f for f in answer.findings if f.effect == "unknown"]
    assert unknown.depends_on == ["position"]
