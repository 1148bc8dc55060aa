"""Waiting on the spot: for a time, or for an input that must come in time."""

from __future__ import annotations

from collections.abc import Callable, Mapping

from deltactl.firmware_py.program.instructions import Wait, WaitFor
from deltactl.foundation.clock import ns

Inputs = Mapping[str, Callable[[], bool]]


class Standing:
    """One wait. Its time stands still while the job is paused."""

    def __init__(self, leaf: Wait | WaitFor, now_ns: int, inputs: Inputs):
        timed = isinstance(leaf, Wait)
        most_ns = ns(leaf.seconds if isinstance(leaf, Wait) else leaf.within_s)
        self._leaf, self._inputs = leaf, inputs
        self._until_ns = now_ns + most_ns
        self._paused_ns: int | None = None
        self.planned_ns = most_ns if timed else 0
        """How much of the job's planned time it takes."""

    def over(self, now_ns: int) -> bool:
        """Whether the job may go on."""
        leaf = self._leaf
        if isinstance(leaf, Wait):
            return now_ns >= self._until_ns
        return self._inputs[leaf.input]() == leaf.is_on

    def in_vain(self, now_ns: int) -> bool:
        """Whether what was waited for has not come in time."""
        return isinstance(self._leaf, WaitFor) and now_ns >= self._until_ns

    def pause(self, now_ns: int) -> None:
        """The time stands still."""
        self._paused_ns = now_ns

    def resume(self, now_ns: int) -> None:
        """It goes on."""
        if self._paused_ns is not None:
            self._until_ns += now_ns - self._paused_ns
            self._paused_ns = None

    def says(self) -> str:
        """Why it was in vain."""
        assert isinstance(self._leaf, WaitFor)
        return f"waited {self._leaf.within_s:g} s for {self._leaf.says()}, in vain"
