"""`deltactl diagnose --fleet`: many recordings of many robots."""

from __future__ import annotations

from pathlib import Path
from typing import Any

from rich.progress import (
    BarColumn,
    MofNCompleteColumn,
    Progress,
    TextColumn,
    TimeRemainingColumn,
)

from deltactl.cli.output import errors, say, warn
from deltactl.foundation.counting import count
from deltactl.foundation.errors import ConfigError
from deltactl.foundation.extras import needs


def diagnose_many(
    pattern: str,
    robots: Path | None,
    out: Path,
    workers: int,
    scheduler: str | None,
    limits: list[str],
    sisters: bool = True,
) -> None:
    """Diagnose a fleet with a bar of progress; a bad file costs one line."""
    if robots is None:
        raise ConfigError("--fleet needs --robots FOLDER, where the robot files lie")
    known = _limits(limits)
    with needs("fleet", "deltactl diagnose --fleet"):
        import deltactl.fleet.run as run

    shown = (
        BarColumn(),
        MofNCompleteColumn(),
        TimeRemainingColumn(),
        TextColumn("{task.fields[now]}"),
    )
    with Progress(*shown, console=errors, transient=True, disable=not errors.is_terminal) as bar:
        task = bar.add_task("", total=None, now="looking for recordings")

        def progress(done: int, of: int, row: dict[str, Any]) -> None:
            if "error" in row:
                bar.console.print(row["error"], soft_wrap=True)
            bar.update(task, completed=done, total=of, now=Path(row["recording"]).name)

        rows = run.diagnose_fleet(
            pattern, robots, out, workers, scheduler, known, progress, sisters
        )
    bad = sum("error" in row for row in rows)
    missing = sum(row.get("verdict", "nothing_missing") != "nothing_missing" for row in rows)
    say(f"{count(len(rows), 'recording')}: {missing} with a mismatch, {bad} bad")
    say(f"page:  {out / run.PAGE}\ntable: {out / run.TABLE}")
    if bad == len(rows):
        warn("no recording could be read")


def _limits(given: list[str]) -> dict[str, float]:
    found = {}
    for text in given:
        name, _, value = text.partition("=")
        try:
            found[name] = float(value)
        except ValueError:
            value = ""
        if name.count(".") != 1 or not value:
            raise ConfigError(f"--limit {text}: write it as gear_backlash.width=0.01")
    return found
