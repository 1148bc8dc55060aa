"""The condition a robot is in, and whether it is still the one that somebody counted on."""

from __future__ import annotations

import threading

from deltactl.firmware_py.controller.jobs.journal import Journal
from deltactl.firmware_py.controller.states import (
    TABLE,
    Event,
    Request,
    Rule,
    State,
    require,
    said,
)
from deltactl.foundation.clock import Clock
from deltactl.foundation.errors import NotReady


class Condition:
    """State and reason, under the one lock of a controller; changes go to the journal."""

    def __init__(self, clock: Clock, journal: Journal, simulated: bool = False):
        self.lock = threading.RLock()
        self.state = State.OFF
        self.why = ""
        self.turns = 0
        """Grows whenever what was true of the robot ends: whoever waited compares."""
        self._simulated = simulated
        self._clock = clock
        self._journal = journal

    def require(self, request: Request) -> Rule:
        """The rule of the table; NotReady, saying what to do, when there is none now."""
        return require(request, self.state, self.why, self._simulated)

    def rule(self, event: Event) -> Rule | None:
        """What the table says of an event now; None where it says that nothing happens."""
        return TABLE[event].get(self.state)

    def go(self, event: Event, then: State | None = None, why: str = "") -> None:
        """Enter the state that follows an event; `then` where the table leaves a choice.

        Raises AssertionError for a change that the table does not know, which ends the process
        that would make it: nothing else says what may move afterwards.
        """
        with self.lock:
            rule = self.rule(event)
            after = rule.then[0] if rule is not None and then is None else then
            if rule is None or after not in rule.then:
                raise AssertionError(f"no rule for {event} in {self.state}, then {after}")
            self.enter(after, why)

    def same(self, turn: int, what: str) -> None:
        """Raise NotReady when a stop, or whatever else ends a wait, came since that turn."""
        if self.turns != turn:
            why = f" ({self.why})" if self.why else ""
            raise NotReady(
                f"cannot {what}: the robot is {said(self.state)}{why} meanwhile; ask again"
            )

    def enter(self, state: State, why: str = "") -> None:
        """From now on."""
        with self.lock:
            if state is not self.state:
                self.note("state", state.value + (f": {why}" if why else ""))
            self.state, self.why = state, why

    def note(self, kind: str, text: str) -> None:
        """An event for the journal."""
        self._journal.event(self._clock.now_ns(), kind, text)
