"""The robot file that is in force: what was read when the controller was built.

Its text is kept where systemd's clean-up finds it: the lines that have to be made safe are those
that were claimed, whatever the file on the disk says by then.
"""

from __future__ import annotations

import logging
import os
import threading
from pathlib import Path

from deltactl.firmware_py.controller.accepted_file import needs_restart
from deltactl.firmware_py.file_access import FileAccess, stamp_of, without_quoting
from deltactl.firmware_py.planning.prepared import ReadRobot, RobotRead, read_robot_here
from deltactl.firmware_py.robot_file import RobotFile
from deltactl.foundation.errors import DeltactlError
from deltactl.foundation.plain_file import write_whole
from deltactl.foundation.strict_yaml import text_of

GLANCE_S = 0.1
"""So long a status waits for what is said of a file that was written to just now."""
NAMED = FileAccess(follow=False, quote=False)
"""How a file that a client named is read: through no link, and without quoting its contents."""

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
    """Its text and robot, kept; and whether the file on the disk says something else by now.

    No call but the first and `newer` waits for a file to be read.
    """

    def __init__(
        self,
        path: Path,
        read: ReadRobot = read_robot_here,
        access: FileAccess | None = None,
        found: RobotRead | None = None,
    ):
        """read: who reads and checks it, now and later; access: with which it is opened;
        found: what it says, where it was read already. Raises MissingFile, ConfigError.
        """
        self.path = path
        self._read, self._access = read, access or FileAccess()
        found = found or read(path, self._access)
        self._stamp = self._as_read = found.stamp
        self.text, self.robot = found.text, found.robot
        self._says = ""
        self._looking: threading.Thread | None = None
        self._turn = threading.Lock()

    def changed(self, accepted: RobotFile) -> str:
        """In words with what to do, or empty. Reads the file again only when it was written to.

        The reading goes on beside whoever asks; until it has ended, that is what is said.
        """
        stamp = stamp_of(self.path)
        with self._turn:
            if self._looking is None and stamp != self._stamp:
                self._stamp = stamp
                self._looking = threading.Thread(
                    target=self._look, args=(accepted,), name="robot-file", daemon=True
                )
                self._looking.start()
            looking = self._looking
        if looking is not None:
            looking.join(GLANCE_S)
        with self._turn:
            if self._looking is None:
                return self._says
        return f"{self.path} was written to, and is being read"

    def newer(self, accepted: RobotFile) -> FileInForce | None:
        """What the file says by now, where the robot may be switched on with it."""
        if stamp_of(self.path) == self._as_read:
            return None
        try:
            if self._is_same():
                return None
            new = FileInForce(self.path, self._read, self._access)
        except DeltactlError:
            return None
        return None if needs_restart(accepted, new.robot) else new

    def _look(self, accepted: RobotFile) -> None:
        says = f"{self.path} has changed since it was read, and cannot be used"
        try:
            says = self._difference(accepted)
        except DeltactlError as error:
            says = f"{says}: {error}"
        finally:
            with self._turn:
                self._says, self._looking = says, None

    def _difference(self, accepted: RobotFile) -> str:
        if self._is_same():
            return ""
        section = needs_restart(accepted, self._read(self.path, self._access).robot)
        says = f"{self.path} has changed since it was read"
        if section:
            return f"{says} ({section}, too); restart the daemon to use it"
        return f"{says}; 'deltactl power off' and 'deltactl power on' to use it"

    def _is_same(self) -> bool:
        with without_quoting(self.path, self._access):
            return text_of(self.path, self._access.follow, self._access.most_bytes) == self.text
