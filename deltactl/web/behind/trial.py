"""A corrected robot file in force for a while, and the way back to the one before."""

from __future__ import annotations

import json
from contextlib import suppress
from dataclasses import asdict, dataclass
from pathlib import Path

from deltactl.firmware_py.controller.contract import HomeSeen, Status
from deltactl.foundation.errors import NotReady
from deltactl.foundation.plain_file import write_whole
from deltactl.web.behind.link import DaemonLink

NAME = "corrected.yaml"


@dataclass(frozen=True, slots=True)
class Tried:
    """A corrected file that the daemon was given."""

    before: str
    """The robot file that was in force."""
    in_force: str
    """Where the daemon keeps the corrected one."""
    found_in: str
    """The recordings by which it was corrected, as the list calls them."""


class Trial:
    """One for everybody who looks at the page; noted in a file, as the page may be started anew."""

    def __init__(self, link: DaemonLink, note: Path):
        self._link, self._note = link, note
        self._tried: Tried | None = None
        with suppress(OSError, ValueError, TypeError):
            self._tried = Tried(**json.loads(note.read_text(encoding="utf-8")))

    def of(self, status: Status) -> Tried | None:
        """What is being tried; None while the robot runs with a file that the page did not give."""
        tried = self._tried
        return tried if tried is not None and tried.in_force == status.robot_path else None

    def begin(self, corrected: str, found_in: str) -> HomeSeen:
        """Home by this text of a robot file. Raises what the daemon answers."""
        with self._link.client() as client:
            status = client.status()
            tried = self.of(status)
            before = status.robot_path if tried is None else tried.before
            try:
                return client.home_by_text(corrected, NAME)
            finally:  # also where the sensors did not agree: the file is in force all the same
                in_force = client.status().robot_path
                if in_force not in (status.robot_path, before):
                    self._keep(Tried(before, in_force, found_in))

    def end(self) -> HomeSeen:
        """Home by the file before. Raises NotReady, and what the daemon answers."""
        with self._link.client() as client:
            tried = self.of(client.status())
            if tried is None:
                raise NotReady("no corrected file is being tried")
            return client.home(robot=Path(tried.before))

    def _keep(self, tried: Tried) -> None:
        self._tried = tried
        self._note.parent.mkdir(parents=True, exist_ok=True)
        write_whole(self._note, json.dumps(asdict(tried)))
