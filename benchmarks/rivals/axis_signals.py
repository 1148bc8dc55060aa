"""One recording of a single axis as columns on an even grid, and what an axis would read.

Imports nothing of deltactl: it runs where the other tools are.
"""

from __future__ import annotations

import gzip
from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray
from scipy.interpolate import CubicSpline
from scipy.signal import butter, lfilter, medfilt, sosfiltfilt

Array = NDArray[np.float64]
FOLLOWED, READINGS = ("command", "steps", "distance"), ("position", "theta", "range")
"""Beginnings of the names of columns: what an axis or a sensor follows, and what is read."""
Json = dict[str, Any]
NOT_TAKEN: Json = {"findings": None, "failure": None, "seconds": None, "heldout": None}
"""The answer of a tool to a case that it does not take."""
WILD = 6.0
"""Robust deviations from which on a row is an outlier."""
SLOW = 0.02
"""Share of the usual speed below which a direction says nothing."""


@dataclass(frozen=True)
class Signals:
    """One recording on an even grid, as the tools use it; all (n,).

    y: what is explained, a reading or a force; x, v, a: motion that explains it (of a commanded
    axis that of the command); known: what the robot file alone makes of it; kept: rows to use.
    """

    step_s: float
    y: Array
    x: Array
    v: Array
    a: Array
    known: Array
    kept: NDArray[np.bool_]
    sets: Mapping[str, Any]

    def rest(self) -> Array:
        """What the healthy axis leaves, at the rows to use."""
        return (self.y - self.known)[self.kept]


def finding_of(effect: str, sizes: Json, component: str | None = None) -> Json:
    """In the form of the diagnosis; a single axis has one component, which is not named."""
    place = {} if component is None else {"component": component}
    known: Json = {"alternatives": [], "probability": None, "parameters": sizes}
    return {"effect": effect} | place | known


def size_of(value: float, half: float | None) -> Json:
    """A fit that ended at a bound has no covariance, and its size is then not stated."""
    if half is None or not np.isfinite(half):
        return {"value": None, "ci95": [None, None]}
    return {"value": float(value), "ci95": [float(value - half), float(value + half)]}


def read(file: Path) -> dict[str, Array]:
    """Columns of a table, rows without a number left out."""
    with gzip.open(file, "rt", encoding="utf-8") as text:
        names = text.readline().strip().split(",")
        rows = np.genfromtxt(text, delimiter=",", ndmin=2)
    rows = rows[np.isfinite(rows).all(axis=1)]
    return dict(zip(names, rows.T, strict=True))


def signals(file: Path, robot: Json) -> Signals:
    """A recording as its kind of axis needs it."""
    columns = read(file)
    return _forced(columns, robot) if "inertia" in robot else _commanded(columns, robot)


