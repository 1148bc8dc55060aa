"""A served robot on a virtual clock, whose planning takes as long as a test wants, and its clients.

Time moves only in `pass_s` and while a command waits on the clock, so every request meets the
robot in a known state, and every edge falls into a known stretch of time.
"""

from __future__ import annotations

import json
import socket
import threading
import time
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from dataclasses import dataclass
from pathlib import Path
from typing import Any, ClassVar

from deltactl.firmware_py.controller.build import simulated_machine
from deltactl.firmware_py.controller.controller import Controller
from deltactl.firmware_py.controller.states import State
from deltactl.firmware_py.daemon.limits import Limits
from deltactl.firmware_py.daemon.listener import Listener
from deltactl.firmware_py.daemon.server import Server
from deltactl.firmware_py.named_files import CONFIG_FOLDER
from deltactl.firmware_py.planning.prepared import CalledOff, InForce, Prepared, prepare_here
from deltactl.firmware_py.robot_file import load_robot
from deltactl.foundation.clock import Task, ns, sleep_s

ROBOT_FILE = CONFIG_FOLDER / "zhao-2023.yaml"
JOB = """name: {name}
robot: {robot}
path: {path}
timing: {{mode: accelerated, speed_mps: 0.1}}
inverse_kinematics: {{kind: geometry}}
"""
PATHS = {
    "there": "{shape: straight, to_m: [0.0, 0.01, -0.45]}",
    "back": "{shape: straight, to_m: [0.0, -0.01, -0.45]}",
    "round": "{shape: circle, centre_m: [0.0, 0.0, -0.45], radius_m: 0.02}",
}
PATIENCE_S = 120.0
"""Starting a command takes long on a machine that is busy."""

Answer = dict[str, Any]


class Wire:
    """One client: a socket, its requests, and the answers that have come."""

    def __init__(self, path: Path):
        self._socket = socket.socket(socket.AF_UNIX, socket.SOCK_STREAM)
        self._socket.settimeout(PATIENCE_S)
        self._socket.connect(str(path))
        self._lines = self._socket.makefile("rb")
        self._answers: dict[int, Answer] = {}
        self._last = 0

    def send(self, do: str, **arguments: object) -> int:
        """Ask, and wait for no answer; returns the number of the request."""
        self._last += 1
        self._socket.sendall(json.dumps({"id": self._last, "do": do, **arguments}).encode() + b"\n")
        return self._last

    def answer(self, number: int) -> Answer:
        """Wait for one."""
        while number not in self._answers:
            line = self._lines.readline()
            assert line, "the daemon has ended the connection"
            answer = json.loads(line)
            self._answers[answer["id"]] = answer
        return self._answers.pop(number)

    def outcome(self, number: int) -> Answer:
        """The answer of a `run`, once its check has ended."""
        answer = self.answer(number)
        job, planning = answer.get("job_id"), answer.get("planning")
        while planning:
            found = self.ask("result", job_id=job)
            planning = found.get("planning")
            if "error" in found:
                return {"id": number, "ok": False, "error": found["error"]}
        return {name: value for name, value in answer.items() if name != "planning"}

    def ask(self, do: str, **arguments: object) -> Answer:
        """Ask and wait."""
        return self.answer(self.send(do, **arguments))

    def half_close(self) -> None:
        """Nothing more will be asked."""
        self._socket.shutdown(socket.SHUT_WR)

    def close(self) -> None:
        """The client dies: nothing is said."""
        self._lines.close()
        self._socket.close()


@dataclass(eq=False)
class Gate:
    """One job that is being planned, for as long as it is shut."""

    job: Path
    opened: threading.Event


class ServedRobot:
    """A robot, its daemon and two clients; `edges` of servos are only good to see a change."""

    _prepared: ClassVar[dict[tuple[str, str], Prepared]] = {}
    """Planned once for all robots: what is tried here is when, not what."""

    def __init__(self, folder: Path, robot_file: Path = ROBOT_FILE, answer_s: float = 0.0):
        """answer_s: a check that takes longer is answered with 'planning'; 0: every one."""
        folder.mkdir(parents=True, exist_ok=True)
        robot = load_robot(robot_file)
        self.machine = simulated_machine(robot, False)
        self.controller = Controller(robot, robot_file, self.machine, folder, self._prepare)
        self.clock = self.controller.clock
        self.gates: list[Gate] = []
        self._quick = False
        self.path = folder / "socket"
        # On a virtual clock a walk asks faster than any client may.
        limits = Limits(requests_hz=1e6, burst=10**6, answer_s=answer_s)
        self._server = Server(
            self.controller, Listener(self.path), folder / "jobs", folder, limits=limits
        )
        self._server.start()
        self.jobs = {name: folder / f"{name}.yaml" for name in PATHS}
        for name, path in self.jobs.items():
            path.write_text(JOB.format(name=name, robot=ROBOT_FILE, path=PATHS[name]))
        self.clients = [Wire(self.path), Wire(self.path)]

    @property
    def state(self) -> State:
        """As the controller has it now."""
        return self.controller.condition.state

    @property
    def edges(self) -> int:
        """Step edges that the drives have seen so far."""
        if self.machine.bench is None:  # a servo robot: set-points passed
            return sum(map(abs, self.machine.output.status().counts))
        return sum(self.machine.bench.memory.edges())

    def until(self, condition: Callable[[], bool], what: str) -> None:
        """Wait for other threads, never seeing the controller in the middle of a transition."""

        def locked() -> bool:
            with self.controller.condition.lock:
                return condition()

        until(locked, what)

    def pass_s(self, duration_s: float) -> None:
        """Let the robot's time pass."""
        sleep_s(self.clock, duration_s)

    def meanwhile(self, delay_s: float, act: Callable[[], None]) -> None:
        """Act when so much of the robot's time has passed, whoever waits for it."""

        def task() -> Task:
            yield self.clock.now_ns() + ns(delay_s)
            act()

        self.clock.start("meanwhile", task())

    def let_check_end(self) -> None:
        """Open the way for the job that is planned, and wait until it is checked."""
        self.until(lambda: bool(self.gates), "planning begins")
        first = self.controller.jobs.planned[0]
        self.gates[0].opened.set()
        self.until(lambda: first not in self.controller.jobs.planned, "the check ends")

    @contextmanager
    def quick_checks(self) -> Iterator[None]:
        """Nothing has to be opened meanwhile."""
        self._quick = True
        yield
        self._quick = False

    def reconnect(self, number: int) -> None:
        """Another client comes where one has gone."""
        self.clients[number] = Wire(self.path)

    def close(self) -> None:
        """End everything; a plan that is still made is given up."""
        for gate in self.gates:
            gate.opened.set()
        for client in self.clients:
            client.close()
        self._server.close()
        self.controller.close()

    def _prepare(self, job: Path, robot: InForce, asked: CalledOff) -> Prepared:
        gate = Gate(job, threading.Event())
        asked.when_called_off(gate.opened.set)
        if self._quick:
            gate.opened.set()
        self.gates.append(gate)
        assert gate.opened.wait(PATIENCE_S)
        self.gates.remove(gate)
        key = (job.name, job.read_text())
        if key not in self._prepared:
            self._prepared[key] = prepare_here(job, robot)
        return self._prepared[key]


def until(condition: Callable[[], bool], what: str) -> None:
    """Wait for other threads; the robot's time does not pass meanwhile."""
    give_up_s = time.monotonic() + PATIENCE_S
    while not condition():
        assert time.monotonic() < give_up_s, f"does not happen: {what}"
        time.sleep(0.0005)
