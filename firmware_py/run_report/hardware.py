"""How the ranging sensors did during a run, and the servo drives: how closely the arms followed."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np

from deltactl.charts.figures import HeatStrip, LineChart
from deltactl.charts.page import heading, paragraph, table
from deltactl.charts.spec import Colour
from deltactl.firmware_py.run_report.curves import arms_chart
from deltactl.firmware_py.run_report.reference import seconds
from deltactl.models.robot import FloatArray
from deltactl.recording.reading.run import Readings, Run
from deltactl.recording.tables.rounds import AXES, gather

_NS = 1e-9

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
        "Of each current what the nominal inertia's acceleration does not explain:"
        " gravity, friction, the other arms, and what is not as the robot file says."
    )
    return [
        arms_chart("Following error", "encoder minus reference [deg]", t_s, error_deg),
        arms_chart("Motor currents", "current [A]", t_s, servo.current_a),
        arms_chart("Disturbance estimates", "current [A]", t_s, servo.disturbance_a, note),
    ]
