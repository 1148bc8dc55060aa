"""The saved robot file of a lone axis is one: with it, nothing is missing any more."""

from __future__ import annotations

from pathlib import Path
from types import ModuleType

import numpy as np
import pytest

from deltactl.diagnosis.answer.corrected_robot import save_corrected
from deltactl.diagnosis.api import diagnose_recordings
from deltactl.diagnosis.plants.lone.commanded_axis import CommandedAxis
from deltactl.diagnosis.report.in_words import in_words
from deltactl.diagnosis.report.screen import sentences
from deltactl.models.robot import DeltaRobot, EffectEntry, RobotModel, ServoAxis
from deltactl.models.robot_files import load_robot_model
from deltactl.recording.tables.flat import FlatRecording

pytestmark = pytest.mark.study

FOLLOWS = "kind: servo_axis\nname: follows\nmotion: rotary\n"
FORCED = "kind: servo_axis\nname: forced\nmotion: linear\ninertia: 2.0\n"
RANGES = "kind: range_sensor\nname: ranges\n"
LONG_S = 60.0
"""Two drawn motions of so many seconds ask about the same of a machine."""


def corrected(text: str, recording: FlatRecording, folder: Path) -> tuple[RobotModel, float]:
    """The robot file that a diagnosis saves, and the mismatch it was to explain."""
    path, out = folder / "robot.yaml", folder / "corrected.yaml"
    path.write_text(text, encoding="utf-8")
    belief = load_robot_model(path)
    assert not isinstance(belief, DeltaRobot)
    answer = diagnose_recordings(belief, [recording])
    assert answer.findings
    save_corrected(path, answer, out, all_of_them=True)
    return load_robot_model(out), answer.fit.rms_before_m


@pytest.mark.parametrize(
    ("text", "rig", "wrong"),
    [
        (FOLLOWS, "FollowingRig", {"wave": 0.004, "period": 0.2}),
        (FOLLOWS, "FollowingRig", {"lag_s": 0.08}),
        (FOLLOWS, "FollowingRig", {"play": 0.03}),
        (FOLLOWS, "FollowingRig", {"play": 0.01, "wave": 0.004, "period": 0.2}),
        (FORCED, "ForcedRig", {"viscous": 6.0}),
        (RANGES, "RangingRig", {"offset": 0.02}),
    ],
    ids=["periodic", "lag", "play", "play and wave", "friction", "ranging"],
)
def test_with_the_saved_robot_the_mismatch_is_gone(
    rigs: ModuleType, tmp_path: Path, text: str, rig: str, wrong: dict[str, float]
) -> None:
    machine = getattr(rigs, rig)(**wrong)
    robot, before = corrected(text, machine.record(1, span_s=LONG_S), tmp_path)
    assert not isinstance(robot, DeltaRobot)
    again = diagnose_recordings(robot, [machine.record(2, span_s=LONG_S)])
    assert again.findings == []
    assert again.fit.rms_before_m < 0.25 * before
    assert again.fit.rms_after_m < 1.1 * again.fit.noise_floor_m
    if rig != "RangingRig":
        assert again.fit.done_by_known_m == pytest.approx(before, rel=0.2)


def test_the_second_harmonic_of_a_gear_is_saved_with_the_first(
    rigs: ModuleType, tmp_path: Path
) -> None:
    """It was fitted and not saved: the same recording fitted worse than the diagnosis had said."""
    recording = rigs.FollowingRig(wave=0.004, period=0.2).record(1)
    at = recording.columns["command"]
    recording.columns["position"] += 0.002 * np.sin(4.0 * np.pi * at / 0.2 + 0.7)
    path, out = tmp_path / "robot.yaml", tmp_path / "corrected.yaml"
    path.write_text(FOLLOWS, encoding="utf-8")
    belief = load_robot_model(path)
    assert isinstance(belief, ServoAxis)
    answer = diagnose_recordings(belief, [recording])
    (wave,) = answer.findings
    assert wave.parameters["amplitude_2"].value == pytest.approx(0.002, rel=0.1)
    assert "amplitude_2" not in " ".join(sentences(in_words(answer)))
    save_corrected(path, answer, out, all_of_them=True)
    robot = load_robot_model(out)
    assert isinstance(robot, ServoAxis)
    again = diagnose_recordings(robot, [recording])
    assert again.findings == []
    assert again.fit.rms_before_m == pytest.approx(answer.fit.rms_after_m, rel=0.02)