def _grid(columns: dict[str, Array]) -> tuple[Array, float, NDArray[np.bool_]]:
    """An even grid, its step, and which of its points lie between two rows that are no gap."""
    stamps_s = columns["t"]
    apart_s = np.diff(stamps_s)
    step_s = float(np.median(apart_s))
    even_s = np.arange(stamps_s[0], stamps_s[-1], step_s)
    after = np.clip(np.searchsorted(stamps_s, even_s), 1, len(stamps_s) - 1)
    # A log that often leaves a row out has no gap there.
    gap_s = max(2.5 * step_s, 1.5 * float(np.quantile(apart_s, 0.99)))
    near = stamps_s[after] - stamps_s[after - 1] < gap_s
    piece = columns.get("segment", np.zeros_like(stamps_s))
    near &= piece[after] == piece[after - 1]
    near[: min(20, len(near) // 20)] = False
    return even_s, step_s, near


def rate(signal: Array, step_s: float) -> Array:
    """Derivative (n,) by a cubic spline, which keeps fast motion that differences would weaken."""
    spline = CubicSpline(step_s * np.arange(len(signal)), signal)
    return np.asarray(spline(step_s * np.arange(len(signal)), 1), dtype=np.float64)


def without_spikes(column: Array) -> Array:
    """Rows far from the median of five neighbours replaced by it."""
    middle = medfilt(column, 5)
    off = np.abs(column - middle)
    wild = off > WILD * 1.4826 * np.median(off[2:-2]) + 1e-15
    wild[:2], wild[-2:] = False, False
    return np.where(wild, middle, column)


def _commanded(columns: dict[str, Array], robot: Json) -> Signals:
    even_s, step_s, kept = _grid(columns)
    command = next(name for name in columns if name.startswith(FOLLOWED))
    reading = next(name for name in columns if name.startswith(READINGS))
    x = np.interp(even_s, columns["t"], columns[command] * robot.get("step", 1.0))
    y = np.interp(even_s, columns["t"], columns[reading])
    v = rate(x, step_s)
    return Signals(step_s, y, x, v, rate(v, step_s), x, kept, robot)


def _forced(columns: dict[str, Array], robot: Json) -> Signals:
    """Derivatives and force through the same low-pass, and as many rows as it leaves apart."""
    even_s, step_s, near = _grid(columns)
    columns = columns | {name: without_spikes(columns[name]) for name in ("position", "effort")}
    even = {name: np.interp(even_s, columns["t"], column) for name, column in columns.items()}
    cut_hz = _cut_hz(even["position"], step_s)
    sections = butter(4, min(2.0 * cut_hz * step_s, 0.9), output="sos")

    def smooth(signal: Array) -> Array:
        passed: Array = sosfiltfilt(sections, signal)
        return passed

    x = smooth(even["position"])
    v = smooth(even["velocity"]) if "velocity" in even else rate(x, step_s)
    a = rate(v, step_s)
    pull = robot["weight"] + robot["gravity"] * np.sin(x - robot["gravity_zero"])
    pull = pull - smooth(even.get("load", np.zeros_like(x)))
    known = robot["inertia"] * a + pull
    kept = near & (np.abs(v) > SLOW * np.quantile(np.abs(v), 0.98))
    every = max(int(0.5 / cut_hz / step_s), 1)
    kept &= np.arange(len(kept)) % every == 0
    # The low-pass smears both ends and what bridges a gap.
    edge = 10 * every
    far = np.convolve(~near, np.ones(2 * edge + 1), "same") < 0.5
    far[:edge], far[-edge:] = False, False
    kept &= far
    return Signals(step_s, smooth(even["effort"]) * robot["gain"], x, v, a, known, kept, robot)


def _cut_hz(position: Array, step_s: float) -> float:
    """Where the spectrum of the position meets its noise."""
    frequencies = np.fft.rfftfreq(len(position), step_s)
    size = np.abs(np.fft.rfft((position - position.mean()) * np.hanning(len(position))))
    band = max(1, int(0.3 / frequencies[1]))
    size = np.convolve(size, np.ones(band) / band, "same")
    above = np.flatnonzero(size > 4.0 * np.median(size[len(size) // 2 :]))
    meets = frequencies[above[-1]] if len(above) else 1.0
    return float(min(max(meets, 0.5), 0.2 / step_s, 15.0))


def play(x: Array, width: float) -> Array:
    """Position behind a play of this width, begun in its middle."""
    half, at, behind = 0.5 * width, float(x[0]), []
    for place in x.tolist():
        if place - at > half:
            at = place - half
        elif at - place > half:
            at = place + half
        behind.append(at)
    return np.array(behind)


Values = Mapping[str, float]


def axis_model(given: Signals, values: Values) -> Array:
    """Reading or force (n,) of an axis with these values; what is missing is healthy."""
    if "inertia" in given.sets:
        return _force(given, values)
    x = given.x
    if values.get("dead_time", 0.0) > 0.0:
        rows = np.arange(len(x), dtype=np.float64)
        x = np.interp(rows - values["dead_time"] / given.step_s, rows, x)
    if values.get("time", 0.0) > 0.0:
        keep = float(np.exp(-given.step_s / values["time"]))
        x = lfilter([1.0 - keep], [1.0, -keep], x, zi=[keep * x[0]])[0]
    x = x * values.get("scale", 1.0)
    if values.get("width", 0.0) > 0.0:
        x = play(x, values["width"])
    return np.asarray(x + values.get("angle", values.get("offset", 0.0)), dtype=np.float64)


def _force(given: Signals, values: Values) -> Array:
    stated = given.sets["inertia"]
    force = given.known + (values.get("inertia", stated) - stated) * given.a
    force = force + values.get("torque", 0.0) * np.sign(given.v)
    force = force + values.get("coefficient", 0.0) * given.v + values.get("offset", 0.0)
    force = force + values.get("total", 0.0) * rate(force, given.step_s)
    return np.asarray(force / values.get("scale", 1.0), dtype=np.float64)


def peak_mb() -> float:
    """Most memory of this process; `getrusage` would count that of who started it too."""
    status = Path("/proc/self/status").read_text(encoding="ascii")
    line = next(line for line in status.splitlines() if line.startswith("VmHWM"))
    return float(line.split()[1]) / 1024.0
