"""Whether a request that was taken may still move the robot: whose it is, and what ended it.

A claim is made where the request arrives and goes with it, through the check of its job, the
queue and the run. Whoever calls the request off says so here; whoever is about to act on it asks
here, under the controller's lock.
"""

from __future__ import annotations

from collections.abc import Callable

from deltactl.foundation.errors import NotReady

CLIENT_WENT = "its client has gone"


class Owner:
    """A client, for as long as it is there."""

    def __init__(self) -> None:
        self.gone = False


class Claim:
    """One request that moves. Any thread may call; the first reason stays."""

    def __init__(self, owner: Owner | None = None, detach: bool = False):
        """`detach`: once it is accepted, it outlives its owner. No owner: as the process does."""
        self.owner = owner
        self.number = 0
        """Number of its job; 0 for a homing, and for a job before its check."""
        self.name = ""
        self.turn = 0
        """The robot's turn (`Condition.turns`) in which it was accepted."""
        self._detach = detach
        self._why = ""
        self._callbacks: list[Callable[[], None]] = []

    @property
    def called_off(self) -> str:
        """Why it no longer holds; empty while it does."""
        return self._why or (CLIENT_WENT if self.owner_gone else "")

    @property
    def owner_gone(self) -> bool:
        """Whether nobody waits for it any more."""
        return self.owner is not None and self.owner.gone

    def call_off(self, why: str) -> None:
        """It moves nothing any more."""
        self._why = self._why or why
        callbacks, self._callbacks = self._callbacks, []
        for callback in callbacks:
            callback()

    def when_called_off(self, callback: Callable[[], None]) -> None:
        """Call it at that moment, from any thread: it must not block."""
        self._callbacks.append(callback)
        if self.called_off:
            self.call_off(self.called_off)

    def must_hold(self, what: str) -> None:
        """Raise NotReady when it was called off."""
        if self.called_off:
            raise NotReady(f"cannot {what}: {self.called_off}")

    def accepted(self) -> None:
        """Its job is queued: from now on a detached one is nobody's."""
        self._callbacks.clear()
        if self._detach:
            self.owner = None
