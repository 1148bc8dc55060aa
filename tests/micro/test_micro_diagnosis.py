"""What is hidden in a servo delta is named from its disturbance estimates."""

from __future__ import annotations

from dataclasses import replace
from functools import cache
from pathlib import Path

import numpy as np
import pytest

pytest.importorskip("mujoco", reason="the micro delta needs the extra 'proof' (MuJoCo)")
pytest.importorskip("scipy", reason="the diagnosis needs the extra 'diagnosis'")

from deltactl.diagnosis.answer.records import Diagnosis
from deltactl.diagnosis.api import diagnose_recordings
from deltactl.diagnosis.observations.servo_preprocessing import sensor_rounds, signals_of
from deltactl.diagnosis.pipelines.by_machine import joined
from deltactl.foundation.errors import ConfigError, RecordingError
from deltactl.models.chain.servo_delta import ServoChain
from deltactl.models.robot import EffectEntry
from deltactl.proof.micro.as_built import MicroDelta
from deltactl.proof.micro.hidden_causes import KINDS, case
from deltactl.recording.tables.flat import FlatRecording
from deltactl.reproduction.uzunovic_2013.control_blind import (
    NOTHING,
    Outcome,
    confusion,
    line,
    record,
    run_case,
)
from deltactl.reproduction.uzunovic_2013.control_loop import micro_delta

ROBOT, DRIVE = micro_delta()
SECONDS = 5.0


@cache
def recording(number: int) -> FlatRecording:
    hidden, rng = case(77, number)
    return record(hidden.robot, DRIVE, rng, SECONDS)


@cache
def answered(number: int) -> Diagnosis:
    return diagnose_recordings(ROBOT, [recording(number)])


@pytest.mark.parametrize(
    "number",
    [pytest.param(n, marks=() if n == 2 else pytest.mark.study) for n in range(len(KINDS))],
)
def test_the_hidden_cause_is_named_at_its_joint(number: int) -> None:
    hidden, _ = case(77, number)
    answer = answered(number)
    said = [(one.effect, one.component) for one in answer.findings]
    if hidden.effect == NOTHING:
        assert said == []
        assert answer.verdict == "nothing_missing"
        assert answer.false_alarm_p > 0.01
        return
    assert said == [(hidden.effect, hidden.component)]
    size = next(iter(answer.findings[0].parameters.values()))
    assert size.value == pytest.approx(hidden.size, rel=0.15)
    assert answer.fit.rms_after_m < 1.02 * answer.fit.noise_floor_m
    assert answer.fit.unit == "N m"


@pytest.mark.study
def test_two_causes_at_one_joint_are_told_apart() -> None:
    """Alone a wrong torque constant explains both best: the first choice has to be taken back."""
    plain = MicroDelta()
    robot = MicroDelta(
        replace(plain.body, counterweight_nm=(8e-4, 0.0, 0.0)),
        replace(plain.drives, bearing_coulomb_nm=(1.7e-3, 9.8e-4, 9.8e-4)),
    )
    given = record(robot, DRIVE, np.random.default_rng(3), 10.0)
    found = {
        (one.effect, one.component): next(iter(one.parameters.values())).value
        for one in diagnose_recordings(ROBOT, [given]).findings
    }
    assert found == {
        ("joint_friction", "motor1"): pytest.approx(7.2e-4, rel=0.05),
        ("gravity_error", "motor1"): pytest.approx(8e-4, rel=0.05),
    }


def _without(given: FlatRecording, *stems: str) -> FlatRecording:
    kept = {name: x for name, x in given.columns.items() if not name.startswith(stems)}
    return FlatRecording(given.t_s, kept, {}, "table.csv")


@pytest.mark.study
def test_currents_stand_in_for_estimates() -> None:
    answer = diagnose_recordings(ROBOT, [_without(recording(1), "disturbance")])
    assert [(one.effect, one.component) for one in answer.findings] == [
        ("joint_friction", "motor1")
    ]


@pytest.mark.study
def test_a_known_payload_is_no_finding() -> None:
    hidden, _ = case(77, 4)
    known = EffectEntry(effect="payload", component="platform", parameters={"mass": hidden.size})
    answer = diagnose_recordings(ROBOT.model_copy(update={"effects": (known,)}), [recording(4)])
    assert answer.findings == []


