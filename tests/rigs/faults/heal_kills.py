"""Healings that are interrupted at random moments, and what is true of the robot afterwards.

`deltactl heal` runs as a process of its own, against a daemon of its own process. After each
interruption the robot file from before has to be in force, on the disk and in the daemon, and
nothing may move; then the healing goes on, and is undone in the end.
"""

from __future__ import annotations

import json
import os
import signal
import subprocess
import sys
import time
from collections.abc import Callable, Iterator
from contextlib import suppress
from dataclasses import dataclass, field
from itertools import cycle
from pathlib import Path
from random import Random
from typing import Any

import yaml

from deltactl.firmware_py.daemon.client import Client, daemon_answers
from deltactl.firmware_py.named_files import CONFIG_FOLDER
from deltactl.foundation.errors import DeltactlError
from tests.rigs.faults.stand import wait_for
from tests.rigs.started import Started, started

FAULT = {"effect": "home_offset", "component": "motor2", "parameters": {"angle": 0.012}}
HEART = {
    "name": "small-heart",
    "robot": "mine.yaml",
    "path": {"shape": "heart", "centre_m": [0.0, 0.0, -0.45], "width_m": 0.08},
    "timing": {"mode": "together", "t_pwm_s": 0.002},
    "inverse_kinematics": {"kind": "geometry"},
}
ENGAGED = ("homing", "planning", "running", "paused")
START_S, SETTLES_S, HEALS_S, WATCHED_S = 60.0, 10.0, 400.0, 0.5
HANDED_ON_S = 0.25
"""Pulses that were handed on before a stop still come: for 0.11 s where that was measured."""
NOT_BEGUN = "no daemon answers"
"""Said where the daemon was killed before the healing had begun."""
MOST_DISTURBED = 10
"""So often a healing may end by itself in a row, as a machine without a free core makes it."""
PROGRAM = Path(__file__).resolve().parents[3]


@dataclass
class Interrupted:
    """One interruption: the step that had been finished, and what was not as it has to be."""

    kind: str
    after_s: float
    step: str = ""
    exchanged: bool = False
    """The correction had been kept already: the corrected file is the one in force."""
    problems: list[str] = field(default_factory=list)

    def demand(self, holds: bool, problem: str) -> None:
        """Note a problem unless it holds."""
        if not holds:
            self.problems.append(problem)


