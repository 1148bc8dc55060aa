"""The block of memory through which a step output and its pulse player talk.

One writer for every word, so no locks: the output writes what it asks, the player what it
did. Ticks lie in a ring; once played, a tick's slot holds the time of its real edge until the
output has collected it, so nothing that was sent can be lost. The same block serves inside
one process (a bytearray) and between two (an mmap). No imports beyond the smallest: this
file is loaded by the pulse process.
"""

from __future__ import annotations

import threading
from mmap import mmap
from typing import Final

CAPACITY: Final = 8192
SLOT_MASK: Final = CAPACITY - 1
MAGIC: Final = 0x64656C74_61000002

# Words written by the step output.
MAGIC_WORD: Final = 0
BEAT, PUSHED, STOP, COMMAND, KIND, CLOSE = 1, 2, 3, 4, 5, 6
ARGUMENTS: Final = 8  # three words
# Words written by the pulse player.
STATE, REASON, VERSION, SLIP, PLAYED, SERVED = 16, 17, 18, 19, 20, 21
RESULT, ENERGISED, ALIVE, REALTIME = 22, 23, 24, 25
SWITCHED: Final = 26
COUNTS: Final = 28  # three words

WORDS: Final = 64
TEXT_BYTES: Final = 128
DUE_OFFSET: Final = WORDS * 8 + 2 * TEXT_BYTES
CODE_OFFSET: Final = DUE_OFFSET + CAPACITY * 8
BOARD_BYTES: Final = CODE_OFFSET + CAPACITY

# STATE
DISABLED, READY, MOVING, STOPPED = 0, 1, 2, 3
# REASON; an alarm adds the motor's number
NO_REASON, REQUESTED, BY_ESTOP, NO_HEARTBEAT, CONTROLLER_GONE, LINE_FAULT, CLOSED = range(7)
BY_ALARM: Final = 16
ALL_MOTORS: Final = 7
"""In place of a motor's number: all three at once."""
# KIND
ENABLE, DISABLE, ACKNOWLEDGE, SET_COUNTS, SWITCH = 1, 2, 3, 4, 5
# RESULT
DONE, IS_STOPPED, ESTOP_OPEN, IS_MOVING, IS_DISABLED = 0, 1, 2, 3, 4
ALARM_ON: Final = 16
# REALTIME, what the system granted
GOT_FIFO, GOT_LOCKED_MEMORY, GOT_OWN_CORE = 1, 2, 4


class Fence:
    """Orders memory before the call against memory after it, also on ARM, one per thread of use.

    CPython has no fence; releasing and then acquiring a lock of one's own is one.
    """

    def __init__(self) -> None:
        self._lock = threading.Lock()
        self._lock.acquire()

    def __call__(self) -> None:
        self._lock.release()
        self._lock.acquire()


class Board:
    """Named views into the block. `words` are 64-bit, `due_ns` and `codes` the ring of ticks.

    A code has a bit for each stepping motor (0 to 2) and for each negative step (3 to 5).
    """

    def __init__(self, buffer: bytearray | mmap):
        whole = memoryview(buffer)
        self.buffer = buffer
        self.words = whole[: WORDS * 8].cast("q")
        self.due_ns = whole[DUE_OFFSET:CODE_OFFSET].cast("q")
        self.codes = whole[CODE_OFFSET:BOARD_BYTES]
        self._texts = whole[WORDS * 8 : DUE_OFFSET]
        whole.release()

    def set_request(self, text: str) -> None:
        """Why the output asks to stop (written by the output)."""
        self._write(0, text)

    def request(self) -> str:
        """Why the output asked to stop."""
        return self._read(0)

    def set_fault(self, text: str) -> None:
        """What went wrong with the lines (written by the player)."""
        self._write(TEXT_BYTES, text)

    def fault(self) -> str:
        """What went wrong with the lines."""
        return self._read(TEXT_BYTES)

    def reason_text(self) -> str:
        """Why the player stopped, in words."""
        code = self.words[REASON]
        if code == REQUESTED:
            return self.request()
        if code == LINE_FAULT:
            return self.fault()
        if code == BY_ALARM + ALL_MOTORS:
            return "alarm of all three motors at once: drive power lost?"
        if code > BY_ALARM:
            return f"alarm motor{code - BY_ALARM}"
        return REASON_TEXT[code]

    def counts(self, fence: Fence) -> tuple[int, int, int]:
        """The counters, all three of the same instant (unless their writer died in between)."""
        words = self.words
        for _ in range(1000):
            before = words[VERSION]
            fence()
            counts = (words[COUNTS], words[COUNTS + 1], words[COUNTS + 2])
            fence()
            if before == words[VERSION] and not before & 1:
                break
        return counts

    def release(self) -> None:
        """Let go of the block, so that an mmap can be closed."""
        for view in (self.words, self.due_ns, self.codes, self._texts):
            view.release()

    def _write(self, start: int, text: str) -> None:
        raw = text.encode("utf-8", "replace")[:TEXT_BYTES]
        self._texts[start : start + TEXT_BYTES] = raw.ljust(TEXT_BYTES, b"\0")

    def _read(self, start: int) -> str:
        raw = bytes(self._texts[start : start + TEXT_BYTES])
        return raw.rstrip(b"\0").decode("utf-8", "ignore")


REASON_TEXT: Final = {
    NO_REASON: "",
    BY_ESTOP: "e-stop",
    NO_HEARTBEAT: "no heartbeat",
    CONTROLLER_GONE: "controller gone",
    CLOSED: "closed",
}
