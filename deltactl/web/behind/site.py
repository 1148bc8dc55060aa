"""What all open pages share: the link to the daemon, the folders, the workers."""

from __future__ import annotations

import contextlib
import itertools
import re
import secrets
import shutil
from collections.abc import Callable, Coroutine
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

from deltactl.firmware_py.named_files import CONFIG_FOLDER
from deltactl.foundation.plain_file import write_whole
from deltactl.web.behind.belief import Belief, Beliefs
from deltactl.web.behind.concealment import Concealment
from deltactl.web.behind.link import DaemonLink, Seen
from deltactl.web.behind.own_recordings import OwnRecordings
from deltactl.web.behind.shelf import Listed, Shelf
from deltactl.web.behind.tasks import Tasks
from deltactl.web.behind.trial import Trial

FIRST = "heart.yaml"
Act = Callable[..., Coroutine[Any, Any, bool]]


@dataclass
class Site:
    """Everything behind the pages."""

    link: DaemonLink
    beliefs: Beliefs
    recordings: Path
    work: Path
    """A folder of the page's own: reports, answers, texts on their way to a check."""
    concealment: Concealment | None = None
    """Of a simulated robot whose daemon this page has started."""
    tasks: Tasks = field(default_factory=Tasks)
    numbers: itertools.count[int] = field(default_factory=itertools.count)
    own: OwnRecordings = field(init=False)
    """Recordings that somebody has sent."""
    shelf: Shelf = field(init=False)
    """Recordings, and what was made of them."""
    trial: Trial = field(init=False)
    """A corrected robot file that the robot runs with for a while."""
    _made: dict[str, Path] = field(default_factory=dict)

    def __post_init__(self) -> None:
        self.own = OwnRecordings(self.work / "own")
        self.trial = Trial(self.link, self.work / "trial.json")
        self.shelf = Shelf(self.recordings, self.own, self.work / "made")

    def robot_file(self) -> Path | None:
        """Of the robot that runs, or that the page was given: for recordings that carry none."""
        belief = self.belief(self.link.seen)
        return self.beliefs.given if belief is None else self.files().get(belief.file)

    def belief(self, seen: Seen) -> Belief | None:
        """The robot file of the robot that runs."""
        return None if seen.status is None else self.beliefs.of(seen.status.robot)

    def listed(self) -> list[Listed]:
        """What the tab of recordings lists, newest first."""
        return self.shelf.newest_first()

    def grows(self, recording: Path) -> bool:
        """Whether this is the recording of the run that is being made."""
        status = self.link.seen.status
        now = status.recording if status is not None else None
        return now is not None and Path(now).name == recording.name

    def files(self) -> dict[str, Path]:
        """Files by name: the robot that the page was given, its jobs beside it, the project's."""
        project = {path.name: path for path in sorted(CONFIG_FOLDER.glob("*.yaml"))}
        given = self.beliefs.given
        own = {} if given is None else {path.name: path for path in [*jobs_of(given), given]}
        return own | {name: path for name, path in project.items() if name not in own}

    @property
    def first_file(self) -> str:
        """The file that a new page shows: the heart, or the first job of a robot of one's own."""
        files = self.files()
        given = self.beliefs.given
        whose = jobs_of(given) if given is not None else []
        return FIRST if files[FIRST] in whose or not whose else whose[0].name

    def key_of(self, path: Path) -> str:
        """A word by which a browser asks for a file that the page made; it never names one."""
        for key, known in self._made.items():
            if known == path:
                return key
        key = secrets.token_urlsafe(12)
        self._made[key] = path
        return key

    def path_of(self, key: str) -> Path | None:
        """The file behind such a word."""
        return self._made.get(key)

    def draft(self, text: str) -> Path:
        """A text from a browser as a file, under a name of ours."""
        folder = self.work / "drafts" / str(next(self.numbers))
        folder.mkdir(parents=True, exist_ok=True)
        given = self.beliefs.given
        if given is not None and given.parent != CONFIG_FOLDER:  # a job finds its robot beside it
            write_whole(folder / given.name, given.read_bytes())
        path = folder / f"draft-for-{given.name if given else 'page.yaml'}"
        write_whole(path, text.encode("utf-8", errors="replace"))
        return path

    def forget(self, draft: Path) -> None:
        """Remove a draft."""
        shutil.rmtree(draft.parent, ignore_errors=True)


def jobs_of(robot: Path) -> list[Path]:
    """The jobs beside a robot file that name it."""
    naming = re.compile(rf"""^robot:\s*["']?{re.escape(robot.name)}["']?\s*(#.*)?$""", re.MULTILINE)
    found = []
    for path in sorted(robot.parent.glob("*.yaml")):
        with contextlib.suppress(OSError, UnicodeDecodeError):
            if naming.search(path.read_text(encoding="utf-8")):
                found.append(path)
    return found
