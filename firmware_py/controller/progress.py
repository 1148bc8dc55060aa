"""Proof that every loop goes round: a count that one hanging loop is enough to hold."""

from __future__ import annotations


class Progress:
    """Counts the times at which all loops in question had moved on since the time before.

    A smallest of counters would not do: a loop that is ahead could hang unnoticed until the
    slowest has caught up, and the result would fall when another loop joins in.
    """

    def __init__(self) -> None:
        self._count = 0
        self._seen: dict[str, int] = {}

    def count(self, **rounds: int) -> int:
        """Look at the loops' own counters now; returns how often all have moved."""
        if all(self._seen.get(name) != value for name, value in rounds.items()):
            self._seen |= rounds
            self._count += 1
        return self._count
