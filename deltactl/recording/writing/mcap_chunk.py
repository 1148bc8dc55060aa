"""Messages on their way into one MCAP chunk, with the index viewers need to find them."""

from __future__ import annotations

import struct

_MESSAGE = struct.Struct("<BQHIQQ")
"""Opcode, length, channel, sequence, log time, publish time (MCAP specification, op 0x05)."""
_MESSAGE_OPCODE = 0x05
_HEAD_BYTES = 22
_INDEX_ENTRY = struct.Struct("<QQ")


class McapChunk:
    """Messages of about half a second; becomes one chunk."""

    __slots__ = ("born_s", "data", "first_ns", "index", "last_ns")

    def __init__(self, born_s: float):
        self.born_s = born_s
        self.data = bytearray()
        self.index: dict[int, bytearray] = {}
        """Per channel: log time and offset of every message, as MCAP's MessageIndex wants them."""
        self.first_ns = 2**63
        self.last_ns = 0

    def add(self, channel_id: int, sequence: int, log_ns: int, payload: bytes) -> None:
        """Append one message."""
        entries = self.index.setdefault(channel_id, bytearray())
        entries += _INDEX_ENTRY.pack(log_ns, len(self.data))
        self.data += _MESSAGE.pack(
            _MESSAGE_OPCODE, _HEAD_BYTES + len(payload), channel_id, sequence, log_ns, log_ns
        )
        self.data += payload
        self.first_ns = min(self.first_ns, log_ns)
        self.last_ns = max(self.last_ns, log_ns)

    @property
    def span_ns(self) -> int:
        """Run time between the earliest and the latest message."""
        return max(0, self.last_ns - self.first_ns)

    def messages(self) -> int:
        """How many messages it holds."""
        return sum(len(entries) for entries in self.index.values()) // _INDEX_ENTRY.size
