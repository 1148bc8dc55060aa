"""The daemon's log: to standard error, and the newest lines in memory for clients that ask."""

from __future__ import annotations

import faulthandler
import json
import logging
import os
import sys
from collections import deque
from collections.abc import Iterable, Iterator
from typing import Any, Final

from deltactl.foundation.printable import printable

KEPT: Final = 500
LONGEST: Final = 400
"""Characters of a line; the journal has all of it."""
MOST_BYTES: Final = 48_000
"""Size of one answer; a message of the protocol has at most 64 kB."""

Line = dict[str, Any]


class LogLines(logging.Handler):
    """Keeps what this program logs; every line has a number, and numbers only grow."""

    def __init__(self) -> None:
        super().__init__(logging.INFO)
        self._lines: deque[Line] = deque(maxlen=KEPT)
        self._last = 0

    def emit(self, record: logging.LogRecord) -> None:
        """Keep one line. The caller holds the handler's lock."""
        self._last += 1
        text = printable(record.getMessage())[:LONGEST]
        line = {"number": self._last, "time_s": record.created, "level": record.levelname.lower()}
        self._lines.append(line | {"text": text})

    def after(self, number: int) -> list[Line]:
        """The oldest lines behind that number that fit into an answer, or the newest behind 0.

        A number from before the daemon was started anew is answered like 0.
        """
        with self.lock or logging.Lock():  # type: ignore[attr-defined]
            if not 0 < number <= self._last:
                return list(_fitting(reversed(self._lines)))[::-1]
            return list(_fitting(line for line in self._lines if line["number"] > number))


def _fitting(lines: Iterable[Line]) -> Iterator[Line]:
    size = 0
    for line in lines:
        size += len(json.dumps(line)) + 1
        if size > MOST_BYTES:
            return
        yield line


def set_up_logging() -> None:
    """To standard error, which the journal keeps; a crash leaves the stacks of all threads."""
    faulthandler.enable()
    stamp = "" if "JOURNAL_STREAM" in os.environ else "%(asctime)s "
    logging.basicConfig(
        stream=sys.stderr, level=logging.INFO, format=f"{stamp}%(levelname)s %(message)s"
    )
    for handler in logging.getLogger().handlers:
        handler.addFilter(_write_out)


def _write_out(record: logging.LogRecord) -> bool:
    """One entry is one line, whatever names it contains (a traceback is ours, and follows it)."""
    record.msg, record.args = printable(record.getMessage()), None
    return True
