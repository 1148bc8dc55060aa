"""The unit, its sandbox, the boot options and the files, as an installation would put them."""

from __future__ import annotations

import os
import re
import shutil
import subprocess
import sys
from pathlib import Path

import pytest
from hypothesis import given
from hypothesis import strategies as st

from deltactl.firmware_py.install.install import hindrances, install, plan, writable_by_others
from deltactl.firmware_py.install.steps import (
    PROGRAM,
    WANTED,
    Place,
    Run,
    WriteFile,
    active_parameters,
    service_unit,
    with_options,
)
from deltactl.firmware_py.robot_file import load_robot
from deltactl.foundation.errors import ConfigError, HardwareError, ServiceError

ROBOT_FILE = PROGRAM / "config/zhao-2023.yaml"
LEAST_EXPOSURE = 2.0
needs_systemd = pytest.mark.skipif(
    shutil.which("systemd-analyze") is None, reason="systemd-analyze is not on this machine"
)


@pytest.fixture
def robot():
    return load_robot(ROBOT_FILE)


@pytest.fixture
def unit(robot, tmp_path) -> Path:
    path = tmp_path / "deltactl.service"
    path.write_text(service_unit(robot, Place(ROBOT_FILE)))
    return path


def _analyze(*arguments: str) -> subprocess.CompletedProcess[str]:
    return subprocess.run(
        ["systemd-analyze", "--no-pager", *arguments], capture_output=True, text=True, check=False
    )


@needs_systemd
def test_systemd_finds_nothing_wrong_with_the_unit(unit):
    found = _analyze("verify", "--man=no", str(unit))
    assert (found.returncode, found.stdout, found.stderr) == (0, "", "")


@needs_systemd
def test_the_sandbox_is_tight(unit):
    found = _analyze("security", "--offline=true", str(unit))
    level = re.search(r"Overall exposure level for deltactl.service: ([0-9.]+)", found.stdout)
    assert level is not None, found.stderr
    assert float(level[1]) <= LEAST_EXPOSURE


@needs_systemd
def test_the_sandbox_leaves_what_the_pulse_process_needs(unit):
    allowed = _allowed_calls(unit.read_text())
    assert allowed >= {"sched_setscheduler", "sched_setaffinity", "mlockall", "prctl", "ioctl"}
    assert not allowed & {"mount", "ptrace", "reboot", "setuid", "bpf", "init_module"}


def _allowed_calls(unit: str) -> set[str]:
    """System calls after all SystemCallFilter= lines, as systemd.exec(5) adds and takes them."""
    allowed: set[str] = set()
    for line in re.findall(r"^SystemCallFilter=(.*)$", unit, re.MULTILINE):
        words = line.removeprefix("~").split()
        calls = {call for word in words for call in _calls(word)}
        allowed = allowed - calls if line.startswith("~") else allowed | calls
    return allowed


def _calls(word: str) -> set[str]:
    if not word.startswith("@"):
        return {word}
    listed = _analyze("syscall-filter", word).stdout.splitlines()[1:]
    words = [line.strip() for line in listed if line.strip() and not line.strip().startswith("#")]
    return {call for inner in words for call in _calls(inner)}


def test_the_unit_names_real_files_and_the_robots_devices(robot):
    text = service_unit(robot, Place(ROBOT_FILE))
    assert not re.search("@[A-Z0-9]+@", text)
    for command in re.findall(r"^Exec\w+=(\S+)", text, re.MULTILINE):
        assert os.access(command, os.X_OK), command
    devices = re.findall(r"^DeviceAllow=(\S+) rw$", text, re.MULTILINE)
    assert devices == ["char-gpiochip", "/dev/i2c-1"]
    steps = robot.steps.model_copy(update={"chip": 4})
    chosen = service_unit(robot.model_copy(update={"steps": steps}), Place(ROBOT_FILE))
    devices = re.findall(r"^DeviceAllow=(\S+) rw$", chosen, re.MULTILINE)
    assert devices == ["/dev/gpiochip4", "/dev/i2c-1"]


def test_every_option_of_the_daemon_in_the_unit_exists(robot):
    """The command line of the unit, with --help at its end."""
    text = service_unit(robot, Place(ROBOT_FILE))
    (line,) = re.findall(r"^ExecStart=\S+ (.*)$", text, re.MULTILINE)
    words = line.replace("%S", "/tmp").replace("%t", "/tmp").split()
    command = [sys.executable, "-m", "deltactl.cli.main", *words, "--no-such-option"]
    found = subprocess.run(command, capture_output=True, text=True, check=False, cwd=PROGRAM)
    assert "No such option: --no-such-option" in found.stderr


def test_a_path_that_systemd_would_misread(robot, tmp_path):
    with pytest.raises(ConfigError, match="may hold letters"):
        service_unit(robot, Place(tmp_path / "my robot.yaml"))


@pytest.mark.parametrize("folder", ["/home/pi/deltactl", "/root/deltactl"])
def test_a_program_the_daemon_cannot_see(folder):
    place = Place(Path(folder) / "config/robot.yaml", Path(folder), Path(folder) / ".venv/bin")
    assert f"{folder} is hidden from the daemon; put the project into /opt" in hindrances(place)[0]


BOOT = """# For more options see the documentation
dtparam=audio=on
#dtparam=i2c_arm=on
[cm5]
dtparam=i2c_arm=on,i2c_arm_baudrate=400000
"""


