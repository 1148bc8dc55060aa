"""One HTML file about one run, to look at and to send."""

from __future__ import annotations

import datetime
import json
import math
from collections.abc import Iterable
from pathlib import Path

from deltactl.charts.page import HINT, columns, facts, folded, heading, page, paragraph, table
from deltactl.firmware_py.robot_file import RobotFile
from deltactl.firmware_py.run_report import sections
from deltactl.firmware_py.run_report.reference import arrivals
from deltactl.firmware_py.run_report.sections import health_strip, sensor_health, servo_section
from deltactl.firmware_py.run_report.tracking import (
    ENDED_EARLY,
    RunTracking,
    Tracking,
    asked_path,
    robot_of,
    track,
)
from deltactl.foundation.errors import RecordingError
from deltactl.foundation.plain_file import write_whole
from deltactl.foundation.printable import count
from deltactl.models.robot import AXES
from deltactl.recording.reading.reader import read_run
from deltactl.recording.reading.run import Run

MAXIMUM_EVENTS = 300

ABOUT: dict[str, str] = {
    "simulated truth": "where the simulated robot really was",
    "measured": "positions from the three ranges; contains the sensors' noise",
    "commanded": "each target's counts through the robot file's linkage: inverse kinematics "
    "and whole steps",
}


def write_report(recording: Path, out: Path) -> None:
    """Report a recorded run. Raises RecordingError, ConfigError."""
    run = read_run(recording)
    text = report_html(run, robot_of(run))
    try:
        write_whole(out, text)
    except OSError as error:
        raise RecordingError(f"{out}: cannot be written ({error.strerror})") from error


def report_html(run: Run, robot: RobotFile) -> str:
    """The report as one HTML document."""
    tracking = track(run, robot)
    parts = [
        *_warnings(run, tracking),
        columns([facts(_facts(run, robot, tracking)), _errors(tracking)]),
        *_curves(asked_path(run, robot), robot, tracking),
        *servo_section(run, tracking.windows_ns),
        *([] if robot.sensors is None else _sensors(run)),
        *_events(run),
        *_files(run),
    ]
    title = f"{run.configuration.job_name or 'Run'} on {robot.name}"
    return page(title, parts, lead=_lead(run))


def _lead(run: Run) -> str:
    seconds = run.configuration.start_epoch_ns / 1e9
    start = datetime.datetime.fromtimestamp(seconds, tz=datetime.UTC)
    what = "A simulated run" if run.configuration.simulated else "A run"
    return f"{what} of {start:%Y-%m-%d %H:%M:%S} UTC, recorded by deltactl."


def _warnings(run: Run, tracking: RunTracking) -> list[str]:
    found = [paragraph(f"The recording is {text}.", "warn") for text in run.damage]
    if not run.complete and not run.damage:
        found.append(paragraph("The recording has no end: it was cut off.", "warn"))
    if not tracking.windows_ns:
        found.append(paragraph("The path was never begun, so there are no errors.", "warn"))
    elif not tracking.whole:
        found.append(paragraph(f"{ENDED_EARLY.format(tracking.on_path_s)}.", "warn"))
    return found


def _facts(run: Run, robot: RobotFile, tracking: RunTracking) -> Iterable[tuple[str, str]]:
    configuration = run.configuration
    periods_s = sorted({period for period in run.settings.t_pwm_s.tolist() if period == period})
    yield "robot", robot.name
    yield "job", configuration.job_name
    if periods_s:
        yield "T_PWM", ", ".join(f"{period:g} s" for period in periods_s)
    yield "recorded", f"{run.end_ns / 1e9:.2f} s"
    yield "on the path", f"{tracking.on_path_s:.2f} s"
    yield "targets", f"{int(arrivals(run).sum())}"
    sent = "set-points passed" if len(run.servo.t_ns) else "step edges sent"
    yield sent, f"{int((run.edges.steps != 0).any(axis=1).sum())}"
    for name, value in configuration.settings.items():
        yield name.replace("_", " "), _readable(value)
    yield "recording", str(run.path)
    yield "version", configuration.version


