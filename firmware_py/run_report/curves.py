"""The charts of a run: the path, the errors over time, what was sent (Zhao 2023, Figures 7-15)."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from deltactl.charts.figures import LineChart
from deltactl.charts.spec import Colour, Mark, Series, Span, Style
from deltactl.firmware_py.robot_file import RobotFile
from deltactl.firmware_py.run_report.reference import seconds
from deltactl.firmware_py.run_report.tracking import RunTracking, Tracking, positions_of_counts
from deltactl.models.robot import AXES, FloatArray
from deltactl.recording.reading.run import Run

_NS = 1e-9
_MM = 1e3
COLOURS = (Colour.FIRST, Colour.SECOND, Colour.THIRD)
TIME_GROUP = "time"
"""Charts over run time zoom together."""
SENT_POINTS = 20_000

LOOKS: dict[str, tuple[Colour, Style]] = {
    "simulated truth": (Colour.TRUE, Style.LINE),
    "measured": (Colour.MEASURED, Style.POINTS),
    "commanded": (Colour.COMMANDED, Style.LINE),
}
QUIET_EVENTS = frozenset({"approach", "state", "home"})
"""Those that every run has; they stand in the table of events only."""


def path_charts(run: Run, robot: RobotFile, tracking: RunTracking) -> list[LineChart]:
    """The path from above (Figures 7 to 9) and from the side."""
    return [
        _plane("The path from above", run, robot, tracking, 0, 1),
        _plane("The path from the side", run, robot, tracking, 0, 2),
    ]


def error_charts(run: Run, tracking: RunTracking) -> list[LineChart]:
    """Errors along x, y and z over time (Figures 10 to 15)."""
    shown = [seen for seen in (tracking.measured, tracking.truth) if seen is not None]
    return [
        LineChart(
            title=f"Error along {axis}",
            x_label="run time [s]",
            y_label=f"e_{axis} [mm]",
            series=[_error_series(one, column) for one in shown],
            spans=_spans(tracking),
            marks=_marks(run),
            group=TIME_GROUP,
        )
        for column, axis in enumerate(AXES)
    ]


def sent_chart(run: Run, robot: RobotFile) -> LineChart:
    """Arm angles from the counts that really went out."""
    t_s, counts = sent_counts(run, 0, run.end_ns)
    angles_deg = np.rad2deg(counts * robot.drive.rad_per_step)
    said = "Counts of the edges (of a servo: set-points) that went out, as the robot file"
    chart = arms_chart("Arm angles sent", "angle [deg], positive = down", t_s, angles_deg)
    return replace(chart, marks=_marks(run), note=f"{said} turns them into angles.")


def arms_chart(
    title: str, y_label: str, t_s: FloatArray, values: FloatArray, note: str = ""
) -> LineChart:
    """Something of all three arms, (n, 3), over run time."""
    series = [
        Series(f"arm {arm + 1}", t_s, values[:, arm], colour) for arm, colour in enumerate(COLOURS)
    ]
    return LineChart(title, "run time [s]", y_label, series, group=TIME_GROUP, note=note)


def signal_chart(run: Run) -> LineChart:
    """Signal rate of each ranging sensor; weak signals come before wrong distances."""
    series = [
        Series(f"range {axis}", seconds(samples.t_ns), samples.signal_mcps, colour, Style.POINTS)
        for (axis, samples), colour in zip(run.readings.items(), COLOURS, strict=True)
    ]
    return LineChart(
        "Signal of the sensors",
        "run time [s]",
        "signal [million counts/s]",
        series,
        group=TIME_GROUP,
        height_px=200,
    )


def sent_counts(run: Run, start_ns: int, end_ns: int) -> tuple[FloatArray, FloatArray]:
    """Counts sent, on an even grid of times: (n,) in s, (n, 3)."""
    points = int(min(SENT_POINTS, max(2, (end_ns - start_ns) // 10_000_000 + 1)))
    t_ns = np.linspace(start_ns, end_ns, points).astype(np.int64)
    return seconds(t_ns), run.edges.counts_at(t_ns).astype(np.float64)


def _plane(
    title: str, run: Run, robot: RobotFile, tracking: RunTracking, across: int, up: int
) -> LineChart:
    series = []
    if tracking.measured is not None:
        series.append(_path_series(tracking.measured, across, up))
    if tracking.windows_ns:
        start_ns, end_ns = tracking.windows_ns[0][0], tracking.windows_ns[-1][1]
        _, counts = sent_counts(run, start_ns, end_ns)
        sent_m = positions_of_counts(robot, counts)
        series.append(_curve("commanded", sent_m[:, across], sent_m[:, up], hidden=True))
    if tracking.truth is not None:
        series.append(_path_series(tracking.truth, across, up))
    target_m = run.targets.position_m
    asked = Series(
        "target", target_m[:, across] * _MM, target_m[:, up] * _MM, Colour.ASKED, dashed=True
    )
    return LineChart(
        title,
        f"{AXES[across]} [mm]",
        f"{AXES[up]} [mm]",
        [*series, asked],
        equal_aspect=True,
    )


def _path_series(tracking: Tracking, across: int, up: int) -> Series:
    position_m = tracking.position_m
    return _curve(tracking.name, position_m[:, across], position_m[:, up])


def _curve(name: str, x_m: FloatArray, y_m: FloatArray, hidden: bool = False) -> Series:
    colour, style = LOOKS[name]
    return Series(name, x_m * _MM, y_m * _MM, colour, style, hidden=hidden)


def _error_series(tracking: Tracking, column: int) -> Series:
    colour, style = LOOKS[tracking.name]
    return Series(tracking.name, tracking.t_s, tracking.error_m[:, column] * _MM, colour, style)


def _spans(tracking: RunTracking) -> Sequence[Span]:
    return [Span(start * _NS, end * _NS, "on the path") for start, end in tracking.windows_ns]


def _marks(run: Run) -> Sequence[Mark]:
    return [
        Mark(event.t_ns * _NS, event.kind.replace("_", " "))
        for event in run.events
        if event.kind not in QUIET_EVENTS
    ]
