"""Show, report and export recorded runs."""

from __future__ import annotations

from pathlib import Path
from typing import Any

from rich.box import SIMPLE_HEAD
from rich.table import Table

from deltactl.cli.output import console, decimals, print_json, say, waiting, warn
from deltactl.firmware_py.run_report.report import write_report
from deltactl.firmware_py.run_report.tracking import (
    ENDED_EARLY,
    RunTracking,
    robot_of,
    said_of_home,
    track,
)
from deltactl.foundation.errors import ConfigError
from deltactl.foundation.release import own_version
from deltactl.models.robot import AXES
from deltactl.recording.reading.reader import read_run

__all__ = ["export_recording", "show_recording", "show_tracking", "write_report"]


def show_tracking(recording: Path, quiet: bool) -> dict[str, Any]:
    """Print the tracking errors of a run, unless quiet; returns them as plain types."""
    with waiting(f"reading {recording.name}", quiet) as show:
        run = read_run(recording, progress=show)
        robot = robot_of(run)
        tracking = track(run, robot)
    if not quiet:
        if any(min(error.samples) for error in tracking.all()):
            console.print(tracking_table(run.configuration.job_name, tracking))
            if not tracking.whole:
                say(ENDED_EARLY.format(tracking.on_path_s))
            if said := said_of_home(run, robot, tracking):
                say(said)
        else:
            say(
                f"{run.configuration.job_name}: no readings between the first target of the path"
                " and where the run ended, so nothing to compare with; was it stopped before?"
            )
        for text in run.damage:
            warn(f"the recording is {text}")
    return {error.name: error.as_json() for error in tracking.all()}


def tracking_table(job: str, tracking: RunTracking) -> Table:
    """RMS and largest error of each axis, for everything there is to compare with."""
    title = f"{job}: error against the target, in mm"
    table = Table(title=title, title_justify="left", box=SIMPLE_HEAD, pad_edge=False)
    table.add_column("seen by", no_wrap=True)
    for axis in AXES:
        table.add_column(f"{axis} RMS", justify="right")
        table.add_column(f"{axis} max", justify="right")
    table.add_column("samples", justify="right")
    digits = decimals((float(max(error.rms_m)) for error in tracking.all()), 1)
    for error in tracking.all():
        pairs = zip(error.rms_m, error.max_m, strict=True)
        cells = [f"{value_m * 1e3:.{digits}f}" for pair in pairs for value_m in pair]
        table.add_row(error.name, *cells, str(min(error.samples)))
    return table


def show_recording(recording: Path, out: Path, json_out: bool) -> None:
    """`deltactl report`: the table and the HTML file."""
    tracking = show_tracking(recording, json_out)
    write_report(recording, out)
    if json_out:
        made = {"recording": recording, "tracking": tracking, "report": out}
        print_json(made | {"version": own_version()})
    else:
        say(f"report: {out}")


ROBOT_FORMATS = (".urdf", ".xml", ".mjcf")
"""Endings of robots in the files of other programs."""


def export_robot(robot: Path, out: Path) -> None:
    """`deltactl export` of a robot file: as URDF, or as MJCF with the loops closed.

    Of a chain its model, with the effects of the file in it.
    """
    from deltactl.firmware_py.exporting.mjcf import mjcf_text
    from deltactl.firmware_py.exporting.urdf import urdf_text
    from deltactl.firmware_py.named_files import ROBOT_KEY, find
    from deltactl.firmware_py.robot_file import load_robot
    from deltactl.foundation.plain_file import said_of_output, write_whole
    from deltactl.foundation.strict_yaml import Document

    file = find(str(robot), key=ROBOT_KEY)
    if Document.read(file).data.get("kind") == "chain":
        _export_chain(file, out)
        return
    described = load_robot(file)
    urdf = out.suffix.lower() == ".urdf"
    text = urdf_text(described) if urdf else mjcf_text(described)
    with said_of_output(out):
        write_whole(out, text)
    what = "URDF, a tree cut at forearms 2 and 3" if urdf else "MJCF, with its loops closed"
    say(f"{out}: {described.name} as {what}")


def _export_chain(robot: Path, out: Path) -> None:
    """The model of a chain with what was found in it, and beside it its robot file."""
    from deltactl.foundation.plain_file import said_of_output, write_whole
    from deltactl.repair.corrected_model import corrected_model

    made, file = corrected_model(robot, out), out.with_suffix(".yaml")
    if file.exists() and file.resolve() == robot.resolve():
        raise ConfigError(f"{file}: is the robot file itself; name the model otherwise")
    for path, text in ((out, made.model), (file, made.robot)):
        with said_of_output(path):
            write_whole(path, text)
    for effects, where in ((made.written, "in the model"), (made.kept, "stays in the robot file")):
        for one in effects:
            say(f"{one.effect.replace('_', ' ')} of {one.component}: {where}")
    say(f"{out}: the model; {file}: the robot file that uses it")


def export_to_ros(recording: Path, out: Path) -> None:
    """`deltactl export` of a run as MCAP with ROS 2 messages."""
    from deltactl.firmware_py.exporting.ros2 import export_ros2

    with waiting(f"reading {recording.name}", False) as show:
        run = read_run(recording, progress=show)
        show(f"writing {out.name}")
        states = export_ros2(run, out)
    say(f"{out}: {states} states in /joint_states and /tf, the robot in /robot_description")


def export_recording(recording: Path, out: Path, truth: bool) -> None:
    """`deltactl export`: a flat table in the format of the file name's ending."""
    from deltactl.recording.tables.flat_files import write_flat
    from deltactl.recording.tables.rounds import flatten, flatten_unseen, has_readings

    with waiting(f"reading {recording.name}", False) as show:
        run = read_run(recording, progress=show)
        table = flatten(run, truth) if has_readings(run) else flatten_unseen(run, truth)
        show(f"writing {out.name}")
        write_flat(table, out)
    say(f"{out}: {len(table)} rows")
