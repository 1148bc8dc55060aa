"""Tables of what has no name: from a finding to a robot file, and turned round by an inverse."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from deltactl.diagnosis.answer.corrected_robot import corrected_text
from deltactl.diagnosis.answer.records import (
    Diagnosis,
    Evidence,
    Finding,
    Fit,
    Table,
    Unexplained,
    Where,
)
from deltactl.diagnosis.answer.tables import Tables, table_of
from deltactl.firmware_py.named_files import CONFIG_FOLDER
from deltactl.firmware_py.robot_file import RobotFile, load_robot
from deltactl.foundation.errors import ConfigError
from deltactl.models.calibrated_inverse import CalibratedInverse
from deltactl.models.chain import Chain, Commands
from deltactl.models.chain.active import of_entries
from deltactl.models.merged_effects import merged
from deltactl.models.robot import EffectEntry
from deltactl.repair.correct import held_back

ROBOT = CONFIG_FOLDER / "zhao-2023.yaml"
PLACES = np.linspace(0.0, 1.2, 64)
BUMP = 0.01 * np.exp(-(((PLACES - 0.6) / 0.2) ** 2))
JOINT = EffectEntry(
    effect="joint_table",
    component="motor2",
    parameters={"error": tuple(BUMP), "lowest": 0.0, "highest": 1.2, "follows": 2.0},
)
BOWL = EffectEntry(
    effect="platform_table",
    component="platform",
    parameters={
        "error": tuple(0.004 * np.linspace(0.0, 1.0, 20) ** 2),
        "lowest": 0.0,
        "highest": 0.15,
        "follows": 4.0,
        "direction": (0.0, 0.0, 1.0),
    },
)


def unknown(component: str, follows: str, memory: bool = False) -> Finding:
    return Finding(
        effect="unknown",
        component=component,
        parameters={},
        where=Where(axes=[], times_s=[]),
        evidence=Evidence(delta_chi2=900.0, p=1e-9),
        share_of_mismatch=0.9,
        has_memory=memory,
        table=Table(follows=follows, lowest=0.0, highest=1.2, size=BUMP.tolist()),
    )


def answer(finding: Finding) -> Diagnosis:
    fit = Fit(
        rms_before_m=1e-3, rms_after_m=1e-4, noise_floor_m=1e-4,
        holdout_rms_before_m=1e-3, holdout_rms_after_m=1e-4,
    )  # fmt: skip
    return Diagnosis(
        verdict="unexplained", false_alarm_p=1e-9, fit=fit, findings=[finding],
        unexplained=Unexplained(share_of_mismatch=0.0), recordings=["survey.mcap"],
    )  # fmt: skip


def with_effects(*entries: EffectEntry) -> RobotFile:
    return load_robot(ROBOT).model_copy(update={"effects": entries})


@pytest.mark.parametrize("entries", [(JOINT,), (BOWL,), (JOINT, BOWL)])
def test_an_inverse_that_knows_a_table_puts_the_platform_on_its_target(
    entries: tuple[EffectEntry, ...],
) -> None:
    robot, rng = with_effects(*entries), np.random.default_rng(1)
    target_m = rng.uniform([-0.1, -0.1, -0.5], [0.1, 0.1, -0.4], (50, 3))
    inverse = CalibratedInverse(robot)
    commanded = inverse.angles_rad_many(target_m)
    seen = Chain(robot).simulate(Commands.of_angles(np.arange(50.0), commanded)).position
    np.testing.assert_allclose(seen, target_m, atol=1e-8)
    np.testing.assert_allclose(inverse.position_m(commanded), target_m, atol=1e-8)
    without = CalibratedInverse(with_effects()).angles_rad_many(target_m)
    assert np.abs(without - commanded).max() > 1e-3


def test_a_table_is_written_when_it_is_asked_for_and_says_where_it_comes_from(
    tmp_path: Path,
) -> None:
    found = answer(unknown("motor2", "theta_2"))
    assert corrected_text(ROBOT, found) == ROBOT.read_text()
    path = tmp_path / "mine.yaml"
    path.write_text(corrected_text(ROBOT, found, tables=Tables.JOINTS))
    (entry,) = load_robot(path).effects
    assert (entry.effect, entry.component) == ("joint_table", "motor2")
    assert entry.found is not None
    assert entry.found.recordings == ("survey.mcap",)
    again = corrected_text(path, found, tables=Tables.JOINTS)
    path.write_text(again)
    (twice,) = load_robot(path).effects  # found again: one entry, of both together
    np.testing.assert_allclose(twice.parameters["error"], 2.0 * BUMP, atol=1e-8)


@pytest.mark.parametrize(
    ("finding", "asked", "why"),
    [
        (unknown("motor2", "theta_2"), Tables.NONE, "--tables joints"),
        (unknown("motor2", "time"), Tables.NONE, "no name, and it follows time"),
        (unknown("range_z", "range_x, range_y"), Tables.NONE, "--tables platform, if you know"),
        (unknown("range_z", "time"), Tables.NONE, "no name, and it follows time"),
        (unknown("motor2", "theta_2", memory=True), Tables.JOINTS, "earlier motion"),
        (unknown("motor2", "time"), Tables.JOINTS, "follows time"),
        (unknown("range_z", "range_x, range_y"), Tables.JOINTS, "may be the sensor's"),
        (unknown("range_z", "time"), Tables.PLATFORM, "follows time"),
        (unknown("range_z", "theta_1"), Tables.SENSORS, "follows theta_1"),
    ],
)
def test_what_is_no_table_of_places_says_why(finding: Finding, asked: Tables, why: str) -> None:
    reason = table_of(finding, load_robot(ROBOT), asked)
    assert isinstance(reason, str)
    assert why in reason


@pytest.mark.parametrize(
    ("finding", "says"),
    [
        (unknown("motor2", "theta_2"), "--tables joints compensates"),
        (
            unknown("range_z", "range_x, range_y"),
            "--tables platform, if you know",
        ),
        (unknown("motor2", "theta_2", memory=True), "no name, and it depends on earlier motion"),
        (unknown("motor2", "time"), "no name, and it follows time"),
    ],
)
def test_what_is_held_back_says_whether_a_table_would_help(finding: Finding, says: str) -> None:
    ((_, why),) = held_back(answer(finding), load_robot(ROBOT), False, Tables.NONE)
    assert says in why


def test_a_platforms_table_points_where_its_sensor_looks() -> None:
    finding = unknown("range_z", "range_x, range_y")
    entry = table_of(finding, load_robot(ROBOT), Tables.PLATFORM)
    assert isinstance(entry, EffectEntry)
    assert entry.parameters["direction"] == (0.0, 0.0, 1.0)
    assert entry.parameters["follows"] == 4.0


@pytest.mark.parametrize(
    ("change", "why"),
    [
        ({"error": (0.0, 0.05), "highest": 0.01}, "the most"),
        ({"lowest": 2.0}, "less than"),
        ({"error": (0.0,)}, "2 to 256"),
        ({"follows": 1.5}, "whole"),
    ],
)
def test_a_table_that_cannot_be_turned_round_is_refused(
    change: dict[str, float | tuple[float, ...]], why: str
) -> None:
    entry = JOINT.model_copy(update={"parameters": JOINT.parameters | change})
    with pytest.raises(ConfigError, match=why):
        of_entries([entry])


def test_tables_over_other_angles_stay_two() -> None:
    other = JOINT.model_copy(update={"parameters": JOINT.parameters | {"follows": 1.0}})
    assert len(merged([JOINT], [other])) == 2


def test_a_sensors_table_is_expected_in_its_readings_and_moves_nothing(tmp_path: Path) -> None:
    table = Table(follows="range_x", lowest=0.0, highest=0.1, size=BUMP.tolist())
    found = answer(unknown("range_z", "range_x").model_copy(update={"table": table}))
    path = tmp_path / "mine.yaml"
    path.write_text(corrected_text(ROBOT, found, tables=Tables.SENSORS))
    robot = load_robot(path)
    (entry,) = robot.effects
    assert (entry.effect, entry.component) == ("sensor_table", "range_z")
    rng = np.random.default_rng(4)
    target_m = rng.uniform([0.0, -0.1, -0.5], [0.1, 0.1, -0.4], (50, 3))
    inverse = CalibratedInverse(robot)
    angles = inverse.angles_rad_many(target_m)
    without = CalibratedInverse(with_effects()).angles_rad_many(target_m)
    np.testing.assert_allclose(angles, without, atol=1e-12)
    commands = Commands.of_angles(np.arange(50.0), angles)
    seen, plain = (Chain(one).simulate(commands).ranges for one in (robot, with_effects()))
    np.testing.assert_allclose(seen[:, :2], plain[:, :2], atol=1e-12)
    expected = np.interp(target_m[:, 0], np.linspace(0.0, 0.1, len(BUMP)), BUMP)
    assert np.ptp(expected) > 1e-3
    np.testing.assert_allclose(seen[:, 2] - plain[:, 2], expected, atol=1e-6)