@pytest.mark.study
def test_ranges_are_judged_by_measured_angles() -> None:
    """Each sensor's readings stand in rows of their own, as a servo's recording has them."""
    given = recording(0)
    rows = {
        axis: np.arange(first, len(given), 20) for axis, first in (("x", 3), ("y", 5), ("z", 7))
    }
    ranges = {f"range_{axis}": np.full(len(given), np.nan) for axis in rows}
    extra = {f"t_{axis}": np.full(len(given), np.nan) for axis in rows}
    for axis, own in rows.items():
        ranges[f"range_{axis}"][own] = given.t_s[own]
        extra[f"t_{axis}"][own] = given.t_s[own]
    seen = sensor_rounds(FlatRecording(given.t_s, {**given.columns, **ranges}, extra, "table.csv"))
    assert seen is not None
    assert seen.t_s == pytest.approx(given.t_s[rows["x"]])
    assert not any(name.startswith(("theta", "disturbance")) for name in seen.columns)
    for joint in (1, 2, 3):
        measured = given.columns[f"theta_{joint}"][rows["x"]]
        assert (seen.columns[f"command_{joint}"] == measured).all()
    for axis in rows:
        assert np.isfinite(seen.columns[f"range_{axis}"]).all()
        assert (seen.columns[f"range_{axis}"] == seen.extra[f"t_{axis}"]).all()


def test_nothing_from_outside_leaves_the_torques() -> None:
    assert sensor_rounds(recording(0)) is None


@pytest.mark.study
def test_both_parts_are_one_answer() -> None:
    named, silent = answered(5), answered(0)
    both = joined([named, silent])
    assert both.verdict == joined([silent, named]).verdict == "explained"
    assert both.findings == named.findings
    assert both.fit == joined([silent, named]).fit == named.fit
    assert joined([silent, silent]).verdict == "nothing_missing"


def test_slow_motion_is_refused_in_one_line() -> None:
    given = recording(0)
    slow = FlatRecording(given.t_s * 20.0, given.columns, {}, "slow.csv")
    with pytest.raises(RecordingError, match=r"slow.csv: the joints moved faster than .* 5 %"):
        diagnose_recordings(ROBOT, [slow])


def test_joints_that_stand_say_nothing() -> None:
    given = recording(0)
    still = {n: np.full_like(x, 0.5) if "theta" in n else x for n, x in given.columns.items()}
    with pytest.raises(RecordingError, match=r"theta_1\.\.3 never change"):
        diagnose_recordings(ROBOT, [FlatRecording(given.t_s, still, {}, "still.csv")])


def test_masses_are_needed() -> None:
    with pytest.raises(ConfigError, match="`masses`"):
        ServoChain(ROBOT.model_copy(update={"masses": None}))


def test_blocks_leave_out_reversals() -> None:
    found = signals_of(recording(0), ServoChain(ROBOT))
    speed = found.means(found.motion.speed_radps)
    assert np.abs(speed[found.valid]).min() > 0.1
    assert 0.3 < found.valid.mean() < 0.99


@pytest.mark.study
def test_a_blind_case_leaves_only_recordings_and_the_robot_file(tmp_path: Path) -> None:
    outcome = run_case(77, 1, tmp_path, run_s=2.0, holdout_s=1.0)
    assert {path.name for path in (tmp_path / "case_001").iterdir()} == {
        "recording.csv.gz",
        "holdout.csv.gz",
        "robot.yaml",
    }
    assert outcome.effect == "joint_friction"


def test_the_confusion_table_counts_what_was_said() -> None:
    right = Outcome(
        0, "payload", "platform", 0.002, (("payload", "platform"),), 0.002, (0.001, 0.003), (), ""
    )
    elsewhere = replace(right, said=(("gravity_error", "motor1"),), ci95=None)
    nothing = replace(right, effect=NOTHING, component="", size=0.0, said=(), value=None, ci95=None)
    head, rows = confusion([right, elsewhere, nothing])
    assert head[1:4] == [NOTHING, "payload", "gravity_error"]
    assert rows[0][1:] == ("1", "", "", "1 of 1", "1 of 1", "")
    assert rows[1][1:] == ("", "1", "1", "1 of 2", "1 of 2", "1 of 1")
    assert line(elsewhere).endswith("WRONG")
    assert not elsewhere.right
    assert nothing.right
