"""Recordings in, a corrected robot out; what was corrected is not found again."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import pytest

pytest.importorskip("mujoco", reason="the robot of the proof is MuJoCo's")

from deltactl.diagnosis.api import diagnose
from deltactl.firmware_py.named_files import CONFIG_FOLDER
from deltactl.firmware_py.robot_file import load_robot
from deltactl.foundation.errors import RecordingError
from deltactl.recording.tables.flat_files import write_flat
from deltactl.repair.campaign import BESIDE_FROM, Row, kinds_of
from deltactl.repair.correct import correct, with_network
from deltactl.repair.machine import faulty_robot

ROBOT = CONFIG_FOLDER / "zhao-2023.yaml"


@pytest.mark.study
def test_a_corrected_robot_diagnosed_again_lacks_nothing(tmp_path: Path) -> None:
    recording = tmp_path / "survey.csv.gz"
    write_flat(faulty_robot(["gear_ratio"], seed=4).survey(45.0), recording)
    found = correct([recording], ROBOT, tmp_path / "mine.yaml", train=False)
    assert found.changed
    assert [one.effect for one in found.coverage.compensated] == ["gear_ratio"]
    (entry,) = load_robot(found.robot_file).effects
    assert entry.found is not None
    assert entry.found.recordings == ("survey.csv.gz",)
    assert diagnose([recording], found.robot_file).verdict == "nothing_missing"
    with pytest.raises(RecordingError, match="exists already"):
        correct([recording], ROBOT, found.robot_file, train=False)


@pytest.mark.study
def test_what_happened_once_is_work_to_do_and_changes_nothing(tmp_path: Path) -> None:
    recording = tmp_path / "survey.csv.gz"
    write_flat(faulty_robot(["lost_steps"], seed=2).survey(30.0), recording)
    found = correct([recording], ROBOT, tmp_path / "mine.yaml", train=False)
    assert [finding.effect for finding, _ in found.held_back] == ["lost_steps"]
    assert "home" in found.held_back[0][1]
    assert not found.changed


def test_every_effect_comes_first_then_pairs_unknowns_and_nothing() -> None:
    groups = [kinds_of(1, number) for number in range(40)]
    alone = [names[0] for names, unknown in groups if len(names) == 1 and not unknown]
    assert len(set(alone)) == len(alone) > 15
    assert any(len(names) == 2 for names, _ in groups)
    assert ([], True) in groups
    assert ([], False) in groups
    beside, unknown = kinds_of(1, BESIDE_FROM)
    assert len(beside) == 1
    assert unknown


def test_enough_is_near_the_possible_and_worse_is_worse_than_before() -> None:
    def row(before_mm: float, after_mm: float) -> Row:
        return Row(0, (), (), 1e-3 * before_mm, 1e-3 * after_mm, 0.08e-3)

    assert row(3.0, 0.14).enough
    assert not row(3.0, 0.2).enough
    assert replace(row(3.0, 3.0), tables_m=0.14e-3).tables_enough
    assert not row(0.05, 0.05).tables_enough
    assert row(0.08, 0.2).worse
    assert not row(0.08, 0.081).worse


def test_a_network_joins_those_that_a_robot_file_names_already(tmp_path: Path) -> None:
    path = tmp_path / "mine.yaml"
    path.write_text((CONFIG_FOLDER / "zhao-2023.yaml").read_text())
    for name, network in (("small.tflite", "a.tflite"), ("8x50.tflite", "b.tflite"),
                          ("small.tflite", "c.tflite")):  # fmt: skip
        robot = load_robot(path)
        path.write_text(with_network(path.read_text(), robot, name, tmp_path / network))
    assert load_robot(path).networks == {
        "small.tflite": str(tmp_path / "c.tflite"),
        "8x50.tflite": str(tmp_path / "b.tflite"),
    }
    assert load_robot(path).is_machine_of(robot)
