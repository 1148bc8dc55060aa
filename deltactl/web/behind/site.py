"""A corrected robot file in force for a while, and the way back to the one before."""

from __future__ import annotations

import contextlib
import itertools
import json
import re
import secrets
import shutil
from collections.abc import Callable
from contextlib import suppress
from dataclasses import asdict, dataclass, field
from functools import partial
from pathlib import Path
from typing import Any

import yaml

from deltactl.firmware_py.controller.contract import HomeSeen, JobResult, Status
from deltactl.firmware_py.named_files import CONFIG_FOLDER
from deltactl.firmware_py.robot_file import RobotFile
from deltactl.foundation.errors import NotReady
from deltactl.foundation.plain_file import write_whole
from deltactl.models.effects import CARDS, EffectCard
from deltactl.models.effects.card import Defect
from deltactl.models.robot import per_arm
from deltactl.web.access.tokens import Tokens
from deltactl.web.behind.healings import Healings
from deltactl.web.behind.history import History, Trace, Watcher
from deltactl.web.behind.known_robots import KnownRobot, KnownRobots
from deltactl.web.behind.link import DaemonLink, Seen
from deltactl.web.behind.own_jobs import OwnJobs
from deltactl.web.behind.own_recordings import OwnRecordings
from deltactl.web.behind.shelf import Listed, Shelf
from deltactl.web.behind.tasks import Progress, Tasks

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


Entry = dict[str, Any]
NOTHING = "nothing"
SURPRISE = "a surprise"


def defects() -> dict[str, Callable[[RobotFile], Entry]]:
    """What the cards offer to hide, in words, and its entry of `effects` in a robot."""
    offered = [(card.defect, card) for card in CARDS.values() if card.defect]
    offered.sort(key=lambda pair: pair[0].listed)
    return {defect.text: partial(_entry, card, defect) for defect, card in offered}


def _entry(card: EffectCard, defect: Defect, robot: RobotFile) -> Entry:
    unit = 1.0
    if card.length:
        lengths_m = per_arm(getattr(robot.geometry, card.length))
        unit = float(lengths_m[int(defect.component[-1]) - 1])
    parameters = {name: size * unit for name, size in defect.parameters.items()}
    return {"effect": card.name, "component": defect.component, "parameters": parameters}


class HiddenFault:
    """One choice, for everybody who looks at the page."""

    def __init__(self, path: Path):
        """path: which the simulated daemon reads when it homes."""
        self._path = path
        self.chosen = NOTHING
        """As it was chosen: a surprise stays one."""
        self.really = NOTHING
        """Which defect that is."""

    @property
    def choices(self) -> list[str]:
        """What can be chosen."""
        return [NOTHING, SURPRISE, *defects()]

    def hide(self, choice: str, robot: RobotFile) -> None:
        """Write the file anew. Raises KeyError for what is no choice."""
        drawn = secrets.choice(list(defects())) if choice == SURPRISE else choice
        if drawn == NOTHING:
            self._path.unlink(missing_ok=True)
        else:
            # The daemon reads all of it or the one before.
            write_whole(self._path, yaml.safe_dump({"effects": [defects()[drawn](robot)]}))
        self.chosen, self.really = choice, drawn


FIRST = "heart.yaml"