def test_boot_options_are_added_for_every_model():
    text = with_options(BOOT)
    assert text.startswith(BOOT)
    assert text.splitlines()[-4:-2] == ["[all]", "# deltactl: the I2C bus of the distance sensors"]
    assert active_parameters(text) == {"audio": "on", **WANTED}


def test_only_what_is_missing_is_added():
    text = "dtparam=i2c=on\n"
    assert with_options(text).count("dtparam=i2c") == 2
    assert "dtparam=i2c_arm_baudrate=400000" in with_options(text)
    set_already = "dtparam=i2c_arm,i2c_arm_baudrate=400000"
    assert with_options(set_already) == set_already


CONFIG_LINES = st.lists(
    st.sampled_from(
        [
            *("[all]", "[pi4]", "[pi5]", "", "# text", "arm_64bit=1"),
            *("dtparam=i2c_arm=on", "dtparam=i2c_arm=off"),
            *("dtparam=i2c_arm_baudrate=100000", "dtparam=i2c_baudrate=400000"),
        ]
    ),
    max_size=10,
)


@given(CONFIG_LINES)
def test_boot_options_hold_whatever_stood_there(lines):
    before = "\n".join(lines)
    text = with_options(before)
    assert text.startswith(before)
    assert active_parameters(text).items() >= WANTED.items()
    assert with_options(text) == text


def test_a_file_is_written_once_and_the_old_one_kept(tmp_path):
    path = tmp_path / "etc/unit"
    WriteFile(path, "new\n", "why").apply()
    step = WriteFile(path, "newer\n", "why")
    assert step.describe().startswith("change")
    step.apply()
    assert path.read_text() == "newer\n"
    assert (tmp_path / "etc/unit.before-deltactl").read_text() == "new\n"
    assert step.describe().startswith("keep")
    step.apply()
    WriteFile(path, "newest\n", "why").apply()
    kept = sorted(one.name for one in path.parent.iterdir())
    assert kept == ["unit", "unit.before-deltactl", "unit.before-deltactl-2"]


def test_a_command_that_fails_is_one_line():
    with pytest.raises(ServiceError, match=r"^sh -c 'echo a; echo b >&2; exit 3': failed \(b\)$"):
        Run(("sh", "-c", "echo a; echo b >&2; exit 3"), "why").apply()
    with pytest.raises(ServiceError, match="cannot be run"):
        Run(("/no/such/command",), "why").apply()


def test_an_installation_writes_what_it_says(robot, tmp_path):
    config = tmp_path / "boot/firmware/config.txt"
    config.parent.mkdir(parents=True)
    config.write_text(BOOT)
    steps = plan(robot, Place(ROBOT_FILE), tmp_path, "pi")
    files = [step for step in steps if isinstance(step, WriteFile)]
    for step in files:
        step.apply()
    assert active_parameters(config.read_text()).items() >= WANTED.items()
    assert config.with_name("config.txt.before-deltactl").read_text() == BOOT
    written = {str(step.path.relative_to(tmp_path)) for step in files}
    assert "etc/systemd/system/deltactl.service" in written
    assert "etc/udev/rules.d/99-deltactl.rules" in written
    commands = [" ".join(step.command) for step in steps if isinstance(step, Run)]
    assert commands.index("systemd-sysusers deltactl.conf") < commands.index(
        "usermod -aG deltactl pi"
    )
    assert commands[-1] == "systemctl enable deltactl.service"


@pytest.mark.study
def test_off_the_pi_it_says_so_and_changes_nothing(tmp_path):
    said: list[str] = []
    install(ROBOT_FILE, apply=False, say=said.append, root=tmp_path)
    text = "\n".join(said)
    assert "This is not a Raspberry Pi: nothing is changed here" in text
    assert "write    " in text
    with pytest.raises(HardwareError, match="not a Raspberry Pi"):
        install(ROBOT_FILE, apply=True, say=said.append, root=tmp_path)
    assert list(tmp_path.iterdir()) == []


@pytest.mark.skipif(shutil.which("systemd-sysusers") is None, reason="no systemd-sysusers here")
def test_systemd_understands_the_users(tmp_path):
    found = subprocess.run(
        ["systemd-sysusers", "--dry-run", f"--root={tmp_path}", *_inline()],
        capture_output=True,
        text=True,
        check=False,
    )
    assert found.returncode == 0, found.stderr
    for group in ("gpio", "i2c", "deltactl"):
        assert f"Creating group '{group}'" in found.stderr


def _inline() -> list[str]:
    lines = (PROGRAM / "systemd/deltactl.sysusers.conf").read_text().splitlines()
    return ["--inline", *(line for line in lines if not line.startswith("#"))]


def test_a_program_that_others_may_write_is_not_installed(tmp_path: Path) -> None:
    """They could have the service run what they like."""
    program = tmp_path / "program"
    (program / "inner").mkdir(parents=True)
    (program / "inner" / "module.py").write_text("")
    assert writable_by_others(program) is None
    for open_path, mode in ((program / "inner" / "module.py", 0o666), (program, 0o777)):
        before = open_path.stat().st_mode
        open_path.chmod(mode)
        assert writable_by_others(program) == open_path
        open_path.chmod(before)
    os.chown(program / "inner", -1, 12345) if os.geteuid() == 0 else None
    (program / "inner").chmod(0o775)
    if os.geteuid() == 0:
        assert writable_by_others(program) == program / "inner"
    place = Place(program / "inner" / "module.py")
    program.chmod(0o777)
    assert any("others may write" in said and str(program) in said for said in hindrances(place))
