"""The robot file that is in force: what was read when the controller was built."""

from __future__ import annotations

import os
from pathlib import Path

from foundation.errors import DeltactlError
from foundation.strict_yaml import Document


class FileInForce:
    """Its text, kept; and whether the file on the disk says something else by now."""

    def __init__(self, path: Path):
        self.path = path
        self.text = Document.read(path).text
        self._stamp = self._stamp_now()
        self._same = True

    def changed(self) -> str:
        """In words, or empty. Reads the file again only when it was written to."""
        stamp = self._stamp_now()
        if stamp != self._stamp:
            self._stamp = stamp
            try:
                self._same = Document.read(self.path).text == self.text
            except DeltactlError:
                self._same = False
        if self._same:
            return ""
        return f"{self.path} has changed since it was read; restart the daemon to use it"

    def _stamp_now(self) -> tuple[int, int, int]:
        try:
            found = os.stat(self.path)
        except OSError:
            return 0, 0, 0
        return found.st_mtime_ns, found.st_size, found.st_ino
