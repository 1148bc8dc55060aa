"""Walks the table of the robot's behaviour: two clients, every request, faults in between.

What is demanded: each request is answered as the table says, the state that follows is one of
those the table names, and no step edge is sent that no live, accepted request covers. What covers
is worked out here from the answers alone.
"""

from __future__ import annotations

import tempfile
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

from hypothesis import strategies as st
from hypothesis.stateful import (
    RuleBasedStateMachine,
    initialize,
    invariant,
    precondition,
    rule,
)

from deltactl.firmware_py.controller.states import TABLE, Event, Happening, Moves, Request, State
from tests.rigs.two_clients import PATHS, ServedRobot

SLOWED_DOWN_S = 1.2
"""The longest that a job may still move once it is to slow down: a look-ahead of 0.1 s, and the
ramp of these jobs, 0.98 s."""
LAST_OF_HOMING_S = 0.12
BY_THEMSELVES = {
    *(Happening.HOMED, Happening.NOT_HOMED, Happening.BEGUN, Happening.ENDED, Happening.WAITS),
    Happening.TRIED,
}
"""These follow others and are not asked for; that each is a row of the table is seen by `go`."""
WHILE_HOMING = (Request.CANCEL, Request.OFF, Request.STOP, Happening.GONE, Happening.FAULT)
CLIENTS = st.integers(0, 1)
walked: dict[str, int] = {}


@dataclass(eq=False)
class Asked:
    """A job that was sent, as its client knows it."""

    client: int
    request: int
    detached: bool
    number: int | None = None
    """Once it was accepted."""


@dataclass
class Covers:
    """What may move, by the answers that were given."""

    planned: list[Asked] = field(default_factory=list)
    """Sent and not answered, in the order in which they are taken."""
    accepted: list[Asked] = field(default_factory=list)
    held: bool = False
    slowing_until_ns: int = 0


