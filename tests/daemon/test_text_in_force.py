"""The daemon keeps the robot file that is in force, and systemd's clean-up goes by it."""

from __future__ import annotations

import os
import signal
import subprocess
import time
from collections.abc import Callable
from contextlib import suppress
from pathlib import Path

import pytest

from deltactl.drivers.fakes.gpio_chip import GpioChip
from deltactl.drivers.fakes.syscall_trap import SyscallTrap, available
from deltactl.firmware_py.controller.build import build_controller
from deltactl.firmware_py.controller.file_in_force import kept_text
from deltactl.firmware_py.daemon.client import Client
from deltactl.firmware_py.named_files import CONFIG_FOLDER
from deltactl.firmware_py.robot_file import load_robot
from deltactl.foundation.errors import DeltactlError
from tests.rigs import needs

ROOT = Path(__file__).resolve().parents[2]
TEXT = (CONFIG_FOLDER / "zhao-2023.yaml").read_text()
ENA, GRIPPER = 9, 12
REVISION = {"/proc/device-tree/system/linux,revision": (0xC03111).to_bytes(4, "big")}


def without_sensors() -> str:
    """A robot that needs no bus, with an ENA line and an output of its own."""
    sections = TEXT.split("\n\n")
    kept = [one for one in sections if not one.startswith(("sensors:", "ranging:"))]
    return "\n\n".join([*kept, f"outputs: {{gripper: {{pin: {GRIPPER}, safe: on}}}}"]).replace(
        "enable_pin: 5", f"enable_pin: {ENA}"
    )


def wait_for(what: Callable[[], bool], limit_s: float = 40.0) -> None:
    give_up_s = time.monotonic() + limit_s
    while not what():
        assert time.monotonic() < give_up_s
        time.sleep(0.02)


def answers(socket: Path) -> bool:
    with suppress(DeltactlError), Client(socket) as client:
        return client.status().state == "off"
    return False


@pytest.mark.study
@pytest.mark.skipif(not available(), reason="needs seccomp user notification")
def test_lines_are_made_safe_whatever_the_file_says_by_then(tmp_path: Path) -> None:
    pytest.importorskip("lgpio", reason=needs.LGPIO, exc_type=ImportError)
    robot, socket, own = tmp_path / "mine.yaml", tmp_path / "s", tmp_path / "own"
    own.mkdir()
    robot.write_text(without_sensors())
    chip = GpioChip()
    trap = SyscallTrap({"/dev/gpiochip0": chip}, (0xB4,), REVISION)
    environment = os.environ | {"RUNTIME_DIRECTORY": str(own)}
    try:
        daemon = subprocess.Popen(
            [trap.executable, "-m", "deltactl.cli.main", "service", "daemon", str(robot),
             "--recordings", str(tmp_path / "recordings"), "--socket", str(socket)],
            cwd=ROOT, env=environment, stderr=subprocess.DEVNULL, start_new_session=True,
        )  # fmt: skip
        try:
            wait_for(lambda: daemon.poll() is not None or answers(socket))
            assert daemon.poll() is None
        finally:
            os.killpg(daemon.pid, signal.SIGKILL)
            daemon.wait()
        kept = {one.name: one.read_bytes() for one in own.iterdir() if one.is_file()}
        assert kept
        for by_then in ("{{{ broken", TEXT, None):
            for name, content in kept.items():  # as the killed daemon left it
                (own / name).write_bytes(content)
            for pin in (ENA, 17):
                chip.write(pin, True)
            chip.write(GRIPPER, False)
            robot.unlink() if by_then is None else robot.write_text(by_then)
            done = subprocess.run(
                [trap.executable, "-m", "deltactl.firmware_py.install.make_safe", str(robot)],
                cwd=ROOT, env=environment, capture_output=True, text=True, timeout=60, check=False,
            )  # fmt: skip
            assert done.returncode == 0
            lines = [chip.read(pin) for pin in (ENA, 17, GRIPPER)]
            assert lines == [False, False, True], (by_then, done.stderr)
    finally:
        trap.close()


def test_the_file_counts_where_nothing_was_kept(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    from deltactl.firmware_py.install.make_safe import main

    monkeypatch.setenv("RUNTIME_DIRECTORY", str(tmp_path))
    for kept in (None, "{{{ broken"):
        if kept is not None:
            (tmp_path / "robot-in-force.yaml").write_text(kept)
        assert main([str(tmp_path / "gone.yaml")]) == 0
        assert str(tmp_path / "gone.yaml") in capsys.readouterr().err


@pytest.mark.study
def test_what_comes_into_force_is_kept(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv("RUNTIME_DIRECTORY", f"{tmp_path}:/elsewhere")
    robot = tmp_path / "mine.yaml"
    robot.write_text(TEXT)
    controller = build_controller(
        robot, simulated=True, realtime=True, recordings=tmp_path / "recordings"
    )
    try:
        kept = kept_text()
        assert kept is not None
        assert kept.read_text() == TEXT
        assert kept.stat().st_mode & 0o077 == 0
        robot.write_text("{{{ broken")
        controller.power_on()
        assert load_robot(kept).name == "zhao-2023"
        controller.power_off()
        other = TEXT.replace("step_rate_hz: 20000", "step_rate_hz: 10000")
        robot.write_text(other)
        controller.power_on()
        assert kept.read_text() == other
    finally:
        controller.close()


def test_other_outputs_need_a_restart(tmp_path: Path) -> None:
    """Their lines were claimed when the daemon started."""
    robot = tmp_path / "mine.yaml"
    robot.write_text(TEXT)
    controller = build_controller(
        robot, simulated=True, realtime=False, recordings=tmp_path / "recordings"
    )
    try:
        robot.write_text(f"{TEXT}\noutputs: {{gripper: {{pin: {GRIPPER}, safe: on}}}}\n")
        controller.power_on()
        status = controller.status()
        assert status.outputs == {}
        assert controller.robot.outputs == {}
    finally:
        controller.close()
