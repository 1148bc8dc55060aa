"""The command worker: slow commands of all clients, one after another.

An `acknowledge` has a thread of its own, so that it waits for no job that is planned and no file
that is read; whatever comes after it waits for it.
"""

from __future__ import annotations

import logging
import threading
from collections import deque
from collections.abc import Callable, Container
from dataclasses import dataclass

from deltactl.firmware_py.controller.claim import Claim
from deltactl.firmware_py.daemon.actions import Actions
from deltactl.firmware_py.daemon.address import Peer
from deltactl.firmware_py.daemon.protocol import SLOW, Message, Request
from deltactl.foundation.errors import NotReady

AT_ONCE = frozenset({"acknowledge"})

_log = logging.getLogger(__name__)


@dataclass(frozen=True, slots=True)
class Command:
    """A slow request, who asked, whether they are still there, and where the answer goes.

    Neither `reply` nor `is_gone` may block. `claim` is what moves by it, and can be called off.
    `due_s` is the moment of the monotonic clock from which on a check is no longer waited for.
    """

    request: Request
    peer: Peer
    claim: Claim
    due_s: float
    is_gone: Callable[[], bool]
    reply: Callable[[Message], None]


class CommandWorker:
    """Carries out commands in the order they came. Some requests call off those before them.

    Nothing that waits holds its lock, so `call_off` never waits for a command.
    """

    def __init__(self, actions: Actions, most_waiting: int):
        self._actions = actions
        self._most = most_waiting
        self._waiting: deque[Command] = deque()
        self._now: Command | None = None
        """The one that is carried out."""
        self._first: deque[Command] = deque()
        """Those that do not wait for the one that is carried out."""
        self._busy_first = False
        self._changed = threading.Condition()
        self._closed = False
        self._threads = [
            threading.Thread(target=self._work, args=(take,), name=name, daemon=True)
            for name, take in (("commands", self._next), ("acknowledge", self._next_first))
        ]

    def start(self) -> None:
        """Begin to work."""
        self._actions.checks.start()
        for thread in self._threads:
            thread.start()

    @property
    def alive(self) -> bool:
        """Whether commands are still carried out."""
        return self._actions.checks.alive and all(one.is_alive() for one in self._threads)

    def put(self, command: Command) -> None:
        """Queue a command, or refuse it when too many wait."""
        with self._changed:
            waiting = self._first if command.request.do in AT_ONCE else self._waiting
            full = len(waiting) >= self._most
            if not full:
                waiting.append(command)
                self._changed.notify_all()
        if full:
            self._refuse(command, f"{self._most} commands are waiting; try again later")

    def call_off(self, why: str, which: Container[str] = SLOW) -> int:
        """Refuse what came before this and has not begun; what has begun moves nothing any more.

        An 'acknowledge' must not follow a later stop, nor a 'run' a later cancel. Returns how many.
        """
        with self._changed:
            queues = (self._first, self._waiting)
            dropped = [one for queue in queues for one in queue if one.request.do in which]
            for queue in queues:
                kept = [one for one in queue if one.request.do not in which]
                queue.clear()
                queue.extend(kept)
            now = self._now if self._now is not None and self._now.request.do in which else None
        for command in dropped:
            self._refuse(command, why)
        if now is not None:
            now.claim.call_off(why)
        checks = self._actions.checks.call_off(why) if "run" in which else 0
        return len(dropped) + (now is not None) + checks

    def close(self, timeout_s: float) -> None:
        """Finish the command that runs, drop the others."""
        self.call_off("the daemon is ending; start it again first")
        with self._changed:
            self._closed = True
            self._changed.notify_all()
        for thread in self._threads:
            thread.join(timeout_s)
        self._actions.checks.close(timeout_s)

    def _work(self, take: Callable[[], Command | None]) -> None:
        while (command := take()) is not None:
            if command.is_gone():
                _log.info("%s dropped: %s has gone", command.request.do, command.peer)
                continue
            answer = self._actions.perform(
                command.request, command.peer, command.claim, command.due_s
            )
            with self._changed:
                self._now = None
            command.reply(answer)

    def _next(self) -> Command | None:
        with self._changed:
            while (not self._waiting or self._first or self._busy_first) and not self._closed:
                self._changed.wait()
            self._now = self._waiting.popleft() if self._waiting else None
            return self._now

    def _next_first(self) -> Command | None:
        with self._changed:
            if self._busy_first:
                self._busy_first = False
                self._changed.notify_all()
            while not self._first and not self._closed:
                self._changed.wait()
            self._busy_first = bool(self._first)
            return self._first.popleft() if self._first else None

    def _refuse(self, command: Command, why: str) -> None:
        error = NotReady(f"cannot {command.request.do}: {why}")
        command.reply(self._actions.refuse(command.request, error))
