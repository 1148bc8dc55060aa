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


PREVIEWED = 800
"""Points of a path, as many as a picture of it needs."""
PLAYED = 500
"""Moments of a run, as many as its curves need."""


def check_job(path: Path) -> dict[str, Any]:
    """What a job would do, and where it would go [m]. Raises any DeltactlError if it must not run.

    `path_m`: a list of points for each path.
    """
    from deltactl.firmware_py.planner.plan import home_counts
    from deltactl.firmware_py.program.totals import program_of, summarise_program

    program = program_of(path)
    facts = summarise_program(program, home_counts(program.robot)).as_json()
    paths = [plan.first.lap.position_m for plan in program.plans()]
    every = max(1, sum(map(len, paths)) // PREVIEWED)
    return facts | {"path_m": [path_m[::every].round(5).tolist() for path_m in paths]}


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
        recordings, robot, json_out=folder / "answer.json", progress=write_progress, read=reader()
    )
    # Whoever reads the report, or the corrected file, knows the name under which it was sent.
    answer = answer.model_copy(update={"recordings": [name_beside(path) for path in recordings]})
    model = load_with_effects(robot)
    write_report(answer, model, folder / "report.html")
    if answer.findings:
        save_corrected(robot, answer, folder / "corrected.yaml")
        if (folder / "corrected.yaml").read_text(encoding="utf-8") == carried.robot_text:
            (folder / "corrected.yaml").unlink()  # nothing is sure enough to be corrected
    if answer.next_experiment is not None:
        write_job(answer.next_experiment, folder / "next.yaml", robot, CONFIG_FOLDER)
    lines = screen_lines(answer, model, PAGE, saved=False if answer.findings else None)
    return {
        "verdict": answer.verdict,
        "lines": lines,
        "heads": [line for line in lines if line.head],
        "components": [finding.component for finding in answer.findings],
    }


def errors(recording: Path) -> dict[str, Any]:
    """How far from its targets the platform was in a run: RMS distance [m], by who saw it."""
    import numpy as np

    from deltactl.firmware_py.run_report.tracking import robot_of, track

    run = read_run(recording)
    robot = robot_of(run)
    tracking = track(run, robot)
    return {
        "errors_m": {
            error.name: float(np.sqrt(np.square(error.rms_m).sum())) for error in tracking.all()
        },
        "whole": bool(tracking.whole and tracking.windows_ns),
        "effects": [effect.model_dump() for effect in robot.effects],
    }


def playback(recording: Path, folder: Path) -> dict[str, Any]:
    """Write what is needed to play a run: its curves and counts, and the robot file in it.

    Lengths are in mm, rates in steps/s; counts and measured places [m] for the drawing.
    """
    import numpy as np

    from deltactl.firmware_py.run_report.reference import targets_at
    from deltactl.firmware_py.run_report.tracking import (
        measured_errors,
        positions_of_counts,
        robot_of,
    )

    run = read_run(recording)
    robot = robot_of(run)
    end_s = max(run.end_ns * 1e-9, 0.1)
    t_s = np.linspace(0.0, end_s, min(PLAYED, max(2, round(end_s / 0.02))))
    counts = run.edges.counts_at((t_s * 1e9).astype(np.int64))
    target_m = targets_at(run, t_s)
    error_m = np.full_like(target_m, np.nan)
    if robot.sensors is not None and any(len(one.t_ns) for one in run.readings.values()):
        seen_s, seen_m = measured_errors(run, robot)
        error_m = np.stack([_held(t_s, seen_s, column) for column in seen_m.T], axis=1)
    rates = np.gradient(counts, t_s, axis=0)
    columns = {
        name: 1e3 * column
        for name, column in zip("xyz", positions_of_counts(robot, counts).T, strict=True)
    }
    columns["error"] = 1e3 * np.linalg.norm(error_m, axis=1)
    for axis, seen in run.readings.items():
        good = seen.where(seen.good)
        columns[f"range {axis}"] = 1e3 * _held(t_s, good.t_ns * 1e-9, good.distance_m)
    columns |= {f"motor {k + 1}": column for k, column in enumerate(rates.T)}
    played = {
        "t_s": t_s.round(3).tolist(),
        "counts": counts.tolist(),
        "measured_m": [None if None in row else row for row in map(_known, target_m + error_m)],
        "values": {name: _known(column) for name, column in columns.items()},
    }
    write_whole(folder / "played.yaml", run.configuration.robot_text)
    write_whole(folder / "played.json", json.dumps(played))
    return {}


def _held(t_s: Any, seen_s: Any, values: Any) -> Any:
    """The newest value at each time, for half a second; NaN before, after, and without any."""
    import numpy as np

    if not len(seen_s):
        return np.full(len(t_s), np.nan)
    place = np.searchsorted(seen_s, t_s, side="right") - 1
    fresh = (place >= 0) & (t_s - seen_s[place] < 0.5)
    return np.where(fresh, values[place], np.nan)


def _known(values: Any) -> list[float | None]:
    """For JSON: None where a value is not known."""
    return [None if value != value else round(float(value), 4) for value in values]


def compare(before: Path, after: Path) -> dict[str, Any]:
    """How far from its targets the platform was in two runs of a job: RMS distance [m]."""
    runs = [errors(path) for path in (before, after)]
    errors_m = [run["errors_m"] for run in runs]
    both = [name for name in errors_m[0] if name in errors_m[1]]
    return {
        "errors_m": {name: [sizes[name] for sizes in errors_m] for name in both},
        "whole": all(run["whole"] for run in runs),
        "same_file": runs[0]["effects"] == runs[1]["effects"],
    }


def heal(folder: Path, robot_file: Path, socket: Path, go_on: Path) -> dict[str, Any]:
    """Heal the robot of the daemon at a socket; `folder` holds the state. go_on: go_on or begin.

    Raises DeltactlError; then the old robot file is in force.
    """
    from deltactl.repair.heal import Healer, Order
    from deltactl.repair.heal_answer import lines_of
    from deltactl.repair.patients import DaemonPatient

    order = Order(robot_file, None, folder, go_on=go_on.name == "go_on")
    answer = Healer(order, DaemonPatient(socket, robot_file), write_progress).heal()
    lines = lines_of(answer, "press Heal", "press Undo")
    return {"outcome": answer["outcome"], "lines": lines}


def inspect(table: Path) -> dict[str, Any]:
    """How a table is read, as far as it tells."""
    from deltactl.web.behind.own_recordings import inspected

    return inspected(table)


KINDS: dict[str, Callable[..., dict[str, Any]]] = {
    "check_job": check_job,
    "check_robot": check_robot,
    "run_report": run_report,
    "diagnose": diagnose,
    "heal": heal,
    "compare": compare,
    "errors": errors,
    "playback": playback,
    "inspect": inspect,
}


def main(arguments: list[str]) -> None:
    """Do one piece of work."""
    os.nice(NICE)
    kind, *files = arguments
    try:
        write_line({"result": KINDS[kind](*(Path(file) for file in files))})
    except (DeltactlError, OSError) as error:
        typed = error.typed if isinstance(error, DeltactlError) else ""
        write_line({"error": " ".join(str(error).split()), "typed": " ".join(typed.split())})
    except ModuleNotFoundError as error:
        write_line({"error": str(missing("this", error, "diagnosis"))})


def write_progress(text: str) -> None:
    """Write what is being done, for whoever waits."""
    write_line({"progress": text})


def write_line(message: dict[str, Any]) -> None:
    """Write one JSON object, on a line of its own and at once."""
    print(json.dumps(message, default=str), flush=True)


if __name__ == "__main__":
    main(sys.argv[1:])
