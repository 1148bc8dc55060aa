"""Runs that go on where they ended: every result in a file of its own, written all or nothing."""

from __future__ import annotations

import itertools
import json
import time
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from deltactl.foundation.errors import ConfigError
from deltactl.foundation.plain_file import write_whole
from deltactl.proof.prove.workers import Task, workers

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
