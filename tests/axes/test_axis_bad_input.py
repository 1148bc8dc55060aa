"""Bad recordings of axes, and tables of others through a mapping."""

from __future__ import annotations

from pathlib import Path
from types import ModuleType

import numpy as np
import pytest

from deltactl.diagnosis.admission.axis_match import check_together, lead_s
from deltactl.diagnosis.answer.records import Evidence, Finding, Fit, Where
from deltactl.diagnosis.api import diagnose_recordings
from deltactl.diagnosis.plants.lone.commanded_axis import CommandedAxis
from deltactl.foundation.errors import ConfigError, RecordingError
from deltactl.models.robot import ServoAxis, StepperAxis
from deltactl.recording.foreign.mapping import load_mapping
from deltactl.recording.foreign.reading import read_mapped
from deltactl.recording.tables.flat import from_columns

FOLLOWS = ServoAxis(kind="servo_axis", name="follows", motion="rotary")
FORCED = ServoAxis(kind="servo_axis", name="forced", motion="rotary", inertia=1.0)
T_S = np.arange(500) / 50.0
WAVE = np.sin(T_S)


@pytest.mark.parametrize(
    ("robot", "columns", "message"),
    [
        (FOLLOWS, {"command": WAVE, "position": 0.0 * WAVE}, "never changes"),
        (FOLLOWS, {"command": 0.0 * WAVE, "position": WAVE}, "never changes"),
        (FOLLOWS, {"command": 1e3 * WAVE, "position": WAVE}, "units"),
        (FOLLOWS, {"command": WAVE, "position": -WAVE}, "moves against"),
        (FOLLOWS, {"position": WAVE}, "column command missing"),
        (FOLLOWS, {"command": WAVE}, "position missing"),
        (FOLLOWS, {"effort": WAVE, "position": WAVE}, "no `inertia`"),
        (FORCED, {"effort": 1e3 * WAVE, "position": WAVE}, "units"),
        (
            FOLLOWS,
            {"command": WAVE[:150], "position": np.random.default_rng(0).permutation(WAVE[:150])},
            "belong together",
        ),
    ],
)
def test_bad_columns_get_one_line(
    robot: ServoAxis, columns: dict[str, np.ndarray], message: str
) -> None:
    recording = from_columns({"t": T_S[: len(next(iter(columns.values())))], **columns}, "bad.csv")
    with pytest.raises(RecordingError, match=message) as caught:
        diagnose_recordings(robot, [recording])
    assert "\n" not in str(caught.value)


@pytest.mark.study
def test_a_reading_that_moves_before_its_command_is_doubted(rigs: ModuleType) -> None:
    for seed in range(4):
        recording = rigs.FollowingRig(lag_s=0.1, play=0.01).record(seed, span_s=15.0)
        columns = recording.columns
        t_s, command, position = recording.t_s, columns["command"], columns["position"]
        assert lead_s(t_s, command, position) == 0.0
        assert lead_s(t_s, command, command) == 0.0
        assert lead_s(t_s, position, command) > 0.02
    columns["command"], columns["position"] = position, command
    (doubt,) = diagnose_recordings(FOLLOWS, [recording]).doubts
    assert "before its command" in doubt


def test_motions_that_do_not_fit_are_told_with_their_units(rigs: ModuleType) -> None:
    """0.0126 and 3.26, of columns in degrees and counts."""
    rec = rigs.FollowingRig().record(1, span_s=20.0)
    small = {**rec.columns, "position": 1e-3 * rec.columns["position"]}
    with pytest.raises(RecordingError, match="another machine's") as caught:
        diagnose_recordings(FOLLOWS, [from_columns({"t": rec.t_s, **small}, "x")])
    assert "position moves by 0.0" in str(caught.value)
    assert "degrees" in str(caught.value).split(" and the command by ")[1]
    assert "a ratio of " in str(caught.value)


def test_milliseconds_are_refused() -> None:
    recording = from_columns({"t": 1e3 * T_S, "command": WAVE, "position": WAVE}, "ms.csv")
    with pytest.raises(RecordingError, match="in seconds"):
        diagnose_recordings(FOLLOWS, [recording])


@pytest.mark.parametrize("wrong", ["effort", "position"])
def test_effort_that_pushes_the_wrong_way_is_refused(rigs: ModuleType, wrong: str) -> None:
    recording = rigs.ForcedRig(coulomb=1.0, viscous=2.0).record(4, span_s=20.0)
    recording.columns[wrong] *= -1.0
    with pytest.raises(RecordingError, match="against its effort") as caught:
        diagnose_recordings(
            FORCED.model_copy(update={"motion": "linear", "inertia": 2.0}), [recording]
        )
    assert "\n" not in str(caught.value)
    assert "its command" not in str(caught.value)
    if wrong == "effort":
        recording.columns["effort"] += 400.0 * recording.columns["position"]
        with pytest.raises(RecordingError, match="its command, type --set"):
            diagnose_recordings(
                FORCED.model_copy(update={"motion": "linear", "inertia": 2.0}), [recording]
            )


