"""Runs that go on where they ended, in this process, on a local cluster or on a Dask scheduler.

Every result is in a file of its own, written all or nothing.
"""

from __future__ import annotations

import itertools
import json
import time
from collections.abc import Callable, Iterator, Sequence
from contextlib import contextmanager
from dataclasses import dataclass
from pathlib import Path
from typing import Any, cast

from deltactl.fleet.run import connected
from deltactl.foundation.errors import ConfigError, ServiceError
from deltactl.foundation.extras import how_to_install
from deltactl.foundation.plain_file import write_whole

Result = tuple[int, dict[str, Any]]
"""The place of a job in the list that was given, and what came of it."""
Task = Callable[[int, int], dict[str, Any]]
"""A seed and a number -> a result as JSON; must be importable where it runs."""
Job = tuple[Task, int, int]
Run = Callable[[Sequence[Job]], Iterator[Result]]
ALONE = ": one case after another, here"
NO_DASK = f"Dask is not installed ({how_to_install('proof')}){ALONE}"


def here(jobs: Sequence[Job]) -> Iterator[Result]:
    """One case after another in this process."""
    for place, (task, seed, number) in enumerate(jobs):
        yield place, task(seed, number)


@contextmanager
def workers(count: int, scheduler: str | None, say: Callable[[str], None]) -> Iterator[Run]:
    """A function that runs cases; 0 workers is this process, an address is a Dask scheduler.

    Raises ConfigError when the scheduler is named but cannot be had; the function it gives raises
    ServiceError at its end when workers lost cases.
    """
    if scheduler is None and count == 0:
        yield here
        return
    try:
        from distributed import as_completed
    except ImportError as error:
        if scheduler is not None:
            raise ConfigError(f"--scheduler {scheduler}: {NO_DASK.removesuffix(ALONE)}") from error
        say(NO_DASK)
        yield here
        return
    finished = cast(Callable[[Any], Iterator[Any]], as_completed)
    with connected(count, scheduler) as client:

        def spread(jobs: Sequence[Job]) -> Iterator[Result]:
            # The first have the highest priority: a proof that is cut off lacks only the last.
            waiting = {
                client.submit(task, seed, number, pure=False, priority=-place): place
                for place, (task, seed, number) in enumerate(jobs)
            }
            lost: list[str] = []
            for future in finished(list(waiting)):
                if future.status == "finished":
                    yield waiting[future], future.result()
                else:
                    number = jobs[waiting[future]][2]
                    lost.append(f"number {number}: {future.exception()}")
                future.release()
            if lost:
                raise ServiceError(
                    f"{len(lost)} did not finish on the workers ({lost[0]}); "
                    "the same command again runs only those"
                )

        yield spread


PLAN, RESULT = "prove.json", "result.json"
Progress = Callable[[int, int, str], None]
Say = Callable[[str], None]


@dataclass(frozen=True)
class Part:
    """Jobs of one sort: where their results are kept, what runs them, and how one is reported."""

    stem: str
    numbers: Sequence[int]
    task: Task
    line: Callable[[dict[str, Any]], str]

    def file(self, out: Path, number: int) -> Path:
        """Where the result of a number is kept."""
        return out / f"{self.stem}_{number:04d}" / RESULT

    def results(self, out: Path) -> list[dict[str, Any]]:
        """What is there, up to the first that is missing: a cut-off must not prefer quick ones."""
        files = [self.file(out, number) for number in self.numbers]
        there = itertools.takewhile(Path.exists, files)
        return [json.loads(file.read_text(encoding="utf-8")) for file in there]


@dataclass(frozen=True)
class Means:
    """Where jobs run, for how long, and who hears of it."""

    count: int = 2
    scheduler: str | None = None
    minutes: float = float("inf")
    progress: Progress = lambda done, all_, text: None
    say: Say = lambda text: None


USUAL = Means()


def run_missing(parts: Sequence[Part], seed: int, out: Path, means: Means) -> None:
    """Run what is not in `out` yet; after `means.minutes` no further job is begun.

    Raises ConfigError when the scheduler does not answer, ServiceError when workers lost jobs.
    """
    until = time.monotonic() + 60.0 * means.minutes
    total = sum(len(part.numbers) for part in parts)
    missing = [job for job in _in_turn(parts) if not job[0].file(out, job[1]).exists()]
    done = total - len(missing)
    means.progress(done, total, f"{done} were there already" if done else "")
    if not missing:
        return
    with workers(means.count, means.scheduler, means.say) as run:
        for place, result in run([(part.task, seed, number) for part, number in missing]):
            part, number = missing[place]
            put_text(part.file(out, number), json.dumps(result, indent=1))
            done += 1
            means.progress(done, total, part.line(result))
            if time.monotonic() > until:
                means.say(f"stopped after {means.minutes:g} minutes; the same command goes on")
                return


def _in_turn(parts: Sequence[Part]) -> list[tuple[Part, int]]:
    """All evenly mixed, so that a proof that is cut off has its share of each."""
    jobs = [
        ((place + 0.5) / len(part.numbers), part, number)
        for part in parts
        for place, number in enumerate(part.numbers)
    ]
    return [(part, number) for _, part, number in sorted(jobs, key=lambda job: job[0])]


def claim(out: Path, plan: dict[str, Any]) -> None:
    """Begin a folder, or go on with one of the same plan. Raises ConfigError for another's."""
    out.mkdir(parents=True, exist_ok=True)
    file = out / PLAN
    if not file.exists():
        put_text(file, json.dumps(plan))
        return
    before = json.loads(file.read_text(encoding="utf-8"))
    if before != plan:
        held = ", ".join(f"{name} {value}" for name, value in before.items())
        raise ConfigError(f"{out}: holds a proof with {held}; use that or a new folder")


def put_text(path: Path, text: str) -> None:
    """All or nothing, so that a proof that was cut off can go on."""
    path.parent.mkdir(parents=True, exist_ok=True)
    write_whole(path, text + ("" if text.endswith("\n") else "\n"))
