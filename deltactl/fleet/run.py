"""Where recordings are diagnosed: here, on local processes, or on a Dask scheduler's machines."""

from __future__ import annotations

import glob
from collections.abc import Callable, Iterable, Iterator, Sequence
from contextlib import contextmanager
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from deltactl.fleet.page import fleet_html, write_table
from deltactl.fleet.task import Book, Robots, Row, diagnose_one, recorded_at, stamp_of
from deltactl.fleet.together import sharpened
from deltactl.foundation.errors import ConfigError, DeltactlError, MissingFile
from deltactl.foundation.extras import needs
from deltactl.foundation.plain_file import write_whole

AHEAD = 4
"""So many recordings a worker wait with the scheduler: memory does not grow with the fleet."""
PROFILER = "distributed.worker.profile.enabled"
"""Off where the workers are ours: a hundred times a second it notes the stack of what runs, and
keeps that for a thousand seconds. Deep in a diagnosis that is some 2 MB more a recording."""
Call = tuple[Any, tuple[Any, ...]]
"""A key, and the arguments of the task."""
Run = Callable[[Callable[..., Any], Iterable[Call]], Iterator[tuple[Any, Any]]]


@dataclass(frozen=True, slots=True)
class Workers:
    """The machines of a Dask scheduler at an address, or so many processes here; 0 is this one."""

    processes: int = 0
    scheduler: str | None = None


HERE = Workers()


@contextmanager
def cluster(workers: Workers) -> Iterator[Run]:
    """A function that runs a task on many arguments and gives (key, result) as they come.

    Raises ConfigError when nobody answers at the address.
    """
    if workers == HERE:
        yield lambda task, calls: ((key, task(*given)) for key, given in calls)
        return
    with needs("fleet", "deltactl fleet"):
        from distributed import as_completed
    with connected(workers.processes, workers.scheduler) as client:
        yield _spread(client, as_completed)


@contextmanager
def connected(workers: int, scheduler: str | None) -> Iterator[Any]:
    """A Dask client of the scheduler at an address, or of so many processes here.

    Raises ConfigError when nobody answers at the address.
    """
    import dask
    import distributed

    make: Any = distributed  # its constructors have no types
    if scheduler is not None:
        try:
            client = make.Client(scheduler, timeout="10s")
        except (OSError, ValueError) as error:
            raise ConfigError(
                f"--scheduler {scheduler}: nobody answers there; start `dask scheduler` and give "
                "the address it prints"
            ) from error
        with client:
            yield client
        return
    with (
        dask.config.set({PROFILER: False}),
        make.LocalCluster(n_workers=workers, threads_per_worker=1, dashboard_address=":0") as local,
        make.Client(local) as client,
    ):
        yield client


def _spread(client: Any, as_completed: Any) -> Run:
    def run(task: Callable[..., Any], calls: Iterable[Call]) -> Iterator[tuple[Any, Any]]:
        threads = max(1, sum(client.nthreads().values()))
        waiting = iter(calls)
        finished = as_completed()
        keys: dict[str, Any] = {}

        def send() -> None:
            for key, given in waiting:
                future = client.submit(task, *given, pure=False, retries=1)
                keys[future.key] = key
                finished.add(future)
                return

        for _ in range(AHEAD * threads):
            send()
        for future in finished:
            send()
            key = keys.pop(future.key)
            if future.status == "finished":
                yield key, future.result()
            else:
                yield key, {"error": f"{key}: its worker failed: {future.exception()}"}
            future.release()

    return run


Progress = Callable[[int, int, Row], None]
"""How many of how many are done, and the newest answer."""
ENDINGS = (".mcap", ".csv", ".csv.gz", ".parquet")
TABLE, PAGE = "answers.parquet", "fleet.html"


def diagnose_fleet(
    asked: str | Sequence[str],
    robots: Path,
    out: Path,
    workers: Workers = HERE,
    limits: dict[str, float] | None = None,
    progress: Progress = lambda done, of, row: None,
    sisters: bool = True,
) -> list[Row]:
    """Diagnose what is named and is not answered yet; write table and page.

    asked: recordings, folders of them, or patterns.
    sisters: what lasts on the other machines counts in the probabilities (`fleet.together`); the
    answers that are kept are those of each recording alone.
    Returns the newest answer of every recording. Raises MissingFile, ConfigError, RecordingError.
    """
    named = [asked] if isinstance(asked, str) else asked
    recordings = sorted({path for name in named for path in _fitting(name)})
    known = Robots.in_folder(robots)
    book = Book(out)
    try:
        done = book.done()
        stamps = {str(path): stamp_of(path) for path in recordings}
        left = [path for path in recordings if done.get(str(path)) != stamps[str(path)]]
        answered = len(recordings) - len(left)
        with cluster(workers if left else HERE) as run:
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
    write_whole(out / PAGE, fleet_html(rows, limits or {}))
    return rows


def _fitting(name: str) -> list[Path]:
    """The recordings of a pattern or folder, or the one of this name. Raises MissingFile."""
    path = Path(name)
    if path.is_dir():
        found = list(path.rglob("*"))
    else:
        found = [path] if path.exists() else [*map(Path, glob.glob(name, recursive=True))]
    fitting = [one for one in found if one.is_file() and one.name.endswith(ENDINGS)]
    if not fitting:
        raise MissingFile(f"'{name}': no recording ({', '.join(ENDINGS)}) fits")
    return fitting


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