class HealStand:
    """A robot with a hidden fault, its daemon, and a healing. minutes: of its survey."""

    def __init__(self, folder: Path, minutes: float = 0.3):
        self.folder, self._minutes = folder, minutes
        self.robot_file, self.socket = folder / "mine.yaml", folder / "s"
        self.out = folder / "heal-mine"
        self.old = (CONFIG_FOLDER / "zhao-2023.yaml").read_text()
        self.old += "\n" + yaml.safe_dump({"as_built": {"effects": [FAULT]}})
        self.robot_file.write_text(self.old)
        (folder / "small.yaml").write_text(yaml.safe_dump(HEART))
        self.daemon = self._start()

    def close(self) -> None:
        """End the daemon, by force."""
        self.kill_daemon()

    def heal(self) -> Started:
        """Begin to heal, or go on."""
        words = [
            "heal",
            "mine.yaml",
            "--job",
            "small.yaml",
            "--minutes",
            str(self._minutes),
            "--goal",
            "1",
        ]
        words += ["--json", "--socket", str(self.socket)]
        words += ["--continue"] if (self.out / "healing.json").exists() else []
        return self._called(*words)

    def undo(self) -> None:
        """Put the old file back; raises AssertionError where it is not."""
        undone = self._called("heal", "mine.yaml", "--undo")
        said = undone.communicate(timeout=START_S)
        assert undone.returncode == 0, said
        assert self.robot_file.read_text() == self.old

    def tell(self, words: str) -> None:
        """Make sensors or drives of the daemon fail, or mend them."""
        assert self.daemon.stdin is not None
        self.daemon.stdin.write(f"{words}\n")
        self.daemon.stdin.flush()

    def kill_daemon(self, pulses_too: bool = False) -> None:
        """kill -9; its pulse process ends by itself, unless it is killed as well."""
        children = self._children() if pulses_too else []
        self.daemon.kill()
        for child in children:
            with suppress(ProcessLookupError):
                os.kill(child, signal.SIGKILL)
        self.daemon.wait()
        if self.daemon.stdin is not None:
            with suppress(BrokenPipeError):
                self.daemon.stdin.close()

    def make_ready(self) -> None:
        """What a person does before a healing goes on: mend, start, acknowledge."""
        if self.daemon.poll() is not None:
            self.daemon = self._start()
        self.tell("see")
        with Client(self.socket) as client:
            if client.status().state in ("stopped", "fault"):
                client.power_off()  # a drive without power forgets its alarm
                wait_for(lambda: _acknowledged(client), SETTLES_S)

    def state(self) -> dict[str, Any]:
        """The state of the healing as its file has it."""
        with suppress(OSError):
            found: dict[str, Any] = json.loads((self.out / "healing.json").read_text())
            return found
        return {}

    def _called(self, *words: str) -> Started:
        command = started(*words, cwd=self.folder)
        own = os.getpriority(os.PRIO_PROCESS, 0)
        os.setpriority(os.PRIO_PROCESS, command.pid, own + 10)  # the daemon's robot keeps time
        return command

    def _children(self) -> list[int]:
        listed = Path(f"/proc/{self.daemon.pid}/task/{self.daemon.pid}/children")
        return [int(word) for word in listed.read_text().split()]

    def _start(self) -> subprocess.Popen[str]:
        command = [sys.executable, "-m", "tests.rigs.faults.heal_daemon", str(self.folder)]
        with (self.folder / "log").open("ab") as log:
            process = subprocess.Popen(
                command,
                cwd=self.folder,
                env=os.environ | {"PYTHONPATH": str(PROGRAM)},
                stdin=subprocess.PIPE,
                stdout=log,
                stderr=log,
                text=True,
            )
        if wait_for(self._answers, START_S) is None:
            process.kill()
            process.wait()
            raise TimeoutError((self.folder / "log").read_text()[-2000:])
        return process

    def _answers(self) -> bool:
        with suppress(DeltactlError):
            return daemon_answers(self.socket)
        return False


def _acknowledged(client: Client) -> bool:
    with suppress(DeltactlError):
        client.acknowledge()
        return True
    return False


Interrupt = Callable[[HealStand, Started], None]


def _kill_client(stand: HealStand, healing: Started) -> None:
    healing.kill()


def _kill_daemon(stand: HealStand, healing: Started) -> None:
    stand.kill_daemon()


def _stop(stand: HealStand, healing: Started) -> None:
    with Client(stand.socket) as client:
        client.stop("somebody saw something")


def _trip(stand: HealStand, healing: Started) -> None:
    stand.tell("trip 2")


def _blind(stand: HealStand, healing: Started) -> None:
    stand.tell("blind")


def _power_loss(stand: HealStand, healing: Started) -> None:
    healing.kill()
    stand.kill_daemon(pulses_too=True)


KINDS: dict[str, Interrupt] = {
    "client kill -9": _kill_client,
    "daemon kill -9": _kill_daemon,
    "stop": _stop,
    "drive alarm": _trip,
    "sensors blind": _blind,
    "power loss": _power_loss,
}


def campaign(
    stand: HealStand,
    count: int,
    chance: Random,
    kinds: dict[str, Interrupt],
    lasts_s: float,
    finished: bool = True,
) -> Iterator[Interrupted]:
    """`count` interruptions, every kind in turn, each at a random moment of `lasts_s` [s].

    A healing that ends before its moment is looked at, undone, and begun anew; so is the last one,
    unless it need not be `finished`.
    """
    for name in list(_turns(kinds, count)):
        healing, moment_s = stand.heal(), chance.uniform(0.0, lasts_s)
        while _ends_within(healing, moment_s):
            finish(stand, healing)
            healing, moment_s = stand.heal(), chance.uniform(0.0, lasts_s)
        seen = Interrupted(name, moment_s)
        kinds[name](stand, healing)
        judge(stand, healing, seen)
        yield seen
        stand.make_ready()
        if stand.state().get("answer") is not None:  # the next one would have nothing to heal
            _undo(stand)
    if finished:
        finish(stand, stand.heal())


