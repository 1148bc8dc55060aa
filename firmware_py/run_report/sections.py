"""Sections of a run's report: path and errors (Zhao 2023, Figures 7-15), sensors, servo drives."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import Any

import numpy as np

from deltactl.charts.figures import HeatStrip, LineChart
from deltactl.charts.page import heading, paragraph, table
from deltactl.charts.spec import Colour, Mark, Series, Span, Style
from deltactl.firmware_py.robot_file import RobotFile
from deltactl.firmware_py.run_report.reference import seconds
from deltactl.firmware_py.run_report.tracking import RunTracking, Tracking, positions_of_counts
from deltactl.models.robot import AXES, FloatArray
from deltactl.recording.reading.run import Readings, Run
from deltactl.recording.tables.rounds import gather

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
"""Those that every run has; they are in the table of events only."""


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
            series=[_error_series(seen, column) for seen in shown],
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
    """Signal rate of each distance sensor; weak signals come before wrong distances."""
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


STATES: tuple[tuple[str, Colour], ...] = (
    ("good", Colour.GOOD),
    ("sigma", Colour.QUIET),
    ("signal", Colour.SECOND),
    ("jump", Colour.COMMANDED),
    ("status", Colour.BAD),
    ("nothing new", Colour.ASKED),
)
"""Gates of drivers.ranging.contract, and a round without a sample; the best first."""
NOTHING_NEW = len(STATES) - 1


@dataclass(frozen=True, slots=True)
class SensorHealth:
    """One sensor over a whole run; NaN where there is nothing to take it from."""

    axis: str
    samples: int
    rate_hz: float
    good_share: float
    gated: dict[str, int]
    """How many samples each gate held back."""
    stale: int
    longest_silence_s: float
    signal_mcps: float
    sigma_m: float


def sensor_health(run: Run) -> list[SensorHealth]:
    """Health of the three sensors."""
    return [_health_of(run.readings[axis]) for axis in AXES]


def health_strip(run: Run, group: str) -> HeatStrip:
    """Every round of every sensor, coloured by what became of it. Raises RecordingError."""
    rounds = gather(run)
    names = [name for name, _ in STATES]
    rows = []
    for samples, chosen in zip(rounds.sensors, rounds.chosen.T, strict=True):
        # A gate this program does not know is shown as the worst there is, not as good.
        state = [names.index(g) if g in names else NOTHING_NEW - 1 for g in samples.gate]
        rows.append(np.array([*state, NOTHING_NEW])[chosen])  # -1 picks the one appended
    states = np.array(rows)
    occurring = np.unique(np.append(states, 0))
    return HeatStrip(
        "Readings",
        "run time [s]",
        rounds.t_s,
        [f"range {axis}" for axis in AXES],
        np.searchsorted(occurring, states),
        states=[STATES[state] for state in occurring],
        group=group,
    )


def _health_of(samples: Readings) -> SensorHealth:
    gaps_s = np.diff(samples.t_ns) * _NS
    gates, counts = np.unique(samples.gate, return_counts=True)
    gated = {str(gate): int(n) for gate, n in zip(gates, counts, strict=True) if gate != "good"}
    return SensorHealth(
        axis=samples.axis,
        samples=len(samples.t_ns),
        rate_hz=1.0 / _or_nan(np.median, gaps_s),
        good_share=_or_nan(np.mean, samples.good.astype(np.float64)),
        gated=gated,
        stale=int(samples.stale.sum()),
        longest_silence_s=_or_nan(np.max, gaps_s),
        signal_mcps=_or_nan(np.median, samples.signal_mcps[np.isfinite(samples.signal_mcps)]),
        sigma_m=_or_nan(np.median, samples.sigma_m[np.isfinite(samples.sigma_m)]),
    )


def _or_nan(measure: Any, values: Any) -> float:
    return float(measure(values)) if len(values) else float("nan")


@dataclass(frozen=True, slots=True)
class Following:
    """How the arms followed their references on the path; every array has shape (3,)."""

    swing_rad: FloatArray
    """Peak to peak of the reference."""
    max_rad: FloatArray
    rms_rad: FloatArray
    current_rms_a: FloatArray
    current_max_a: FloatArray

    @property
    def max_percent(self) -> FloatArray:
        """Largest error in per cent of peak to peak, as Uzunovic 2013 section 5 gives it."""
        with np.errstate(divide="ignore", invalid="ignore"):
            percent: FloatArray = 100.0 * self.max_rad / self.swing_rad
        return percent


def following(run: Run, windows_ns: tuple[tuple[int, int], ...]) -> Following | None:
    """Figures over the time on the path; None when there is nothing to look at."""
    servo = run.servo
    inside = np.zeros(len(servo.t_ns), dtype=np.bool_)
    for start_ns, end_ns in windows_ns:
        inside |= (servo.t_ns >= start_ns) & (servo.t_ns <= end_ns)
    if not inside.any():
        return None
    reference, current = servo.reference_rad[inside], servo.current_a[inside]
    error = servo.angle_rad[inside] - reference
    return Following(
        swing_rad=np.ptp(reference, axis=0),
        max_rad=np.abs(error).max(axis=0),
        rms_rad=np.sqrt((error**2).mean(axis=0)),
        current_rms_a=np.sqrt((current**2).mean(axis=0)),
        current_max_a=np.abs(current).max(axis=0),
    )


def servo_section(run: Run, windows_ns: tuple[tuple[int, int], ...]) -> list[str]:
    """Table and curves; nothing for a stepper's run."""
    if not len(run.servo.t_ns):
        return []
    parts = [heading("Servo drives")]
    found = following(run, windows_ns)
    if found is not None:
        parts.append(_table(found))
        parts.append(paragraph("Errors are encoder angle minus reference, on the path.", "note"))
    return [*parts, *(chart.html() for chart in _charts(run))]


def _table(found: Following) -> str:
    head = (
        *("arm", "reference peak to peak [deg]", "largest error [deg]", "[% of peak to peak]"),
        *("error RMS [deg]", "current RMS [A]", "largest current [A]"),
    )
    rows = [
        (
            f"{arm + 1}",
            f"{np.rad2deg(found.swing_rad[arm]):.2f}",
            f"{np.rad2deg(found.max_rad[arm]):.3f}",
            f"{found.max_percent[arm]:.2f}",
            f"{np.rad2deg(found.rms_rad[arm]):.4f}",
            f"{found.current_rms_a[arm]:.3f}",
            f"{found.current_max_a[arm]:.3f}",
        )
        for arm in range(3)
    ]
    return table(head, rows)


def _charts(run: Run) -> list[LineChart]:
    servo, t_s = run.servo, seconds(run.servo.t_ns)
    error_deg = np.rad2deg(servo.angle_rad - servo.reference_rad)
    note = (
        "The part of each current that the acceleration of the nominal inertia does not explain:"
        " gravity, friction, the other arms, and differences from the robot file."
    )
    return [
        arms_chart("Following error", "encoder minus reference [deg]", t_s, error_deg),
        arms_chart("Motor currents", "current [A]", t_s, servo.current_a),
        arms_chart("Disturbance estimates", "current [A]", t_s, servo.disturbance_a, note),
    ]
