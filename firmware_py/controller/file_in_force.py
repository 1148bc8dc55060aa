"""The robot file that is in force: what was read when the controller was built.

Its text is kept where systemd's clean-up finds it: the lines that have to be made safe are those
that were claimed, whatever the file on the disk says by then.
"""

from __future__ import annotations

import logging
import os
from pathlib import Path

from deltactl.firmware_py.controller.belief import needs_restart
from deltactl.firmware_py.file_access import FileAccess, without_quoting
from deltactl.firmware_py.robot_file import RobotFile, robot_in
from deltactl.foundation.errors import DeltactlError
from deltactl.foundation.plain_file import write_whole
from deltactl.foundation.strict_yaml import Document

KEPT = "robot-in-force.yaml"
"""In the daemon's own folder."""
FOLDERS = ("RUNTIME_DIRECTORY", "STATE_DIRECTORY")
"""Where systemd says which folders are the daemon's own; the first is empty after a start."""

_log = logging.getLogger(__name__)


def kept_text() -> Path | None:
    """Where the text in force is kept; None without a folder of one's own."""
    for name in FOLDERS:
        if folder := os.environ.get(name, "").split(":")[0]:
            return Path(folder) / KEPT
    return None


def keep_text(text: str) -> None:
    """Keep the text that is in force from now on; a disk that refuses it is only logged."""
    place = kept_text()
    if place is None:
        return
    try:
        write_whole(place, text, follow=False, mode=0o600)
    except OSError as error:
        _log.warning("%s: the robot file in force cannot be kept (%s)", place, error.strerror)


class FileInForce:
    """Its text, kept; and whether the file on the disk says something else by now."""

    def __init__(self, path: Path, access: FileAccess | None = None):
        """access: with which it is opened, now and later. Raises MissingFile, ConfigError."""
        self.path = path
        self._access = access or FileAccess()
        self._stamp = self._stamp_now()
        self._document = self._read()
        self.text = self._document.text
        self._same = True

    @classmethod
    def named(cls, path: Path) -> FileInForce:
        """One that a client named: no link leads to it, and no refusal says what stands in it."""
        return cls(path, FileAccess(follow=False, quote=False))

    def again(self) -> FileInForce:
        """The same file, as it is by now."""
        return FileInForce(self.path, self._access)

    def robot(self) -> RobotFile:
        """The robot of the text that was read. Raises ConfigError."""
        with without_quoting(self.path, self._access):
            return robot_in(self._document)

    def changed(self, believed: RobotFile) -> str:
        """In words with what to do, or empty. Reads the file again only when it was written to."""
        if not self._differs():
            return ""
        says = f"{self.path} has changed since it was read"
        try:
            section = needs_restart(believed, self.again().robot())
        except DeltactlError as error:
            return f"{says}, and cannot be used: {error}"
        if section:
            return f"{says} ({section}, too); restart the daemon to use it"
        return f"{says}; 'deltactl off' and 'deltactl on' to use it"

    def newer(self, believed: RobotFile) -> RobotFile | None:
        """What the file says by now, where the robot may be switched on with it."""
        if not self._differs():
            return None
        try:
            new = self.again().robot()
        except DeltactlError:
            return None
        return None if needs_restart(believed, new) else new

    def _differs(self) -> bool:
        stamp = self._stamp_now()
        if stamp != self._stamp:
            self._stamp = stamp
            try:
                self._same = self._read().text == self.text
            except DeltactlError:
                self._same = False
        return not self._same

    def _read(self) -> Document:
        with without_quoting(self.path, self._access):
            return Document.read(self.path, self._access.follow)

    def _stamp_now(self) -> tuple[int, int, int]:
        try:
            found = os.stat(self.path)
        except OSError:
            return 0, 0, 0
        return found.st_mtime_ns, found.st_size, found.st_ino
