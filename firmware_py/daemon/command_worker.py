"""The command worker: slow commands of all clients, one after another, on one thread."""

from __future__ import annotations

import logging
import threading
from collections import deque
from collections.abc import Callable
from dataclasses import dataclass

from deltactl.firmware_py.daemon.actions import Actions
from deltactl.firmware_py.daemon.address import Peer
from deltactl.firmware_py.daemon.protocol import Message, Request
from deltactl.foundation.errors import NotReady

_log = logging.getLogger(__name__)


@dataclass(frozen=True, slots=True)
class Command:
    """A slow request, who asked, whether they are still there, and where the answer goes.

    Neither `reply` nor `is_gone` may block.
    """

    request: Request
    peer: Peer
    is_gone: Callable[[], bool]
    reply: Callable[[Message], None]


class CommandWorker:
    """Carries out commands in the order they came. A stop drops those that still wait.

    Nothing that waits holds its lock, so `drop_waiting` never waits for a command.
    """

    def __init__(self, actions: Actions, most_waiting: int):
        self._actions = actions
        self._most = most_waiting
        self._waiting: deque[Command] = deque()
        self._changed = threading.Condition()
        self._closed = False
        self._thread = threading.Thread(target=self._work, name="commands", daemon=True)

    def start(self) -> None:
        """Begin to work."""
        self._thread.start()

    @property
    def alive(self) -> bool:
        """Whether commands are still carried out."""
        return self._thread.is_alive()

    def put(self, command: Command) -> None:
        """Queue a command, or refuse it when too many wait."""
        with self._changed:
            full = len(self._waiting) >= self._most
            if not full:
                self._waiting.append(command)
                self._changed.notify()
        if full:
            self._refuse(command, f"{self._most} commands are waiting; try again later")

    def drop_waiting(self, why: str) -> None:
        """Refuse everything that has not begun: an 'acknowledge' must not follow a later stop."""
        with self._changed:
            dropped, self._waiting = self._waiting, deque()
        for command in dropped:
            self._refuse(command, why)

    def close(self, timeout_s: float) -> None:
        """Finish the command that runs, drop the others."""
        self.drop_waiting("the daemon is ending; start it again first")
        with self._changed:
            self._closed = True
            self._changed.notify()
        self._thread.join(timeout_s)

    def _work(self) -> None:
        while (command := self._next()) is not None:
            if command.is_gone():
                _log.info("%s dropped: %s has gone", command.request.do, command.peer)
                continue
            command.reply(self._actions.perform(command.request, command.peer))

    def _next(self) -> Command | None:
        with self._changed:
            while not self._waiting and not self._closed:
                self._changed.wait()
            return self._waiting.popleft() if self._waiting else None

    def _refuse(self, command: Command, why: str) -> None:
        error = NotReady(f"cannot {command.request.do}: {why}")
        command.reply(self._actions.refuse(command.request, error))
