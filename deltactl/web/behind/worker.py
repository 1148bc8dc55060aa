"""Work that takes the processor for seconds, in a process of its own and at low priority.

`python -m deltactl.web.behind.worker KIND FILE...` writes one JSON object a line:
{"progress": text} any number of times, then {"result": {...}} or
{"error": text}. The files are named by the page, never by a browser.
"""

from __future__ import annotations

import json
import os
import sys
from collections.abc import Callable
from pathlib import Path
from typing import Any

from deltactl.foundation.errors import DeltactlError
from deltactl.foundation.extras import missing
from deltactl.foundation.plain_file import write_whole
from deltactl.recording.reading.reader import read_run

NICE = 10


def check_job(path: Path) -> dict[str, Any]:
    """What a job would do. Raises any DeltactlError when it must not run."""
    from deltactl.firmware_py.program.totals import check_job as dry_run

    return dry_run(path).as_json()


def check_robot(path: Path) -> dict[str, Any]:
    """The facts of a robot file. Raises ConfigError."""
    from deltactl.firmware_py.robot_file import load_robot

    robot = load_robot(path)
    return {"robot": robot.name, "drive": robot.drive.kind, "limits": robot.limits.model_dump()}


def run_report(recording: Path, out: Path) -> dict[str, Any]:
    """Write the report of a run."""
    from deltactl.firmware_py.run_report.report import write_report

    write_report(recording, out)
    return {}


def diagnose(folder: Path, robot_file: Path, *recordings: Path) -> dict[str, Any]:
    """Diagnose recordings of one robot together, by the robot file that the newest run carries.

    `folder` receives all results. robot_file: the robot file for tables, which contain none.
    """
    from deltactl.diagnosis.admission.which_robot import carried_by
    from deltactl.diagnosis.answer.corrected_robot import save_corrected
    from deltactl.diagnosis.api import diagnose as answer_of
    from deltactl.diagnosis.experiment import write_job
    from deltactl.diagnosis.report.next_run import saved_part
    from deltactl.diagnosis.report.page import write_report
    from deltactl.diagnosis.report.screen import screen_lines
    from deltactl.diagnosis.report.templates import PAGE
    from deltactl.firmware_py.named_files import CONFIG_FOLDER
    from deltactl.models.robot_files import load_with_effects
    from deltactl.web.behind.own_recordings import name_beside, reader

    for name in ("corrected.yaml", "next.yaml", "job.yaml"):
        (folder / name).unlink(missing_ok=True)
    robot = folder / "robot.yaml"
    carried = carried_by(recordings, robot_file)
    write_whole(robot, carried.robot_text)
    if carried.job_text:
        write_whole(folder / "job.yaml", carried.job_text)
    answer = answer_of(
        recordings, robot, json_out=folder / "answer.json", progress=_progress, read=reader()
    )
    # Whoever reads the report, or the corrected file, knows the name under which it was sent.
    answer = answer.model_copy(update={"recordings": [name_beside(path) for path in recordings]})
    model = load_with_effects(robot)
    write_report(answer, model, folder / "report.html")
    closing = []
    if answer.findings:
        save_corrected(robot, answer, folder / "corrected.yaml")
        if (folder / "corrected.yaml").read_text(encoding="utf-8") == carried.robot_text:
            (folder / "corrected.yaml").unlink()  # nothing is sure enough to be corrected
        closing.append(saved_part(answer, False, PAGE))
    if answer.next_experiment is not None:
        write_job(answer.next_experiment, folder / "next.yaml", robot, CONFIG_FOLDER)
    lines = screen_lines(answer, model, PAGE, closing=closing)
    return {
        "verdict": answer.verdict,
        "lines": lines,
        "heads": [line for line in lines if line.head],
        "components": [finding.component for finding in answer.findings],
    }


def compare(before: Path, after: Path) -> dict[str, Any]:
    """How far from its targets the platform was in two runs of a job: RMS distance [m]."""
    import numpy as np

    from deltactl.firmware_py.run_report.tracking import robot_of, track

    runs = [read_run(path) for path in (before, after)]
    robots = [robot_of(run) for run in runs]
    seen = [track(run, robot) for run, robot in zip(runs, robots, strict=True)]
    errors_m = [
        {error.name: float(np.sqrt(np.square(error.rms_m).sum())) for error in tracking.all()}
        for tracking in seen
    ]
    both = [name for name in errors_m[0] if name in errors_m[1]]
    return {
        "errors_m": {name: [errors[name] for errors in errors_m] for name in both},
        "whole": all(tracking.whole and tracking.windows_ns for tracking in seen),
        "same_file": robots[0].effects == robots[1].effects,
    }


def inspect(table: Path) -> dict[str, Any]:
    """How a table is read, as far as it tells."""
    from deltactl.web.behind.own_recordings import inspected

    return inspected(table)


KINDS: dict[str, Callable[..., dict[str, Any]]] = {
    "check_job": check_job,
    "check_robot": check_robot,
    "run_report": run_report,
    "diagnose": diagnose,
    "compare": compare,
    "inspect": inspect,
}


def main(arguments: list[str]) -> None:
    """Do one piece of work."""
    os.nice(NICE)
    kind, *files = arguments
    try:
        _say({"result": KINDS[kind](*(Path(file) for file in files))})
    except (DeltactlError, OSError) as error:
        typed = error.typed if isinstance(error, DeltactlError) else ""
        _say({"error": " ".join(str(error).split()), "typed": " ".join(typed.split())})
    except ModuleNotFoundError as error:
        _say({"error": str(missing("this", error, "diagnosis"))})


def _progress(text: str) -> None:
    _say({"progress": text})


def _say(message: dict[str, Any]) -> None:
    print(json.dumps(message, default=str), flush=True)


if __name__ == "__main__":
    main(sys.argv[1:])
