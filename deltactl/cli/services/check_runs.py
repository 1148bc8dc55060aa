"""`deltactl check-runs`: the service that checks every run when it is over."""

from __future__ import annotations

import os
import time
from dataclasses import asdict
from datetime import datetime
from pathlib import Path
from typing import Annotated

import typer

from deltactl.cli.robot.jobs import JsonOption


def register(app: typer.Typer) -> None:
    """Add the command of this file."""
    app.command()(check_runs)


def check_runs(
    recordings: Annotated[Path, typer.Option(help="The daemon's folder of recordings.")] = Path(
        "recordings"
    ),
    once: Annotated[
        bool, typer.Option("--once", help="Check the existing recordings and exit.")
    ] = False,
    json_out: JsonOption = False,
) -> None:
    """Check every run when it is over, at low priority, and announce a mismatch that is new.

    The page and `deltactl status` show what is announced.

    ```
    deltactl check-runs --recordings /var/lib/deltactl/recordings
    deltactl check-runs --once
    ```
    """
    from deltactl.cli.output import print_json, say
    from deltactl.foundation.extras import needs

    with needs("diagnosis", "check-runs"):
        import deltactl.diagnosis.api  # noqa: F401
        from deltactl.fleet.checks import RunChecks
    os.nice(15)
    checks = RunChecks(recordings)
    try:
        while True:
            for row in checks.look():
                verdict = row.get("verdict") or row.get("error") or row.get("skipped")
                if not json_out:
                    say(f"{Path(row['recording']).name}: {verdict}")
            if once:
                break
            time.sleep(5.0)
    except KeyboardInterrupt:
        pass
    finally:
        found = checks.announced()
        checks.close()
    if json_out:
        print_json([asdict(one) for one in found])
        return
    for one in found:
        since = datetime.fromtimestamp(one.since_s)
        say(f"new: {one.says}, since {since:%Y-%m-%d %H:%M} (probability {one.probability:.2f})")
