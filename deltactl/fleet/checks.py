"""Every run of a daemon is checked when it is over: a new finding is announced.

A finding counts when two of three runs in a row have it, at the same component; what one run has
and the next two have not was chance. It is over when two runs in a row have it no more.

Sensors, lengths and friction change with the temperature, over a day or since the machine was
switched on, and come back. An effect of that kind is announced once it has been there for a whole
day, with one sign, and twice as long as it ever was before it went: wear and what was knocked
stay, and what the sun does goes away at night.
"""

from __future__ import annotations

import json
import time
from collections import deque
from collections.abc import Callable, Sequence
from contextlib import suppress
from dataclasses import asdict, dataclass
from datetime import datetime
from pathlib import Path
from statistics import median

from deltactl.fleet.task import Book, Row, diagnose_one, stamp_of
from deltactl.foundation.errors import DeltactlError
from deltactl.foundation.one_screen import Part
from deltactl.foundation.plain_file import write_whole
from deltactl.models.effects import CARDS, has
from deltactl.models.effects.card import Trait
from deltactl.recording.writing.retention import ENDING

FOLDER = "checks"
ANNOUNCED = "announced.json"
ENOUGH, OF = 2, 3
"""A run at the detection limit misses one time in three what is there, so two in a row would be
announced late; what chance finds in a healthy run, it hardly finds at the same place in two of
three."""
MISSED = 2
PAUSE_S, COLD_RUNS = 4 * 3600.0, 5
"""After so long a pause a machine is cold, or nearly; so many such runs are remembered."""
DAY_S = 24 * 3600.0
"""What comes and goes with the temperature has come round by then."""
LONGER = 2.0
"""What was there before and went has to stay so many times as long as ever, and what stays of it
through a day has to be as much as what comes and goes."""
LIKELY = 0.5
"""Findings less probable than this are not counted."""
SHORTEST_S = 10.0
"""A jog tells nothing."""

Diagnose = Callable[[str, str], Row]


@dataclass(frozen=True)
class Announcement:
    """A finding that was not there before."""

    robot: str
    effect: str
    component: str
    says: str
    since_s: float
    """When the first run that has it began [s since 1970]."""
    probability: float
    recording: str

    def told(self, date: str = "%Y-%m-%d %H:%M") -> str:
        """In words; date: how the beginning of the first run is written."""
        since = datetime.fromtimestamp(self.since_s)
        return f"{self.says}, since {since:{date}} ({_sure(self.probability)} sure)"


def _sure(probability: float) -> str:
    """As the report has it, without what the report needs to be installed."""
    shown = f"{100.0 * probability:.0f}"
    return "above 99 %" if shown == "100" else f"{shown} %"


def shown(rows: Sequence[Row], announced: Sequence[Announcement]) -> list[Part]:
    """What was checked, as parts of one screen: what is announced, then the newest runs first."""
    new = Part(
        [f"- {one.told()}" for one in announced],
        f"Announced ({len(announced)})",
        more="and {number} more, on the page",
        turns=2,
    )
    runs = [f"{Path(row['recording']).name}: {outcome(row)}" for row in reversed(rows)]
    return [new, Part(runs, f"Checked ({len(runs)})", more="and {number} earlier runs")]


def outcome(row: Row) -> str:
    """What came of one run, in a sentence."""
    if "verdict" in row:
        return str(row.get("says") or row["verdict"].replace("_", " "))
    return f"left out ({row['skipped']})" if "skipped" in row else str(row["error"])


