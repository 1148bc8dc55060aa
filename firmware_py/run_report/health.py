"""How the ranging sensors did during a run."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np

from deltactl.charts.figures import HeatStrip
from deltactl.charts.spec import Colour
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