def judge(stand: HealStand, healing: Started, seen: Interrupted) -> None:
    """What has to be true after an interruption."""
    out, err = healing.communicate(timeout=HEALS_S)
    state = stand.state()
    seen.step = state.get("step", "")
    seen.exchanged = state.get("exchange") is not None and stand.robot_file.read_text() != stand.old
    if not seen.exchanged:
        seen.demand(stand.robot_file.read_text() == stand.old, "the robot file is changed")
    if (healing.returncode or 0) > 0 and NOT_BEGUN not in err:
        seen.demand("robot file is in force" in err, f"does not say which file is in force: {err}")
    if healing.returncode == 0:  # it came too late, or cost nothing
        seen.demand(json.loads(out)["outcome"] == "healed", "ends, and is not healed")
    if stand.daemon.poll() is None:
        with Client(stand.socket) as client:
            _at_rest(client, stand, seen)
    else:
        stand.make_ready()
        with Client(stand.socket) as client:
            seen.demand(client.status().state == "off", "moves by itself after a start")
            _at_rest(client, stand, seen)


def _at_rest(client: Client, stand: HealStand, seen: Interrupted) -> None:
    ended = wait_for(lambda: client.status().state not in ENGAGED, SETTLES_S)
    seen.demand(ended is not None, f"goes on: {client.status().state}")
    time.sleep(HANDED_ON_S)
    status = client.status()
    seen.demand(Path(status.robot_path) == stand.robot_file, f"the daemon uses {status.robot_path}")
    time.sleep(WATCHED_S)
    after = client.status()
    moved = f"moves afterwards: {status.state}, {after.state} {WATCHED_S} s later"
    seen.demand(after.counts == status.counts, moved)


def finish(stand: HealStand, healing: Started) -> None:
    """Let a healing end, go on as often as a busy machine asks for, and undo it.

    Raises AssertionError where it does not heal, or the old file does not come back.
    """
    good = {"healed"}
    for _ in range(MOST_DISTURBED):
        out, err = healing.communicate(timeout=HEALS_S)
        if healing.returncode == 0:
            break
        if out and json.loads(out)["outcome"] == "improved":  # its correction is in force
            good.add("nothing_to_heal")
        stand.make_ready()
        healing = stand.heal()
    assert healing.returncode == 0, err
    assert json.loads(out)["outcome"] in good, out
    # So short a survey may name another cause for which the correction is the same.
    assert len(yaml.safe_load(stand.robot_file.read_text())["effects"]) == 1
    _undo(stand)


def _undo(stand: HealStand) -> None:
    """The old file in force again, and no trace of the healing."""
    stand.undo()
    for part in stand.out.iterdir():
        part.unlink()


def lasting_s(stand: HealStand) -> float:
    """How long a healing takes that nobody interrupts [s]; it is undone."""
    begun_s, healing = time.monotonic(), stand.heal()
    healing.wait(HEALS_S)
    lasted_s = time.monotonic() - begun_s
    finish(stand, healing)
    return lasted_s


def table(rows: list[Interrupted]) -> list[str]:
    """A line for each kind, and for all."""
    names = [*dict.fromkeys(row.kind for row in rows), "all"]
    lines = [f"{'interrupted by':16} {'n':>4} {'as it has to be':>16} {'kept before':>12}  steps"]
    for name in names:
        some = [row for row in rows if name in (row.kind, "all")]
        steps = {row.step.split(" (")[0].split(" of ")[0] or "nothing yet" for row in some}
        good = sum(not row.problems for row in some)
        kept = sum(row.exchanged for row in some)
        lines.append(f"{name:16} {len(some):4d} {good:16d} {kept:12d}  {len(steps)}")
    return lines


def _turns(kinds: dict[str, Interrupt], count: int) -> Iterator[str]:
    for name, _ in zip(cycle(kinds), range(count), strict=False):
        yield name


def _ends_within(healing: Started, seconds: float) -> bool:
    try:
        healing.wait(seconds)
    except subprocess.TimeoutExpired:
        return False
    return True