def test_a_mapping_brings_names_and_units(tmp_path: Path) -> None:
    table = tmp_path / "theirs.csv"
    table.write_text("made by a logger\ntime_ms;angle;cmd\n0;0;0\n20;90;1.5\n40;180;3\n")
    mapping = tmp_path / "mapping.yaml"
    mapping.write_text(
        "columns:\n  t: {from: time_ms, unit: ms}\n  position: {from: angle, unit: deg}\n"
        'skip_lines: 1\nseparator: ";"\n'
    )
    recording = read_mapped(table, load_mapping(mapping, ["command=cmd*2-1"]))
    np.testing.assert_allclose(recording.t_s, [0.0, 0.02, 0.04])
    np.testing.assert_allclose(recording.columns["position"], [0.0, np.pi / 2, np.pi])
    np.testing.assert_allclose(recording.columns["command"], [-1.0, 2.0, 5.0])


def test_a_column_may_be_a_constant_and_time_a_rate(tmp_path: Path) -> None:
    table = tmp_path / "static.csv"
    table.write_text("d\n79\n74\n76\n")
    options = ["range=d[mm]", "distance=0.076", "rate_hz=50"]
    recording = read_mapped(table, load_mapping(None, options))
    np.testing.assert_allclose(recording.t_s, [0.0, 0.02, 0.04])
    np.testing.assert_allclose(recording.columns["range"], [0.079, 0.074, 0.076])
    np.testing.assert_allclose(recording.columns["distance"], 0.076)


def test_a_mistyped_name_gets_the_nearest() -> None:
    with pytest.raises(ConfigError, match=r"did you mean theta_1\?"):
        load_mapping(None, ["thetha_1=a"])
    with pytest.raises(ConfigError, match=r"did you mean steps_1\?"):
        load_mapping(None, ["steps=a"])
    with pytest.raises(ConfigError, match=r", segment$"):
        load_mapping(None, ["theta_1"])


def test_a_missing_column_is_named_with_what_could_stand_for_it(tmp_path: Path) -> None:
    table = tmp_path / "theirs.csv"
    table.write_text("when,angle\n0,1\n1,2\n")
    with pytest.raises(RecordingError, match=r"--set rate_hz=50 .*has when, angle"):
        read_mapped(table, load_mapping(None, ["position=angle"]))
    with pytest.raises(RecordingError, match=r"'cmd' \(for command\) is missing; the table has"):
        read_mapped(table, load_mapping(None, ["t=when", "command=cmd"]))
    with pytest.raises(RecordingError, match=r"\(for position\) is missing; did you mean 'angle'"):
        read_mapped(table, load_mapping(None, ["t=when", "position=why"]))
    with pytest.raises(RecordingError, match=r"'ang' .* is missing; did you mean 'angle'\?"):
        read_mapped(table, load_mapping(None, ["t=when", "position=ang"]))
    table.write_text("when,angle,torque\n0,1,1\n1,2,1\n")
    with pytest.raises(RecordingError, match=r"'cmd' \(for command\) is missing; effort, with"):
        read_mapped(table, load_mapping(None, ["t=when", "command=cmd"]))


@pytest.mark.parametrize("option", ["nonsense", "speed=v", "t=time[furlong]", "t=", "rate_hz=fast"])
def test_an_option_that_makes_no_sense_is_refused(option: str) -> None:
    with pytest.raises(ConfigError, match="--set"):
        load_mapping(None, [option])


FIT = Fit(
    rms_before_m=1.56, rms_after_m=0.4, noise_floor_m=1e-3,
    holdout_rms_before_m=1.56, holdout_rms_after_m=0.4, unit="rad",
)  # fmt: skip
FOUND = Finding(
    effect="gear_ratio", component="axis", parameters={}, where=Where(axes=[], times_s=[]),
    evidence=Evidence(delta_chi2=9.0, p=1e-3), share_of_mismatch=0.1,
)  # fmt: skip


@pytest.mark.parametrize(
    ("columns", "says"),
    [
        (
            {"steps_1": 32_000 * WAVE / np.pi},
            "the command moves 10.0 times as far as the reading: is gear_ratio 50.0 in place of 5,"
            " or microsteps_per_rev 32000 in place of 3200?",
        ),
        (
            {"command_1": 0.04 * WAVE},
            "the reading moves 10.0 times as far as the command: are columns, units or the robot",
        ),
        (
            {"steps_1": 3200 * np.random.default_rng(0).permutation(WAVE) / np.pi},
            "another machine's, gear_ratio and microsteps_per_rev included?",
        ),
    ],
)
def test_a_gear_ten_times_too_small_is_told_as_that(
    columns: dict[str, np.ndarray], says: str
) -> None:
    """In degrees, beside how far the axis moved; it was a standard deviation in rad."""
    drive = {"microsteps_per_rev": 3200, "gear_ratio": 5}
    table = StepperAxis.model_validate({"kind": "stepper_axis", "name": "table", "drive": drive})
    recording = from_columns({"t": T_S, **columns, "theta_1": 0.4 * WAVE}, "run.csv")
    with pytest.raises(RecordingError) as caught:
        check_together(CommandedAxis(table, [recording]), FIT, [FOUND], recording)
    said = str(caught.value)
    assert "89.4 degrees apart (root mean square) in a motion over 45." in said
    assert "22.9 degrees with the best explanation" in said
    assert says in said