@dataclass
class Site:
    """Everything behind the pages."""

    link: DaemonLink
    known_robots: KnownRobots
    recordings: Path
    work: Path
    """A folder of the page's own: reports, answers, texts on their way to a check."""
    hidden_fault: HiddenFault | None = None
    """Hidden fault of a simulated robot whose daemon this page has started."""
    tokens: Tokens | None = None
    """Those of programs; none where nobody signs in."""
    tasks: Tasks = field(default_factory=Tasks)
    numbers: itertools.count[int] = field(default_factory=itertools.count)
    own: OwnRecordings = field(init=False)
    """Recordings that somebody has sent."""
    shelf: Shelf = field(init=False)
    """Recordings, and what was made of them."""
    jobs: OwnJobs = field(init=False)
    """Jobs that people keep on the page."""
    history: History = field(init=False)
    """How jobs ended."""
    trace: Trace = field(init=False, default_factory=Trace)
    """The newest minutes as curves."""
    healings: Healings = field(init=False)
    """The healing that is under way, and what came of the last one."""
    trial: Trial = field(init=False)
    """A corrected robot file that the robot runs with for a while."""
    _made: dict[str, Path] = field(default_factory=dict)

    def __post_init__(self) -> None:
        self.own = OwnRecordings(self.work / "own")
        self.healings = Healings(self.link, self.tasks, self.work)
        self.trial = Trial(self.link, self.work / "trial.json")
        self.shelf = Shelf(self.recordings, self.own, self.work / "made")
        self.jobs = OwnJobs(self.work / "jobs", self.shipped)
        self.history = History(self.work / "history.json")
        watcher = Watcher(self.history)

        def heard(status: Status, ended: JobResult | None) -> None:
            watcher.note(status, ended)
            known = self.known_robots.of(status.robot)
            self.trace.note(status, (lambda _: None) if known is None else known.measured)

        self.link.on_status = heard

    def robot_file(self) -> Path | None:
        """Robot file that runs, or that the page was given: for recordings that contain none."""
        known = self.known(self.link.seen)
        return self.known_robots.given if known is None else self.files().get(known.file)

    def known(self, seen: Seen) -> KnownRobot | None:
        """The robot file of the robot that runs."""
        return None if seen.status is None else self.known_robots.of(seen.status.robot)

    def listed(self) -> list[Listed]:
        """What the tab of recordings lists: of the robot that runs, newest first."""
        status = self.link.seen.status
        return self.shelf.newest_first("" if status is None else status.robot)

    def log(self, after: int) -> list[dict[str, Any]]:
        """Lines of the daemon's log behind a number. Raises what the daemon answers."""
        with self.link.client() as client:
            return client.log(after)

    def grows(self, recording: Path) -> bool:
        """Whether this is the recording of the run that is being made."""
        status = self.link.seen.status
        now = status.recording if status is not None else None
        return now is not None and Path(now).name == recording.name

    def files(self) -> dict[str, Path]:
        """Files by name: those that people keep on the page, and those that they cannot change."""
        return self.jobs.files() | self.shipped()

    def shipped(self) -> dict[str, Path]:
        """The robot that the page was given, its jobs beside it, and the project's files."""
        project = {path.name: path for path in sorted(CONFIG_FOLDER.glob("*.yaml"))}
        given = self.known_robots.given
        own = {} if given is None else {path.name: path for path in [*jobs_of(given), given]}
        return own | {name: path for name, path in project.items() if name not in own}

    @property
    def first_file(self) -> str:
        """The file that a new page shows: the heart, or the first job of a robot of one's own."""
        files = self.files()
        given = self.known_robots.given
        whose = jobs_of(given) if given is not None else []
        return FIRST if files[FIRST] in whose or not whose else whose[0].name

    def rename(self, listed: Listed, name: str) -> None:
        """Another name for a recording. Raises what the daemon answers."""
        if listed.own:
            self.own.rename(listed.path, name)
            return
        with self.link.client() as client:
            now = client.rename_recording(listed.path.name, name)
        self.history.renamed(listed.path.name, now)
        with suppress(OSError):  # what was made of it goes with it
            listed.made.rename(listed.made.with_name(Path(now).stem))

    def delete(self, listed: Listed) -> None:
        """Delete a recording, and what was made of it. Raises what the daemon answers."""
        if listed.own:
            self.own.remove(listed.path)
        elif not listed.parts:
            with self.link.client() as client:
                client.delete_recording(listed.path.name)
            self.history.renamed(listed.path.name, "")
        shutil.rmtree(listed.made, ignore_errors=True)

    async def diagnose(self, listed: Listed, progress: Progress = lambda _: None) -> dict[str, Any]:
        """Diagnose one or several, and keep the answer. Raises ServiceError."""
        made = listed.made
        made.mkdir(parents=True, exist_ok=True)
        robot_file = self.robot_file() or made / "robot.yaml"
        paths = [single.path for single in listed.singles]
        answer = await self.tasks.run("diagnose", made, robot_file, *paths, progress=progress)
        write_whole(made / "diagnosis.json", json.dumps(answer))
        return answer

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
        given = self.known_robots.given
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