class Robot(RuleBasedStateMachine):
    """Two clients, every request, faults."""

    @initialize()
    def switched_on(self) -> None:
        self.folder = tempfile.TemporaryDirectory(prefix="deltactl-table-")
        self.robot = ServedRobot(Path(self.folder.name))
        self.covers = Covers()
        self._walk("on", self.robot.clients[0].ask("on"))
        self._walk("home", self.robot.clients[0].ask("home"))

    def teardown(self) -> None:
        if hasattr(self, "robot"):
            self.robot.close()
            self.folder.cleanup()

    # Requests

    @rule(client=CLIENTS, name=st.sampled_from(sorted(PATHS)), detached=st.booleans())
    @precondition(lambda self: len(self.covers.planned) < 3)
    def run(self, client: int, name: str, detached: bool) -> None:
        before, robot = self.robot.state, self.robot
        wire = robot.clients[client]
        job = str(robot.jobs[name])
        known = len(robot.controller.jobs.planned)
        asked = Asked(client, wire.send("run", job=job, detach=detached), detached)
        if Request.RUN in taken(before):
            robot.until(lambda: len(robot.controller.jobs.planned) > known, "the job is accepted")
            self.covers.planned.append(asked)
            self._next_is_planned()
            self._follows(Request.RUN, before)
        else:
            self._refused(wire.answer(asked.request), Request.RUN, before)

    @rule()
    @precondition(lambda self: self.covers.planned)
    def planned(self) -> None:
        """The job that is planned passes its check."""
        asked = self.covers.planned.pop(0)
        self.robot.let_check_end()
        answer = self.robot.clients[asked.client].outcome(asked.request)
        assert answer["ok"], answer
        asked.number = answer["job_id"]
        self.covers.accepted.append(asked)
        self._next_is_planned()
        _count("planned")

    @rule(client=CLIENTS)
    def pause(self, client: int) -> None:
        if self._ask(client, Request.PAUSE):
            self.covers.held = True
            self._slowing()

    @rule(client=CLIENTS)
    def resume(self, client: int) -> None:
        if self._ask(client, Request.RESUME):
            self.covers.held = False

    @rule(client=CLIENTS)
    def cancel(self, client: int) -> None:
        waiting = bool(self.covers.planned)
        if self._ask(client, Request.CANCEL, or_else=waiting):
            self._slowing()
            self._all_called_off()

    @rule(client=CLIENTS, which=st.integers(0, 3))
    @precondition(lambda self: self.covers.accepted)
    def cancel_one(self, client: int, which: int) -> None:
        asked = self.covers.accepted[which % len(self.covers.accepted)]
        before = self.robot.state
        over = self._result(asked) is not None
        answer = self.robot.clients[client].ask("cancel", job_id=asked.number)
        assert answer["ok"] is not over, (answer, before)
        if not over:
            self._follows(Request.CANCEL, before)
            self.covers.accepted.remove(asked)
            self._slowing()

    @rule(client=CLIENTS)
    def stop(self, client: int) -> None:
        assert self._ask(client, Request.STOP)
        self._nothing_any_more()

    @rule(client=CLIENTS)
    def off(self, client: int) -> None:
        if self._ask(client, Request.OFF):
            self._nothing_any_more()

    @rule(client=CLIENTS)
    def on(self, client: int) -> None:
        self._ask(client, Request.ON)

    @rule(client=CLIENTS)
    def acknowledge(self, client: int) -> None:
        self._ask(client, Request.ACKNOWLEDGE)

    @rule(client=CLIENTS)
    def home(self, client: int) -> None:
        before = self.robot.state
        answer = self.robot.clients[client].ask("home")
        if Request.HOME in taken(before):
            assert answer["ok"], answer
            assert self.robot.state is State.READY
            _count(f"HOME in {before.name}")
        else:
            self._refused(answer, Request.HOME, before)
        self._time_passed_otherwise()

    @rule(
        client=CLIENTS,
        event=st.sampled_from(WHILE_HOMING),
        delay_s=st.sampled_from([0.03, 0.15, 0.3]),
    )
    @precondition(lambda self: not self.covers.planned)
    @precondition(lambda self: Request.HOME in taken(self.robot.state))
    def home_called_off(self, client: int, event: Event, delay_s: float) -> None:
        """By the other client, or because its own client dies."""
        robot, seen = self.robot, []
        states: list[State] = []

        def act() -> None:
            states.append(robot.state)
            if event is Happening.GONE:
                robot.clients[client].close()
                robot.until(lambda: robot.state is not State.HOMING, "the homing is called off")
            elif event is Happening.FAULT:
                robot.controller._on_loop_error(RuntimeError("a mistake"))
            else:
                robot.clients[1 - client].ask(event.value)
            states.append(robot.state)
            seen.append(robot.edges)

        robot.meanwhile(delay_s, act)
        robot.meanwhile(delay_s + LAST_OF_HOMING_S, lambda: seen.append(robot.edges))
        number = robot.clients[client].send("home")
        if event is Happening.GONE:
            robot.until(lambda: len(states) == 2, "its client goes")
            robot.clients[1 - client].ask("on")  # refused, behind the end of the homing
            robot.reconnect(client)
        else:
            assert not robot.clients[client].answer(number)["ok"]
        robot.pass_s(LAST_OF_HOMING_S)
        assert states[0] is State.HOMING
        assert states[1] in TABLE[event][State.HOMING].then
        silent = seen[1] if TABLE[event][State.HOMING].moves is Moves.LAST_OF_HOMING else seen[0]
        assert robot.edges == silent, "a homing that was called off goes on"
        _count(f"{event.name} in HOMING")
        self._time_passed_otherwise()

    @rule(client=CLIENTS)
    def gone(self, client: int) -> None:
        """A client dies, and another comes in its place."""
        before, robot = self.robot.state, self.robot
        owned = [one for one in self.covers.accepted if one.client == client and not one.detached]
        going = [one for one in owned if self._result(one) is None]
        planned = [one for one in self.covers.planned if one.client == client]
        robot.clients[client].close()
        numbers = {one.number for one in going}
        robot.until(lambda: not numbers & self._not_called_off(), "its jobs are called off")
        for one in planned:
            self.covers.planned.remove(one)
        known = robot.controller.jobs.planned
        robot.until(lambda: len(known) == len(self.covers.planned), "its checks are given up")
        self._next_is_planned()
        robot.reconnect(client)
        if going or planned:
            self._follows(Happening.GONE, before)
        for one in owned:
            self.covers.accepted.remove(one)
        if going:
            self._slowing()

    @rule(client=CLIENTS)
    @precondition(lambda self: not self.covers.planned)
    def made_ready(self, client: int) -> None:
        """What a person does who wants to go on."""
        for request in (Request.ACKNOWLEDGE, Request.ON, Request.HOME):
            if request in taken(self.robot.state) and self.robot.state is not State.READY:
                assert self.robot.clients[client].ask(request.value)["ok"]
        self._time_passed_otherwise()

    @rule(
        client=CLIENTS,
        wanted=st.sampled_from([State.PLANNING, State.RUNNING, State.PAUSED]),
        name=st.sampled_from(sorted(PATHS)),
        detached=st.booleans(),
    )
    @precondition(lambda self: not self.covers.planned)
    def brought_to(self, client: int, wanted: State, name: str, detached: bool) -> None:
        """To where the most can happen."""
        self.made_ready(client)
        if self.robot.state is State.READY:
            self.run(client, name, detached)
            if wanted is not State.PLANNING:
                self.planned()
                self.time_passes(0.2)
            if wanted is State.PAUSED:
                self.pause(client)

    # Faults

    @rule(kind=st.sampled_from(["e-stop", "alarm", "mistake"]), motor=st.integers(1, 3))
    def fault(self, kind: str, motor: int) -> None:
        bench, before = self.robot.machine.bench, self.robot.state
        assert bench is not None
        if kind == "e-stop":
            bench.press_estop()
        elif kind == "alarm" and before is not State.OFF:  # the player does not look at them then
            bench.trip(motor)
        else:
            self.robot.controller._on_loop_error(RuntimeError("a mistake"))
        self.robot.pass_s(0.05)
        event = Happening.ESTOP if kind == "e-stop" else Happening.FAULT
        if before in TABLE[event]:
            self._follows(event, before)
        self._nothing_any_more()
        bench.release_estop()
        bench.lines.cycle_power()

    @rule(motor=st.integers(1, 3))
    @precondition(lambda self: Happening.PUSHED in taken(self.robot.state))
    @precondition(lambda self: self.robot.controller.jobs.running is None)
    @precondition(lambda self: not self.covered())
    def pushed(self, motor: int) -> None:
        """An arm moves by 9 degrees at rest: before a job begins, or without one."""
        assert self.robot.machine.bench is not None
        before = self.robot.state
        self.robot.pass_s(0.8)
        self.robot.machine.bench.slip(motor, 400)
        for _ in range(20):
            if self.robot.state is State.UNHOMED:
                break
            self.robot.pass_s(0.1)
        self._follows(Happening.PUSHED, before)
        self._nothing_any_more()

    # Time

    @rule(duration_s=st.sampled_from([0.02, 0.05, 0.05, 0.2, 0.5]))
    def time_passes(self, duration_s: float) -> None:
        robot = self.robot
        edges, began_ns = robot.edges, robot.clock.now_ns()
        covered = self.covered()
        robot.pass_s(duration_s)
        moved = robot.edges - edges
        if moved and not covered:
            assert began_ns < self.covers.slowing_until_ns, f"{moved} edges that nobody covers"
        self._time_passed_otherwise()
        _count("time")

    @rule(client=CLIENTS)
    def looks(self, client: int) -> None:
        """Status and results ask for nothing that moves, and agree with what was answered."""
        status: Any = self.robot.clients[client].ask("status")["status"]
        assert status["state"] == self.robot.state.value
        waiting = {*status["queued_ids"], *status["planning_ids"], status["job_id"]}
        assert all(self._result(one) or one.number in waiting for one in self.covers.accepted)
        _count("looks")

    @invariant()
    def nothing_waits_where_nothing_may_run(self) -> None:
        if hasattr(self, "robot") and self.robot.state not in (
            State.PLANNING, State.RUNNING, State.PAUSED,
        ):  # fmt: skip
            assert not self.robot.controller.jobs.claims()

    # What is known

    def _ask(self, client: int, request: Request, or_else: bool = False) -> bool:
        """Ask; the answer and the state that follows are those of the table."""
        before = self.robot.state
        answer = self.robot.clients[client].ask(request.value)
        if request in taken(before):
            assert answer["ok"], (request, before, answer)
            self._follows(request, before)
            return True
        if or_else and answer["ok"]:
            return True
        self._refused(answer, request, before)
        return False

    def _walk(self, request: str, answer: dict[str, Any]) -> None:
        assert answer["ok"], answer
        _count(request)

    def _refused(self, answer: dict[str, Any], request: Request, before: State) -> None:
        assert not answer["ok"], (request, before)
        assert answer["error"]["kind"] == "NotReady", answer
        assert self.robot.state is before
        _count(f"{request.name} refused in {before.name}")

    def _follows(self, event: Event, before: State) -> None:
        allowed = TABLE[event][before]
        assert self.robot.state in allowed.then, (event, before, self.robot.state)
        _count(f"{event.name} in {before.name}")

    def _slowing(self) -> None:
        self.covers.slowing_until_ns = self.robot.clock.now_ns() + round(SLOWED_DOWN_S * 1e9)

    def _all_called_off(self) -> None:
        """Whoever waits for a job that was called off is answered, and it has a result."""
        robot = self.robot
        for asked in self.covers.planned:
            answer = robot.clients[asked.client].outcome(asked.request)
            assert not answer["ok"], answer
            assert answer["error"]["kind"] == "NotReady", answer
        robot.until(lambda: not robot.gates and not self._busy(), "the check is given up")
        self.covers.planned.clear()
        self.covers.accepted.clear()
        self.covers.held = False

    def _nothing_any_more(self) -> None:
        """Not even a deceleration."""
        self._all_called_off()
        self.covers.slowing_until_ns = 0

    def covered(self) -> bool:
        """Whether an accepted job may run."""
        going = [one for one in self.covers.accepted if self._result(one) is None]
        return bool(going) and not self.covers.held

    def _result(self, asked: Asked) -> object:
        assert asked.number is not None
        return self.robot.controller.result(asked.number)

    def _not_called_off(self) -> set[int | None]:
        return {one.number for one in self.robot.controller.jobs.claims() if not one.called_off}

    def _busy(self) -> bool:
        """Whether the daemon is at a command that waits for hardware or for a plan."""
        return self.robot.state is State.HOMING or bool(self.robot.controller.jobs.planned)

    def _next_is_planned(self) -> None:
        """The command behind one that has ended has its turn."""
        robot = self.robot
        robot.until(lambda: len(robot.gates) == bool(self.covers.planned), "the next is planned")

    def _time_passed_otherwise(self) -> None:
        """What has ended covers nothing; a pause ends with the last job that it holds."""
        left = [one for one in self.covers.accepted if self._result(one) is None]
        self.covers.accepted = left
        if not left and not self.covers.planned and self.robot.state is not State.RUNNING:
            self.covers.held = False


def taken(state: State) -> set[Event]:
    """What has a rule there."""
    return {event for event, rules in TABLE.items() if state in rules}


def _count(what: str) -> None:
    walked[what] = walked.get(what, 0) + 1
