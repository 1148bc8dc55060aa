"""Between the control loop and the disk: callers only touch memory, a thread does the writing.

A disk that stalls for a second must not delay a step. What is waiting is bounded; when the
bound is reached the caller waits (simulation) or the recording fails (robot), never silently. That
thread knows what to do when the disk says no.
"""

from __future__ import annotations

import contextlib
import errno
import os
import threading
import time
from collections import deque
from collections.abc import Callable

from deltactl.recording.writing.append_file import AppendFile
from deltactl.recording.writing.container import Container, McapChunk

BLOCK_NS = 500_000_000
"""Run time in one chunk."""
BLOCK_AGE_S = 0.5
"""Wall time after which a chunk is written although it is not full."""
BLOCK_BYTES = 2**20
WAITING_BYTES = 32 * 2**20
"""At some 60 kB a second, minutes of a disk that does not answer."""


class Spool:
    """A queue of blocks, filled by many threads and emptied by one.

    `before_cut` runs, with the spool locked, before a block is closed, so that whoever
    collects messages of its own can add them.
    """

    def __init__(self, before_cut: Callable[[], None], wait_when_behind: bool):
        self.changed = threading.Condition(threading.RLock())
        self.lost = 0
        """Messages that came after the end."""
        self._before_cut = before_cut
        self._wait_when_behind = wait_when_behind
        self._open: McapChunk | None = None
        self._full: deque[McapChunk] = deque()
        self._waiting_bytes = 0
        self._handed = 0
        self._done = 0
        self._sequences: dict[int, int] = {}
        self._ended = False

    def add(self, channel_id: int, log_ns: int, payload: bytes) -> bool:
        """Take a message. False, once, when the queue is full and waiting is not wanted."""
        with self.changed:
            if self._ended:
                self.lost += 1
                return True
            if self._open is None:
                self._open = McapChunk(time.monotonic())
            sequence = self._sequences.get(channel_id, 0)
            self._sequences[channel_id] = sequence + 1
            self._open.add(channel_id, sequence, log_ns, payload)
            if self._open.span_ns < BLOCK_NS and len(self._open.data) < BLOCK_BYTES:
                return True
            self.cut()
            return self._has_room()

    def cut(self) -> None:
        """Close the open block and queue it."""
        with self.changed:
            self._before_cut()
            if self._open is None:
                return
            block, self._open = self._open, None
            self._full.append(block)
            self._waiting_bytes += len(block.data)
            self._handed += 1
            self.changed.notify_all()

    def take(self, timeout_s: float) -> McapChunk | None:
        """The next block to write; an open one when it is old enough; None after `timeout_s`."""
        with self.changed:
            if not self._full and not self._ended:
                self.changed.wait(timeout_s)
            if not self._full and self._is_old():
                self.cut()
            return self._full.popleft() if self._full else None

    def done(self, block: McapChunk) -> None:
        """Say that a block that was taken is on the disk."""
        with self.changed:
            self._waiting_bytes -= len(block.data)
            self._done += 1
            self.changed.notify_all()

    def end(self) -> None:
        """Take no more; what is queued may still be taken."""
        with self.changed:
            self._ended = True
            self.changed.notify_all()

    def drop(self, taken: McapChunk | None = None) -> None:
        """Throw away what is queued, and a block that could not be written; count them."""
        with self.changed:
            self.end()
            blocks = [block for block in (taken, *self._full, self._open) if block is not None]
            self.lost += sum(block.messages() for block in blocks)
            self._done += len(self._full) + (taken is not None)
            self._full.clear()
            self._open = None
            self.changed.notify_all()

    @property
    def ended(self) -> bool:
        """Whether `end` was called."""
        return self._ended

    def wait_written(self, timeout_s: float) -> bool:
        """Wait until everything queued by now is written. False after `timeout_s`."""
        with self.changed:
            goal = self._handed
            return self.changed.wait_for(lambda: self._done >= goal, timeout_s)

    def _is_old(self) -> bool:
        if self._open is None:
            # Collected edges alone do not open a block, so look for them here.
            self._before_cut()
        return self._open is not None and time.monotonic() - self._open.born_s >= BLOCK_AGE_S

    def _has_room(self) -> bool:
        if self._wait_when_behind:
            self.changed.wait_for(lambda: self._ended or self._waiting_bytes < WAITING_BYTES)
        if self._waiting_bytes < WAITING_BYTES:
            return True
        self.end()
        return False


SYNC_S = 1.0
"""Wall time between two syncs: what a power cut may cost at most, beside one chunk."""
POLL_S = 0.2


class DiskThread:
    """Writes what the spool hands out, in a thread of its own, until it ends or the disk fails.

    `on_failure(reason)` is called at most once, from this thread.
    """

    def __init__(
        self,
        file: AppendFile,
        container: Container,
        spool: Spool,
        on_failure: Callable[[str], None],
    ):
        self._thread = threading.Thread(target=self._run, name="recorder", daemon=True)
        self._file = file
        self._container = container
        self._spool = spool
        self._on_failure = on_failure
        self._synced_s = time.monotonic()
        self._synced_size = file.size

    def start(self) -> None:
        """Begin writing."""
        self._thread.start()

    def join(self, timeout_s: float) -> bool:
        """Wait for the end of the thread. False after `timeout_s`."""
        self._thread.join(timeout_s)
        return not self._thread.is_alive()

    def _run(self) -> None:
        try:
            self._write_all()
            self._container.finish()
            self._file.sync()
        except OSError as error:
            self._give_up(_reason(error))
        except Exception as error:  # a fault of ours must be seen too, not just end a thread
            self._give_up(f"{type(error).__name__}: {error}")
        finally:
            self._file.close()

    def _write_all(self) -> None:
        while True:
            block = self._spool.take(POLL_S)
            if block is not None:
                self._write(block)
            elif self._spool.ended:
                return
            self._keep_safe()

    def _write(self, block: McapChunk) -> None:
        try:
            self._container.add_chunk(block)
        except BaseException:
            self._spool.drop(block)
            raise
        self._spool.done(block)

    def _keep_safe(self) -> None:
        """Sync now and then, and stop while the summary and the rest of the system still fit."""
        now_s = time.monotonic()
        if now_s - self._synced_s < SYNC_S or self._file.size == self._synced_size:
            return
        self._file.sync()
        self._synced_s, self._synced_size = now_s, self._file.size
        if self._file.free_bytes() < self._file.reserve_bytes:
            raise OSError(
                errno.ENOSPC, f"{self._file.reserve_bytes // 2**20} MiB must stay free on this disk"
            )

    def _give_up(self, reason: str) -> None:
        """Keep what is there, complete it if that is still possible, and say so once."""
        self._spool.drop()
        with contextlib.suppress(OSError, ValueError):
            self._container.finish()
            self._file.sync()
        self._on_failure(reason)


def _reason(error: OSError) -> str:
    if error.errno == errno.ENOSPC and error.strerror == os.strerror(errno.ENOSPC):
        return "the disk is full"
    return f"{error.strerror or error}"