class RunChecks:
    """Checks the recordings of a folder; what it finds lies in `checks/` beside them."""

    def __init__(self, recordings: Path, diagnose: Diagnose = diagnose_one):
        self._recordings, self._diagnose = recordings, diagnose
        self.folder = recordings / FOLDER
        self._book = Book(self.folder)

    def look(self) -> list[Row]:
        """Check what is new and over; returns its rows."""
        done = self._book.done()
        rows = []
        for path, stamp in self._in_order():
            if done.get(str(path)) != stamp and (row := self._check(path, stamp)) is not None:
                self._book.add(row)
                rows.append(row)
        if rows or not (self.folder / ANNOUNCED).exists():
            self._announce()
        return rows

    def announced(self) -> list[Announcement]:
        """What holds now, over all robots of the folder."""
        latest = {row["recording"]: row for row in self._book.rows()}
        by_robot: dict[str, list[Row]] = {}
        for row in latest.values():
            if "verdict" in row:
                by_robot.setdefault(row["robot"], []).append(row)
        return [mismatch for rows in by_robot.values() for mismatch in standing(rows)]

    def close(self) -> None:
        """Give the files back."""
        self._book.close()

    def _in_order(self) -> list[tuple[Path, str]]:
        """Recordings with their stamps, oldest first; one that goes meanwhile is passed over."""
        found = []
        for path in self._recordings.glob(f"*{ENDING}"):
            with suppress(OSError):
                found.append((path.stat().st_mtime, path, stamp_of(path)))
        return [(path, stamp) for _, path, stamp in sorted(found)]

    def _check(self, path: Path, stamp: str) -> Row | None:
        """The row of a run; None for one that is still being written."""
        from deltactl.recording.reading.reader import read_run

        head: Row = {"recording": str(path), "stamp": stamp}
        try:
            run = read_run(path)
        except (DeltactlError, OSError) as error:
            return head | {"error": " ".join(str(error).split())}
        if not run.complete and not _old(path):
            return None
        its = run.configuration
        head |= {"robot": its.robot_name, "time_s": its.start_epoch_ns / 1e9}
        if run.end_ns / 1e9 < SHORTEST_S:
            return head | {"skipped": "short"}
        robot = self.folder / "robot.yaml"
        write_whole(robot, its.robot_text)
        return head | self._diagnose(str(path), str(robot))

    def _announce(self) -> None:
        text = json.dumps([asdict(mismatch) for mismatch in self.announced()], indent=1)
        write_whole(self.folder / ANNOUNCED, text + "\n")


def standing(rows: Sequence[Row]) -> list[Announcement]:
    """What is announced after the runs of one robot."""
    runs = RunsOfARobot()
    for row in sorted(rows, key=lambda row: float(row["time_s"])):
        runs.add(row)
    return runs.announced()


class RunsOfARobot:
    """What its runs had, one after the other, by effect and component."""

    def __init__(self) -> None:
        self._followed: dict[tuple[str, str], _Followed] = {}

    def add(self, row: Row) -> None:
        """The next run."""
        found = _found(row)
        for key in found.keys() - self._followed.keys():
            self._followed[key] = _Followed(key, found[key])
        for key, followed in self._followed.items():
            followed.add(row, found.get(key))

    def announced(self) -> list[Announcement]:
        """What holds after them."""
        every = (self._followed[key].announced() for key in sorted(self._followed))
        return [one for one in every if one is not None]


