"""`deltactl service install`: what a Raspberry Pi needs to run the service, done on demand."""

from __future__ import annotations

import os
import stat
from collections.abc import Callable
from pathlib import Path

from deltactl.firmware_py.install.steps import (
    Place,
    Run,
    Step,
    WriteFile,
    boot_file,
    service_unit,
    template,
    text_of,
    with_options,
)
from deltactl.firmware_py.install.wiring import PULLED_UP_AT_BOOT, as_text, wiring
from deltactl.firmware_py.machine import is_raspberry_pi
from deltactl.firmware_py.robot_file import RobotFile, check_said, load_robot
from deltactl.foundation.errors import HardwareError, ServiceError

Say = Callable[[str], None]
HIDDEN = (Path("/home"), Path("/root"), Path("/run/user"), Path("/tmp"), Path("/var/tmp"))
"""ProtectHome= and PrivateTmp= of the unit hide these from the daemon."""


def install(robot_file: Path, *, apply: bool, say: Say = print, root: Path = Path("/")) -> None:
    """Print wiring, steps and hindrances; with `apply`, carry the steps out.

    root: where the files go (tests). Raises ConfigError for a bad robot file, HardwareError
    or ServiceError when `apply` is not possible here.
    """
    robot = load_robot(robot_file)
    check_said(robot)
    place = Place(robot_file.resolve())
    on_pi = is_raspberry_pi(root / "proc/device-tree/model")
    if apply:
        _check_possible(on_pi, place)
    steps = plan(robot, place, root, operator())
    say(f"Wiring of '{robot.name}' (docs/wiring.md says more):\n\n{as_text(wiring(robot))}\n")
    for hint in hints(robot):
        say(hint)
    if not on_pi:
        say("This is not a Raspberry Pi: nothing is changed here. On one, this would be done:\n")
    for step in steps:
        say(step.describe())
        if apply:
            step.apply()
    say(_epilogue(apply, on_pi, place))


def plan(robot: RobotFile, place: Place, root: Path, user: str | None) -> list[Step]:
    """Everything to be done, in order. `user` may then use the daemon without sudo."""
    etc = root / "etc"
    steps: list[Step] = [
        WriteFile(
            etc / "sysusers.d/deltactl.conf",
            template("deltactl.sysusers.conf"),
            "user deltactl, groups gpio and i2c",
        ),
        WriteFile(
            etc / "udev/rules.d/99-deltactl.rules",
            template("99-deltactl.rules"),
            "GPIO and I2C for these groups",
        ),
        WriteFile(
            etc / "modules-load.d/deltactl.conf",
            template("deltactl.modules.conf"),
            f"/dev/i2c-{robot.ranging.bus}",
        ),
        WriteFile(
            etc / "systemd/system/deltactl.service", service_unit(robot, place), "the daemon"
        ),
    ]
    config = boot_file(root)
    if config is not None:
        options = with_options(text_of(config) or "")
        steps.append(WriteFile(config, options, "I2C on, at 400 kHz"))
    return [*steps, *_commands(user)]


def _commands(user: str | None) -> list[Step]:
    commands: list[Step] = [
        Run(("systemd-sysusers", "deltactl.conf"), "make user and groups"),
        Run(("udevadm", "control", "--reload"), "read the rules"),
        Run(("udevadm", "trigger", "--subsystem-match=gpio"), "apply them"),
        Run(("udevadm", "trigger", "--subsystem-match=i2c-dev"), "apply them"),
        Run(("systemctl", "daemon-reload"), "read the unit"),
        Run(("systemctl", "enable", "deltactl.service"), "start it at every boot"),
    ]
    if user is not None:
        join = Run(("usermod", "-aG", "deltactl", user), f"{user} may use the daemon")
        commands.insert(1, join)
    return commands


