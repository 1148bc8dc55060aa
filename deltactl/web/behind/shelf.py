"""What the tab of recordings lists: runs, what somebody has sent, and several taken together."""

from __future__ import annotations

import hashlib
import itertools
import json
import re
from collections.abc import Iterator, Sequence
from contextlib import suppress
from dataclasses import dataclass
from pathlib import Path
from typing import Any
from urllib.parse import quote

from deltactl.foundation.errors import RecordingError
from deltactl.foundation.plain_file import write_whole
from deltactl.recording.reading.reader import configuration_in
from deltactl.recording.writing.retention import ENDING
from deltactl.web.behind.own_recordings import OwnRecordings

SHOWN = 40
"""Newest recordings that the page lists."""
BY_HAND = re.compile(r"(jog|go-?to)-\d{4}-\d\d-\d\dT")
"""Recordings of single moves: they say what moved the robot and when, and tell nothing else."""
RUN = re.compile(r"(?P<job>.+)-\d{4}-\d\d-\d\dT\d\d-\d\d-\d\d(-\d+)?")
TOGETHER = "together.json"
"""In the folder of several: the names of their folders."""


@dataclass(frozen=True, slots=True)
class Listed:
    """A recording in the list, or several, and the folder for what the page makes of it."""

    path: Path
    size_bytes: int
    written_s: float
    made: Path
    own: str = ""
    """Name of one that somebody has sent; else empty."""
    parts: tuple[Listed, ...] = ()
    """The recordings, where several were chosen to be diagnosed together."""

    @property
    def title(self) -> str:
        """What the list calls it."""
        if self.parts:
            return " + ".join(part.title for part in self.parts)
        return self.own or self.path.stem

    @property
    def singles(self) -> tuple[Listed, ...]:
        """The recordings that it is made of: itself, or its parts."""
        return self.parts or (self,)

    @property
    def answered_s(self) -> float:
        """When it was diagnosed; 0 if it never was."""
        try:
            return (self.made / "diagnosis.json").stat().st_mtime
        except OSError:
            return 0.0

    @property
    def diagnosis(self) -> dict[str, Any] | None:
        """What `deltactl.web.behind.worker diagnose` answered, if it was asked."""
        found = _json(self.made / "diagnosis.json")
        return found if isinstance(found, dict) else None

    @property
    def job(self) -> str:
        """Name of the job of a run, as its recording has it; else empty."""
        found = RUN.fullmatch(self.path.stem)
        return found.group("job") if found and not self.own else ""

    def again_in(self, listed: Sequence[Listed]) -> Listed | None:
        """The newest run of the same job after these recordings."""
        newest = self.singles[-1]
        later = [
            other
            for other in listed
            if newest.job
            and other.job == newest.job
            and not other.parts
            and other.written_s > newest.written_s
        ]
        return max(later, key=lambda other: other.written_s, default=None)

    def shown(self, text: str) -> str:
        """A text with the names that people gave in place of paths."""
        for single in self.singles:
            text = text.replace(str(single.path), single.own or single.path.name)
        return text


def file_url(listed: Listed) -> str:
    """Where a browser or a program gets the file of a recording."""
    return f"/api/v1/recordings/{quote(listed.made.name, safe='')}/file"


class Shelf:
    """Finds recordings, and keeps which were taken together."""

    def __init__(self, recordings: Path, own: OwnRecordings, made: Path):
        """made: a folder of the page's own, with one folder in it for each recording."""
        self._recordings, self._own, self._made = recordings, own, made
        self._robots: dict[tuple[int, int, int], str] = {}

    def newest_first(self, robot: str = "") -> list[Listed]:
        """The newest recordings of jobs; moves by hand are kept, and not listed.

        robot: runs that name another one are left out; empty for all of them.
        """
        singles = {single.made.name: single for single in self._singles()}
        found = [*singles.values(), *self._several(singles)]
        found.sort(key=lambda listed: listed.written_s, reverse=True)
        ours = (listed for listed in found if not robot or self._may_be_of(listed, robot))
        return list(itertools.islice(ours, SHOWN))

    def _may_be_of(self, listed: Listed, robot: str) -> bool:
        """Whether no recording names another robot; what somebody has sent is theirs to judge."""
        robots = {self._robot_in(single.path) for single in listed.singles if not single.own}
        return robots <= {robot, ""}

    def _robot_in(self, path: Path) -> str:
        """Which robot a recording names; empty where that cannot be read, or not yet."""
        with suppress(OSError, RecordingError):
            its = path.stat()
            key = (its.st_dev, its.st_ino, its.st_ctime_ns)
            if key not in self._robots:
                self._robots[key] = configuration_in(path).robot_name
            return self._robots[key]
        return ""

    def together(self, chosen: Sequence[Listed]) -> str:
        """Note that these belong together; the name of the folder for what is made of them."""
        names = sorted(listed.made.name for listed in chosen)
        word = hashlib.sha256(json.dumps(names).encode()).hexdigest()[:16]
        folder = self._made / f"together-{word}"
        folder.mkdir(parents=True, exist_ok=True)
        write_whole(folder / TOGETHER, json.dumps(names))
        return folder.name

    def _singles(self) -> Iterator[Listed]:
        for path in (*self._recordings.glob(f"*{ENDING}"), *self._own.newest_first()):
            if BY_HAND.match(path.name):
                continue
            with suppress(OSError):
                its = path.stat()
                own = self._own.name_of(path)
                yield Listed(path, its.st_size, its.st_mtime, self._made / path.stem, own)

    def _several(self, singles: dict[str, Listed]) -> Iterator[Listed]:
        """Those of which every recording is still there."""
        for noted in self._made.glob(f"together-*/{TOGETHER}"):
            names = _json(noted)
            if not isinstance(names, list) or not all(name in singles for name in names):
                continue
            parts = sorted((singles[name] for name in names), key=lambda part: part.written_s)
            with suppress(OSError):
                size = sum(part.size_bytes for part in parts)
                when_s = noted.stat().st_mtime
                yield Listed(parts[-1].path, size, when_s, noted.parent, parts=tuple(parts))


def _json(path: Path) -> Any:
    try:
        return json.loads(path.read_text(encoding="utf-8"))
    except (OSError, ValueError):
        return None
