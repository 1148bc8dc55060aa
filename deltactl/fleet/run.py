"""A fleet from its recordings to the table and the page."""

from __future__ import annotations

import glob
from collections.abc import Callable, Iterator
from pathlib import Path

from deltactl.fleet.book import Book, Row, stamp_of
from deltactl.fleet.cluster import Call, cluster
from deltactl.fleet.page import write_page
from deltactl.fleet.robots import Robots, recorded_at
from deltactl.fleet.sisters import sharpened
from deltactl.fleet.table import write_table
from deltactl.fleet.task import diagnose_one
from deltactl.foundation.errors import DeltactlError, MissingFile

Progress = Callable[[int, int, Row], None]
"""How many of how many are done, and the newest answer."""
ENDINGS = (".mcap", ".csv", ".csv.gz", ".parquet")
TABLE, PAGE = "answers.parquet", "fleet.html"


def diagnose_fleet(
    pattern: str,
    robots: Path,
    out: Path,
    workers: int = 2,
    scheduler: str | None = None,
    limits: dict[str, float] | None = None,
    progress: Progress = lambda done, of, row: None,
    sisters: bool = True,
) -> list[Row]:
    """Diagnose what the pattern names and is not answered yet; write table and page.

    sisters: what lasts on the other machines counts in the probabilities (`fleet.sisters`); the
    answers that are kept are those of each recording alone.
    Returns the newest answer of every recording. Raises MissingFile, ConfigError, RecordingError.
    """
    recordings = [Path(name) for name in sorted(glob.glob(pattern, recursive=True))]
    recordings = [path for path in recordings if path.is_file() and path.name.endswith(ENDINGS)]
    if not recordings:
        raise MissingFile(f"--fleet '{pattern}': no recording ({', '.join(ENDINGS)}) fits")
    known = Robots.in_folder(robots)
    book = Book(out)
    try:
        done = book.done()
        stamps = {str(path): stamp_of(path) for path in recordings}
        left = [path for path in recordings if done.get(str(path)) != stamps[str(path)]]
        answered = len(recordings) - len(left)
        with cluster(workers if left else 0, scheduler if left else None) as run:
            bad: list[Row] = []
            for (name, head), row in run(diagnose_one, _calls(left, known, bad)):
                answered += 1
                whole = {"recording": name, "stamp": stamps[name], **head, **row}
                book.add(whole)
                progress(answered, len(recordings), whole)
            for row in bad:
                answered += 1
                book.add(row | {"stamp": stamps[row["recording"]]})
                progress(answered, len(recordings), row)
        newest = {row["recording"]: row for row in book.rows() if row["recording"] in stamps}
    finally:
        book.close()
    rows = sorted(newest.values(), key=lambda row: (row.get("robot", ""), row.get("time_s", 0.0)))
    if sisters:
        rows = sharpened(rows)
    write_table(rows, out / TABLE)
    write_page(rows, out / PAGE, limits or {})
    return rows


def _calls(recordings: list[Path], robots: Robots, bad: list[Row]) -> Iterator[Call]:
    """Arguments of the tasks; a recording of no known robot goes to `bad` instead."""
    for path in recordings:
        try:
            robot, file = robots.of(path)
            head = {"robot": robot, "time_s": recorded_at(path).timestamp()}
        except (DeltactlError, OSError) as error:
            bad.append({"recording": str(path), "error": " ".join(str(error).split())})
            continue
        yield (str(path), head), (str(path.absolute()), str(file.absolute()))
