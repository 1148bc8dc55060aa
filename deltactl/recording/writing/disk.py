"""The thread that puts blocks on the disk and knows what to do when the disk says no."""

from __future__ import annotations

import contextlib
import errno
import os
import threading
import time
from collections.abc import Callable

from deltactl.recording.writing.append_file import AppendFile
from deltactl.recording.writing.container import Container
from deltactl.recording.writing.mcap_chunk import McapChunk
from deltactl.recording.writing.spool import Spool

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
