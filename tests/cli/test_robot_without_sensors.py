"""A robot without ranging sensors: none is simulated, recorded, exported or reported."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from deltactl.firmware_py.controller.accepted_file import needs_restart
from deltactl.firmware_py.controller.build import simulated_machine
from deltactl.firmware_py.named_files import CONFIG_FOLDER
from deltactl.firmware_py.robot_file import load_robot
from deltactl.recording.reading.reader import read_run
from deltactl.recording.tables.flat_files import read_flat

SIZES = (
    "--base-radius-mm", "95", "--platform-radius-mm", "35", "--upper-arm-mm", "110",
    "--forearm-mm", "260", "--microsteps-per-rev", "3200", "--gear-ratio", "4",
)  # fmt: skip


@pytest.fixture
def printed(deltactl) -> None:
    deltactl("init", "delta", "printed.yaml", *SIZES, "--sensors", "none")


@pytest.mark.study
@pytest.mark.usefixtures("printed")
def test_its_run_its_table_and_its_report_know_no_sensor(deltactl, tmp_path: Path) -> None:
    words = ("--record", "r.mcap", "--report", "r.html")
    shown = deltactl("run", "printed-circle.yaml", "--simulate", *words).stdout
    assert "simulated truth" in shown
    assert "measured" not in shown
    run = read_run(tmp_path / "r.mcap")
    assert not any(len(one.t_ns) for one in run.readings.values())
    assert not [one for one in run.events if one.kind == "sensor"]
    assert np.median(np.diff(run.truth.t_ns)) == pytest.approx(20e6, rel=0.01)
    page = (tmp_path / "r.html").read_text(encoding="utf-8")
    assert "<h2>Sensors" not in page
    assert "Events" in page


@pytest.mark.study
@pytest.mark.usefixtures("printed")
def test_its_table_has_what_was_commanded_and_on_request_the_truth(
    deltactl, tmp_path: Path
) -> None:
    deltactl("run", "printed-circle.yaml", "--simulate", "--record", "r.mcap")
    deltactl("export", "r.mcap", "r.csv", "--truth")
    table = read_flat(tmp_path / "r.csv")
    assert set(table.columns) == {"steps_1", "steps_2", "steps_3"}
    assert {"truth_x_m", "truth_theta_1_rad"} <= set(table.extra)
    assert np.median(np.diff(table.t_s)) == pytest.approx(0.02, abs=1e-3)
    assert np.isfinite(table.column("steps_1")).all()


@pytest.mark.usefixtures("printed")
def test_its_sensors_cannot_be_looked_at(deltactl) -> None:
    for words in (
        ("status", "sensors"),
        ("status", "record", "by-hand.mcap"),
        ("status", "sensors", "--calibrate", "z=0.4"),
    ):
        (line,) = deltactl(*words, "--robot", "printed.yaml", status=2).stderr.splitlines()[-1:]
        assert "robot 'printed': its file describes no distance sensors" in line


@pytest.mark.usefixtures("printed")
def test_goto_homes_it_with_or_without_the_option(deltactl) -> None:
    for said in ((), ("--accept-unseen", "80")):
        done = deltactl("goto", "20", "0", "-287", "--robot", "printed.yaml", "--simulate", *said)
        assert "the simulated platform is at 20.04 0.00 -287.01 mm" in done.stdout


@pytest.mark.parametrize("name", ["zhao-2023.yaml", "uzunovic-2013.yaml"])
def test_the_simulated_machine_has_the_sensors_of_the_file(name: str) -> None:
    robot = load_robot(CONFIG_FOLDER / name)
    bare = robot.model_copy(update={"sensors": None})
    for one, axes in ((robot, {"x", "y", "z"}), (bare, set[str]())):
        machine = simulated_machine(one, realtime=False)
        assert set(machine.sensors.health()) == axes
        machine.close()
    assert needs_restart(robot, bare) == "sensors"