def hints(robot: RobotFile) -> list[str]:
    """What the wiring table cannot say."""
    found = []
    enable = robot.steps.enable_pin
    if enable is not None and robot.steps.enable_active_high and enable in PULLED_UP_AT_BOOT:
        found.append(
            f"GPIO {enable} (ENA) is pulled up until the daemon runs: fit 10 kOhm to ground,"
            " or the drives are energised while the Pi boots."
        )
    if robot.inputs.estop_pin is None:
        found.append("There is no e-stop input: the robot can be stopped by software only.")
    return found


def hindrances(place: Place) -> list[str]:
    """Why the service could not run from where the program is now."""
    found = []
    for path in (place.program, place.bin, place.robot_file):
        if any(path.is_relative_to(folder) for folder in HIDDEN):
            found.append(f"{path} is hidden from the daemon; put the project into /opt/deltactl")
        elif not _readable_by_all(path):
            found.append(f"{path} is not readable by all users; 'chmod -R a+rX' it")
    for path in (place.program, place.bin, place.robot_file):
        if (loose := writable_by_others(path)) is not None:
            found.append(  # noqa: PERF401 (a list of its own for each)
                f"others may write {loose}, which the daemon trusts; 'chmod go-w' it"
            )
    if not (place.bin / "deltactl").exists():
        found.append(f"{place.bin / 'deltactl'} does not exist; run 'make run' first")
    return found


def writable_by_others(path: Path) -> Path | None:
    """The first of a path's folders, itself, or what lies in it that group or others may write."""
    for place in (*reversed(path.parents), path):
        if _is_open(place):
            return place
    for folder, folders, files in os.walk(path):
        folders[:] = [name for name in folders if name not in (".git", "__pycache__")]
        for name in (*folders, *files):
            if _is_open(Path(folder) / name):
                return Path(folder) / name
    return None


def _is_open(path: Path) -> bool:
    """Whether somebody besides owner and root may write it; a sticky folder keeps what is there."""
    try:
        found = path.lstat()
    except OSError:
        return False
    if stat.S_ISLNK(found.st_mode) or (stat.S_ISDIR(found.st_mode) and found.st_mode & 0o1000):
        return False
    own_group = found.st_gid in (0, found.st_uid)
    return bool(found.st_mode & 0o002) or (bool(found.st_mode & 0o020) and not own_group)


def operator() -> str | None:
    """Who called sudo, or who calls; None for root itself."""
    user = os.environ.get("SUDO_USER") or os.environ.get("USER")
    return user if user and user != "root" else None


def _check_possible(on_pi: bool, place: Place) -> None:
    if not on_pi:
        raise HardwareError("nothing is installed: this is not a Raspberry Pi; leave out --apply")
    if os.geteuid() != 0:
        raise ServiceError(f"installing needs root; run '{_to_apply(place)}'")
    if found := hindrances(place):
        raise ServiceError(f"nothing is installed: {'; '.join(found)}")


def _readable_by_all(path: Path) -> bool:
    """Whether others may read it and walk there."""
    try:
        walk = all(parent.stat().st_mode & 0o001 for parent in path.parents)
        return walk and bool(path.stat().st_mode & 0o004)
    except OSError:
        return False


def _to_apply(place: Place) -> str:
    """What to type; sudo does not look into the environment for commands."""
    return f"sudo {place.bin / 'deltactl'} install --robot {place.robot_file} --apply"


def _epilogue(applied: bool, on_pi: bool, place: Place) -> str:
    found = hindrances(place)
    lines = [f"Before that: {hindrance}" for hindrance in found]
    if applied:
        lines.append(
            "\nDone. Restart the Pi; then 'systemctl status deltactl' and 'deltactl power on'."
        )
    elif on_pi:
        lines.append(f"\nNothing was changed. To do it: {_to_apply(place)}")
    lines.append(
        "For the most even pulses, also add isolcpus=3 to the one line of cmdline.txt:"
        " core 3 then serves the pulse process alone."
    )
    return "\n".join(lines)
