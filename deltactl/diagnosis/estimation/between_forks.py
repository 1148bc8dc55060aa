"""What a forked process sends back: pickled, but for objects that both have in their memory."""

from __future__ import annotations

import pickle
from collections.abc import Mapping
from typing import Any, BinaryIO


def send(made: Any, out: BinaryIO, known: Mapping[int, object]) -> None:
    """Write what was made; `known` objects, by their number in memory, as that number."""
    _Sender(out, known).dump(made)


def receive(source: BinaryIO, known: Mapping[int, object]) -> Any:
    """What was sent; None when it did not come to its end."""
    try:
        return _Receiver(source, known).load()
    except (EOFError, pickle.UnpicklingError):
        return None


class _Sender(pickle.Pickler):
    """Sends known objects as their number in memory, which a fork shares."""

    def __init__(self, out: BinaryIO, known: Mapping[int, object]):
        super().__init__(out, protocol=pickle.HIGHEST_PROTOCOL)
        self.known = known

    def persistent_id(self, obj: object) -> int | None:
        """The number of a known object."""
        return id(obj) if id(obj) in self.known else None


class _Receiver(pickle.Unpickler):
    """Puts the known objects back in their places."""

    def __init__(self, source: BinaryIO, known: Mapping[int, object]):
        super().__init__(source)
        self.known = known

    def persistent_load(self, pid: int) -> object:
        """The object of a number."""
        return self.known[pid]