class _Followed:
    """One effect at one component."""

    def __init__(self, key: tuple[str, str], size: Row):
        self._key = key
        named = size.get("named", key[0])
        self._waits_s = DAY_S if named in CARDS and has(named, Trait.WARMS) else 0.0
        self._comes_and_goes = self._waits_s > 0.0
        self._had: list[Row | None] = []
        self._first: Row | None = None
        """The run since which it holds; None while it does not."""
        self._lasted_s = 0.0
        """For how long, with no more than `PAUSE_S` for a pause, which shows nothing."""
        self._is_announced = False
        self._newest: Row = {}
        self._sizes: deque[tuple[float, float]] = deque()
        """When and how far off it was on the last day."""
        self._cold: deque[float] = deque(maxlen=COLD_RUNS)
        """How far off it was in runs after a pause; 0 where it was not found."""
        self._ran_s: float | None = None

    def add(self, row: Row, size: Row | None) -> None:
        """A run, with the finding or without."""
        time_s = float(row["time_s"])
        gap_s = PAUSE_S if self._ran_s is None else time_s - self._ran_s
        self._lasted_s += min(gap_s, PAUSE_S)
        if gap_s >= PAUSE_S:
            self._cold.append(0.0 if size is None else abs(_off(size)))
        self._ran_s = time_s
        if size is not None:
            self._note(row, size, time_s)
        self._had = [*self._had[1 - OF :], None if size is None else row]
        seen = [one for one in self._had if one is not None]
        if self._first is None:
            if len(seen) >= ENOUGH:
                self._first = seen[0]
                self._lasted_s = 0.0
                self._cold.clear()
        elif not any(self._had[-MISSED:]):
            self._end()
        ready = self._first is not None and self._lasted_s >= self._waits_s and not self._swings
        self._is_announced = self._is_announced or ready

    def _note(self, row: Row, size: Row, time_s: float) -> None:
        """The finding of a run; one that changes its sign begins anew."""
        if self._comes_and_goes and self._newest and _off(size) * _off(self._newest) < 0.0:
            self._end()  # it swings about what the robot file says
        self._newest = {**size, "recording": row["recording"], "robot": row["robot"]}
        if self._comes_and_goes:
            self._sizes.append((time_s, abs(_off(size))))
            while self._sizes[0][0] < time_s - DAY_S:
                self._sizes.popleft()

    def announced(self) -> Announcement | None:
        """It, where it holds, and for as long as has to be waited."""
        if self._first is None or not self._is_announced:
            return None
        size = self._newest
        sure = size.get("probability")
        return Announcement(
            size["robot"],
            *self._key,
            _in_words(size, self._key),
            float(self._first["time_s"]),
            1.0 if sure is None else float(sure),
            size["recording"],
        )

    @property
    def _swings(self) -> bool:
        """Whether more of it comes and goes, within a day or after pauses, than stays."""
        if not self._comes_and_goes:
            return False
        sizes = sorted(off for _, off in self._sizes)
        aside = len(sizes) // 10
        least = min(sizes[aside], median(self._cold)) if self._cold else sizes[aside]
        return sizes[-1 - aside] > LONGER * least

    def _end(self) -> None:
        """What came and went has to stay longer than before, to be more than that."""
        if self._comes_and_goes and self._first is not None:
            self._waits_s = max(self._waits_s, LONGER * self._lasted_s)
        self._first, self._had, self._is_announced = None, [], False


def read_announced(recordings: Path) -> list[Announcement]:
    """What a check service wrote; nothing where none runs."""
    try:
        found = json.loads((recordings / FOLDER / ANNOUNCED).read_text(encoding="utf-8"))
        return [Announcement(**entry) for entry in found]
    except (OSError, ValueError, TypeError):
        return []


def _off(size: Row) -> float:
    """How far a size is from that of a machine without the effect, with its sign."""
    return float(size["value"]) - (1.0 if size["parameter"].startswith("scale") else 0.0)


def _in_words(size: Row, key: tuple[str, str]) -> str:
    """A finding as the report calls it, with its size."""
    from deltactl.diagnosis.report.names import effect
    from deltactl.diagnosis.report.sizes import quantity

    name = effect(size.get("named", key[0]), key[1])
    shown = quantity(size["value"], size["unit"], size["parameter"].partition("[")[0], digits=3)
    return f"{name} ({shown})"


def _found(row: Row) -> dict[tuple[str, str], Row]:
    """Likely findings of a run by effect and component."""
    return {
        (size["effect"], size["component"]): size
        for size in reversed(row.get("findings", []))
        if (size.get("probability") is None or size["probability"] >= LIKELY)
        and size["value"] is not None
    }


def _old(path: Path) -> bool:
    """Not written to for a minute: whoever wrote it is gone."""
    return time.time() - path.stat().st_mtime > 60.0
