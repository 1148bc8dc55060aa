"""Every run of a daemon is checked when it is over: a new finding is announced.

A finding counts when two of three runs in a row have it, at the same component; what one run has
and the next two have not was chance. It is over when two runs in a row have it no more.
"""

from __future__ import annotations

import json
import time
from collections.abc import Callable, Sequence
from contextlib import suppress
from dataclasses import asdict, dataclass
from datetime import datetime
from pathlib import Path
from typing import Any

from deltactl.fleet.task import Book, Row, diagnose_one, stamp_of
from deltactl.foundation.errors import DeltactlError
from deltactl.foundation.one_screen import Part
from deltactl.foundation.plain_file import write_whole
from deltactl.recording.writing.retention import ENDING

FOLDER = "checks"
ANNOUNCED = "announced.json"
ENOUGH, OF = 2, 3
"""A run at the detection limit misses one time in three what is there, so two in a row would be
announced late; what chance finds in a healthy run, it hardly finds at the same place in two of
three."""
MISSED = 2
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
        [f"- {one.told()}" for one in announced], f"Announced ({len(announced)})",
        more="and {number} more, on the page", turns=2,
    )  # fmt: skip
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
    ordered = sorted(rows, key=lambda row: float(row["time_s"]))
    keys = {key for row in ordered for key in _found(row)}
    found = (_standing(ordered, key) for key in sorted(keys))
    return [mismatch for mismatch in found if mismatch is not None]


def read_announced(recordings: Path) -> list[Announcement]:
    """What a check service wrote; nothing where none runs."""
    try:
        found = json.loads((recordings / FOLDER / ANNOUNCED).read_text(encoding="utf-8"))
        return [Announcement(**entry) for entry in found]
    except (OSError, ValueError, TypeError):
        return []


def _standing(rows: list[Row], key: tuple[str, str]) -> Announcement | None:
    holds, first = False, rows[0]
    newest: dict[str, Any] = {}
    had: list[Row | None] = []
    for row in rows:
        size = _found(row).get(key)
        had.append(row if size else None)
        if size is not None:
            newest = {**size, "recording": row["recording"]}
        seen = [finding for finding in had[-OF:] if finding is not None]
        if holds:
            holds = any(had[-MISSED:])
        elif len(seen) >= ENOUGH:
            holds, first = True, seen[0]
    if not holds:
        return None
    says = _in_words(newest, key)
    sure = newest.get("probability")
    return Announcement(
        rows[-1]["robot"],
        *key,
        says,
        float(first["time_s"]),
        1.0 if sure is None else float(sure),
        newest["recording"],
    )


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