def _errors(tracking: RunTracking) -> str:
    rows = []
    for seen in tracking.all():
        rows.append((seen.name, "RMS", *(_mm(value_m) for value_m in seen.rms_m)))
        rows.append(("", "max", *(_mm(value_m) for value_m in seen.max_m)))
    head = ("target against", "", *(f"e_{axis}" for axis in AXES))
    caption = "Tracking errors on the path [mm]"
    notes = [
        paragraph(f"{seen.name}: {ABOUT[seen.name]}; {_samples(seen)}.", "note")
        for seen in tracking.all()
    ]
    return table(head, rows, numbers_from=2, caption=caption) + "".join(notes)


def _samples(tracking: Tracking) -> str:
    fewest, most = min(tracking.samples), max(tracking.samples)
    return count(most, "sample") if fewest == most else f"{fewest} to {most} samples an axis"


def _curves(run: Run, robot: RobotFile, tracking: RunTracking) -> list[str]:
    parts = [heading("Path"), paragraph(HINT, "note howto")]
    parts.append(columns(chart.html() for chart in sections.path_charts(run, robot, tracking)))
    if tracking.truth or tracking.measured:
        parts.append(heading("Errors"))
        parts += [chart.html() for chart in sections.error_charts(run, tracking)]
    parts += [heading("Motors"), sections.sent_chart(run, robot).html()]
    return parts


def _sensors(run: Run) -> list[str]:
    if not any(len(samples.t_ns) for samples in run.readings.values()):
        return [heading("Sensors"), paragraph("No readings were recorded.", "warn")]
    head = (
        "sensor",
        "samples",
        "rate [Hz]",
        "good",
        "held back by",
        "stale",
        "longest silence [s]",
        "signal [Mcps]",
        "sigma [mm]",
    )
    rows = [
        (
            f"range {health.axis}",
            f"{health.samples}",
            _number(health.rate_hz, 1),
            _number(100.0 * health.good_share, 2, " %"),
            ", ".join(f"{gate} {n}" for gate, n in health.gated.items()) or "\u2013",
            f"{health.stale}",
            _number(health.longest_silence_s, 3),
            _number(health.signal_mcps, 2),
            _mm(health.sigma_m),
        )
        for health in sensor_health(run)
    ]
    return [
        heading("Sensors"),
        table(head, rows),
        health_strip(run, sections.TIME_GROUP).html(),
        sections.signal_chart(run).html(),
    ]


def _events(run: Run) -> list[str]:
    shown = run.events[:MAXIMUM_EVENTS]
    rows = [(f"{event.t_ns / 1e9:.3f}", event.kind, event.text) for event in shown]
    parts = [heading("Events"), table(("run time [s]", "what", ""), rows, numbers_from=9)]
    if len(run.events) > len(shown):
        parts.append(paragraph(f"{len(run.events) - len(shown)} more are in the recording."))
    return parts


def _files(run: Run) -> list[str]:
    return [
        heading("Files"),
        folded("Robot file", _legible(run.configuration.robot_text)),
        folded("Job file", run.configuration.job_text),
    ]


def _readable(value: object) -> str:
    """A setting as words: nested ones as 'name value'."""
    if isinstance(value, dict):
        return ", ".join(f"{name} {_readable(inner)}" for name, inner in value.items())
    return str(value)


def _legible(text: str) -> str:
    """A file that is one long line of JSON, set in lines."""
    try:
        return json.dumps(json.loads(text), indent=2)
    except ValueError:
        return text


def _mm(value_m: float) -> str:
    return _number(value_m * 1e3, 3)


def _number(value: float, decimals: int, unit: str = "") -> str:
    return f"{value:.{decimals}f}{unit}" if math.isfinite(value) else "\u2013"