def test_play_is_known_from_whichever_flank_a_recording_begins(
    rigs: ModuleType, tmp_path: Path
) -> None:
    """Of a slow motion, the first reversal comes late: half the play would stand until there."""
    robot, before = corrected(FOLLOWS, rigs.FollowingRig(play=0.03).record(1), tmp_path)
    again = rigs.FollowingRig(play=0.03).record(2)
    early = again.t_s < 1.5
    short = FlatRecording(again.t_s[early], {n: v[early] for n, v in again.columns.items()})
    for begins in (again, short):
        answer = diagnose_recordings(robot, [begins])
        assert answer.findings == []
        assert answer.fit.rms_before_m < 0.1 * before


def test_each_stretch_begins_on_the_flank_that_it_shows() -> None:
    """Recorded on the way up, and after a pause on the way down: play is left never, only met."""
    half, noise = 0.015, 1e-4
    t_s = np.concatenate([0.01 * np.arange(600), 20.0 + 0.01 * np.arange(600)])
    up = np.linspace(0.0, 0.02, 600)
    command = np.concatenate([up, up[::-1]])
    rng = np.random.default_rng(4)
    position = command + np.repeat([-half, half], 600) + noise * rng.standard_normal(1200)
    known = EffectEntry(effect="gear_backlash", component="axis", parameters={"width": 2.0 * half})
    robot = ServoAxis(kind="servo_axis", name="follows", motion="rotary", effects=(known,))
    recording = FlatRecording(t_s, {"command": command, "position": position})
    plant = CommandedAxis(robot, [recording])
    assert np.std(plant.observed - plant.nominal) < 1.1 * noise


def test_play_that_has_grown_is_found_beyond_what_the_file_knows(
    rigs: ModuleType, tmp_path: Path
) -> None:
    robot, _ = corrected(FOLLOWS, rigs.FollowingRig(play=0.02).record(1), tmp_path)
    (found,) = diagnose_recordings(robot, [rigs.FollowingRig(play=0.03).record(2)]).findings
    assert {found.effect, *(one.effect for one in found.alternatives)} >= {"gear_backlash"}
    assert found.parameters["width"].components[0][0] == pytest.approx(0.01, rel=0.2)


def test_what_a_measured_effect_may_leave_is_no_second_effect(
    rigs: ModuleType, tmp_path: Path
) -> None:
    """Teeth that wear unevenly: the play is one width in the file, and another at each place."""
    rig = rigs.FollowingRig(play=0.03, noise=1e-5)
    uneven = rig.record(1)
    at, seen = uneven.columns["command"], uneven.columns["position"]
    seen += 0.06 * (seen - at) * np.sin(at / 0.07)
    robot, before = corrected(FOLLOWS, uneven, tmp_path)
    again = diagnose_recordings(robot, [uneven])
    assert again.verdict == "nothing_missing"
    assert "usually leave beyond their simple models" in "\n".join(sentences(in_words(again)))
    assert again.fit.rms_before_m < 0.1 * before


def lifting(seed: int) -> FlatRecording:
    """A weight that a servo lifts and lowers: it yields, and rubs by what it carries.

    Made by a loop over the samples, not by the program's chain.
    """
    t_s = 0.01 * np.arange(1600)
    command = 0.75 - 0.75 * np.cos(0.9 * t_s) + 0.25 * np.sin(2.3 * t_s)
    pull = -1.75 * np.sin(command)
    driven = command + pull / 14.0
    half = 0.5 * (0.01 + 0.05 * np.abs(pull))
    axis, at = np.empty(len(t_s)), float(driven[0])
    for row, (place, reach) in enumerate(zip(driven, half, strict=True)):
        at = min(max(at, place - reach), place + reach)
        axis[row] = at
    noise = 5e-4 * np.random.default_rng(seed).standard_normal(len(t_s))
    return FlatRecording(t_s, {"command": command, "position": axis + noise}, {}, "lifting")


def test_friction_that_grows_with_the_load_is_saved_as_such(tmp_path: Path) -> None:
    """As one width for all loads it left four times what its diagnosis had promised."""
    text = FOLLOWS + "gravity: {torque_nm: 1.75, zero_rad: 0.0}\n"
    path, out = tmp_path / "robot.yaml", tmp_path / "corrected.yaml"
    path.write_text(text, encoding="utf-8")
    belief = load_robot_model(path)
    assert not isinstance(belief, DeltaRobot)
    answer = diagnose_recordings(belief, [lifting(1)])
    assert (
        "unloaded"
        in next(one for one in answer.findings if one.effect == "joint_friction").parameters
    )
    save_corrected(path, answer, out, all_of_them=True)
    robot = load_robot_model(out)
    assert not isinstance(robot, DeltaRobot)
    again = diagnose_recordings(robot, [lifting(1)])
    assert again.fit.rms_before_m < 1.2 * answer.fit.rms_after_m
