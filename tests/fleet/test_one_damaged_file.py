"""One damaged file of several is named and left out; the others are worked on."""

from __future__ import annotations

import os
import time
from pathlib import Path

import numpy as np
import pytest
from typer.testing import CliRunner

from deltactl.cli.main import app
from deltactl.diagnosis.api import diagnose
from deltactl.firmware_py.named_files import CONFIG_FOLDER
from deltactl.fleet.checks import RunChecks
from deltactl.fleet.task import Robots
from deltactl.foundation.errors import RecordingError

ROBOT = CONFIG_FOLDER / "servo-axis.yaml"
DAMAGED = {
    "empty.csv": b"",
    "cut.csv.gz": b"\x1f\x8b\x08\x00\x00\x00",
    "other.csv": b"\x00\xff" * 500,
    "cut.mcap": b"\x89MCAP0\r\n\x01",
    "cut.parquet": b"PAR1\x00",
}


@pytest.fixture(scope="module")
def good(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """An axis that follows its command, with noise."""
    path = tmp_path_factory.mktemp("good") / "good.csv"
    rng = np.random.default_rng(3)
    t_s = np.arange(0.0, 12.0, 0.03)
    command_rad = np.sin(t_s) * (1.0 + 0.3 * np.sin(0.37 * t_s))
    position_rad = command_rad + rng.normal(0.0, 1e-3, len(t_s))
    rows = np.stack([t_s, command_rad, position_rad], axis=1)
    np.savetxt(path, rows, delimiter=",", header="t,command,position", comments="", fmt="%.9g")
    return path


@pytest.mark.study
def test_a_diagnosis_of_several(good: Path, tmp_path: Path) -> None:
    alone = diagnose([good], ROBOT)
    damaged = [tmp_path / name for name in DAMAGED]
    for path in damaged:
        path.write_bytes(DAMAGED[path.name])
    answer = diagnose([*damaged, good], ROBOT)
    assert answer.recordings == [str(good)]
    for path, line in zip(damaged, answer.left_out, strict=True):
        assert str(path) in line
        assert any(str(path) in says for says in answer.says)
    assert alone.left_out == []
    assert (answer.verdict, answer.fit) == (alone.verdict, alone.fit)


def test_damaged_ones_alone_are_refused(good: Path, tmp_path: Path) -> None:
    damaged = tmp_path / "empty.csv"
    damaged.write_bytes(b"")
    for several in ([damaged], [damaged, damaged]):
        with pytest.raises(RecordingError, match=r"empty\.csv"):
            diagnose(several, ROBOT)
    with pytest.raises(RecordingError, match=r"empty\.csv"):
        diagnose([good], ROBOT, holdout=[damaged])


def test_the_others_are_inspected(good: Path, tmp_path: Path) -> None:
    damaged = tmp_path / "empty.csv"
    damaged.write_bytes(b"")
    done = CliRunner().invoke(app, ["inspect", str(damaged), str(good)])
    assert done.exit_code == 0, done.exception
    assert "good.csv" in done.output
    assert "empty.csv" in done.output


def test_a_robot_file_of_a_fleet_that_cannot_be_read(good: Path, tmp_path: Path) -> None:
    robots = tmp_path / "robots"
    robots.mkdir()
    (robots / "good.yaml").write_text(ROBOT.read_text())
    (robots / "broken.yaml").write_text("{{{")
    found = Robots.in_folder(robots)
    assert found.of(good)[1] == robots / "good.yaml"


def test_a_recording_that_is_gone_holds_up_no_checks(tmp_path: Path) -> None:
    (tmp_path / "gone.mcap").symlink_to("nowhere.mcap")
    (tmp_path / "cut.mcap").write_bytes(DAMAGED["cut.mcap"])
    old_s = time.time() - 3600.0
    os.utime(tmp_path / "cut.mcap", (old_s, old_s))
    checks = RunChecks(tmp_path)
    try:
        rows = checks.look()
    finally:
        checks.close()
    assert [Path(row["recording"]).name for row in rows] == ["cut.mcap"]
    assert "cut.mcap" in rows[0]["error"]
