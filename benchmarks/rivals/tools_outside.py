"""Single axes by lmfit, by PySINDy, and by a textbook's inverse dynamic model; deltas elsewhere.

    python -m benchmarks.rivals.tools_outside TOOL FOLDER OUT [SECONDS]

Runs in an environment of its own and imports nothing of deltactl. Each folder in FOLDER holds
`recording.csv.gz`, `robot.json` and perhaps `holdout.csv.gz`; OUT gets one answer a folder, as
JSON.

Protocol. Each tool gets the columns in SI units and the values of the robot file. What may be wrong
is the list below, written once and the same for every axis; no tool knows which entries are open.

lmfit (1.3): every set of up to three entries is fitted by `leastsq`; the least BIC is the answer.

- commanded axis: `home_offset` (an axis of arbitrary zero has a free constant in every set, without
  a name), `gear_ratio` (0.5 to 2), `gear_backlash` (play, 0 to half of the stroke), `following_lag`
  (time constant and dead time, each 0 to 2 s or a tenth of the recording). Left out: waves, lost
  steps, compliance, resonance, limits of speed.
- range sensor: `sensor_scale` (0.5 to 2), `sensor_offset`, `sensor_latency` (0 to 2 s).
- axis with effort: `joint_friction` and `viscous_friction` (at least 0), `effort_offset`,
  `inertia` (a fifth to five times the file's), `effort_gain` (0.2 to 5), `following_lag` (0 to
  0.5 s). Left out: Stribeck friction, limits of effort.

Fits start at the healthy value, lags and widths at 1 % of their largest. Rows further than six
robust deviations from the fit with all entries are dropped. BIC counts rows by the lag-one
correlation r that this fit leaves, N (1 - r) / (1 + r), and intervals (1.96 standard errors of the
covariance) are widened by the same. An entry of the best set is a name, except a
lag under a quarter of the rows' period: the generator steps forces ahead of motion by half a step
of its simulation, which the fit finds on healthy axes.

PySINDy (2.1): SINDy with STLSQ on what the healthy axis leaves; library 1, x, v, a, sign v in units
of their root mean squares. The threshold is the largest of twelve whose error on the last third of
the rows is within 2 % of the least. An active term is a name, unless its sign is one that the
effect cannot have; there are no intervals. Commanded: constant, ratio, lag, resonance, backlash;
with effort: offset, unknown, viscous friction, inertia, friction.

textbook: ordinary least squares of the force that the file does not explain on a, sign v, v, 1.
A term of |t| > 4 is a name (friction only above zero); intervals are 1.96 standard errors. It
takes axes with effort only.
"""

from __future__ import annotations

import itertools
import json
import sys
import time
import warnings
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from functools import partial
from pathlib import Path
from typing import Any

import numpy as np

from benchmarks.rivals import arm_tools, delta_tools
from benchmarks.rivals.axis_signals import (
    NOT_TAKEN,
    SLOW,
    WILD,
    Array,
    Json,
    Signals,
    axis_model,
    finding_of,
    signals,
    size_of,
)
from benchmarks.rivals.each_case import each_case

MOST_NAMES = 3
SURE_T = 4.0
LEAST_LAG_PERIODS = 0.25
COMMANDED_TERMS = ("home_offset", "gear_ratio", "following_lag", "resonance", "gear_backlash")
SENSOR_TERMS = ("sensor_offset", "sensor_scale", "sensor_latency", "unknown", "unknown")
LAGS = ("following_lag", "sensor_latency")
FORCED_TERMS = ("effort_offset", "unknown", "viscous_friction", "inertia", "joint_friction")
THRESHOLDS = np.geomspace(0.003, 3.0, 12)


Open = tuple[str, float, float, float]
"""Name of a value, where it starts, its least and largest."""


def candidates(given: Signals) -> dict[str, list[Open]]:
    """The written list: entry -> its values."""
    if "inertia" in given.sets:
        own, force = float(given.sets["inertia"]), 0.1 * float(np.std(given.y)) + 1e-12
        speed = float(np.quantile(np.abs(given.v), 0.98))
        return {
            "joint_friction": [("torque", force, 0.0, np.inf)],
            "viscous_friction": [("coefficient", force / speed, 0.0, np.inf)],
            "effort_offset": [("offset", 0.0, -np.inf, np.inf)],
            "inertia": [("inertia", own, 0.2 * own, 5.0 * own)],
            "effort_gain": [("scale", 1.0, 0.2, 5.0)],
            "following_lag": [("total", 0.005, 0.0, 0.5)],
        }
    if given.sets.get("sensor"):
        return {
            "sensor_scale": [("scale", 1.0, 0.5, 2.0)],
            "sensor_offset": [("offset", 0.0, -np.inf, np.inf)],
            "sensor_latency": [("dead_time", 0.01, 0.0, 2.0)],
        }
    stroke, late_s = float(np.ptp(given.x)), min(2.0, 0.1 * given.step_s * len(given.x))
    found: dict[str, list[Open]] = {
        "gear_ratio": [("scale", 1.0, 0.5, 2.0)],
        "gear_backlash": [("width", 0.005 * stroke, 0.0, 0.5 * stroke)],
        "following_lag": [
            ("time", 0.01 * late_s, 0.0, late_s),
            ("dead_time", 0.01 * late_s, 0.0, late_s),
        ],
    }
    if given.sets["zero"] == "absolute":
        found["home_offset"] = [("angle", 0.0, -np.inf, np.inf)]
    return found


@dataclass(frozen=True)
class Fit:
    """A set of entries, fitted, and what it leaves."""

    names: Sequence[str]
    parameters: Any
    left: Array

    def bic(self, rows: float) -> float:
        """For so many independent rows."""
        return float(rows * np.log(np.mean(self.left**2)) + len(self.parameters) * np.log(rows))

    def sizes(self, values: Sequence[str], rows: float) -> Json:
        """Values with their intervals."""
        widen = 1.96 * float(np.sqrt(len(self.left) / rows))
        found = {}
        for value in values:
            one = self.parameters[value]
            error = None if one.stderr is None else widen * one.stderr
            found[value] = size_of(one.value, error)
        return found


def by_lmfit(given: Signals) -> tuple[list[Json], Callable[[Signals], Array]]:
    """Findings, and a prediction of another recording."""
    import lmfit

    entries = candidates(given)
    nameless = [] if given.sets.get("zero", "absolute") == "absolute" else ["angle"]
    kept = given.kept.copy()

    def fit(names: Sequence[str]) -> Fit:
        parameters = lmfit.Parameters()
        for free in nameless:
            parameters.add(free, value=float(np.median(given.rest())))
        for name in names:
            for value, start, low, high in entries[name]:
                parameters.add(value, value=start, min=low, max=high)

        def miss(p: Any) -> Array:
            off = (given.y - axis_model(given, p.valuesdict()))[kept]
            return np.asarray(off, dtype=np.float64)

        if not len(parameters):
            return Fit(names, parameters, miss(parameters))
        found = lmfit.minimize(miss, parameters, max_nfev=400).params
        return Fit(names, found, miss(found))

    off = np.zeros(len(given.y))
    off[kept] = fit(list(entries)).left
    middle = np.median(off[kept])
    kept &= np.abs(off - middle) < WILD * 1.4826 * np.median(np.abs(off[kept] - middle)) + 1e-15
    rest = off[kept] - off[kept].mean()
    r = float(np.clip((rest[1:] @ rest[:-1]) / (rest @ rest), 0.0, 0.99))
    rows = len(rest) * (1.0 - r) / (1.0 + r)
    sets = (itertools.combinations(entries, count) for count in range(MOST_NAMES + 1))
    best = min(map(fit, itertools.chain.from_iterable(sets)), key=lambda one: one.bic(rows))
    findings, values = [], best.parameters.valuesdict()
    for name in best.names:
        own = [value for value, *_ in entries[name]]
        late_s = sum(values[value] for value in own)
        if name not in LAGS or late_s > LEAST_LAG_PERIODS * given.step_s:
            findings.append(finding_of(name, best.sizes(own, rows)))
    return findings, lambda other: axis_model(other, values)


def library(given: Signals) -> Array:
    """Columns x, v, a, sign v (n, 4); speeds below a fiftieth of the usual have no sign."""
    fast = np.abs(given.v) > SLOW * np.quantile(np.abs(given.v), 0.98)
    return np.column_stack([given.x, given.v, given.a, np.sign(given.v) * fast])


def by_pysindy(given: Signals) -> tuple[list[Json], Callable[[Signals], Array]]:
    """Findings without intervals, and a prediction of another recording."""
    import pysindy

    columns, rest = library(given)[given.kept], given.rest()
    units = np.sqrt(np.mean(columns**2, axis=0)) + 1e-300
    unit = float(np.sqrt(np.mean(rest**2))) + 1e-300
    columns, rest = columns / units, rest / unit
    learnt = 2 * len(rest) // 3

    def fit(threshold: float, rows: slice) -> Array:
        model = pysindy.SINDy(
            optimizer=pysindy.STLSQ(threshold=threshold, alpha=1e-9),
            feature_library=pysindy.PolynomialLibrary(degree=1),
        )
        model.fit(columns[rows], t=given.step_s, x_dot=rest[rows, None])
        terms: Array = np.asarray(model.coefficients(), dtype=np.float64)[0]
        return terms

    def miss(threshold: float) -> float:
        terms = fit(threshold, slice(0, learnt))
        return float(np.mean((rest - terms[0] - columns @ terms[1:])[learnt:] ** 2))

    misses = np.array([miss(float(threshold)) for threshold in THRESHOLDS])
    chosen = THRESHOLDS[np.flatnonzero(misses <= 1.02**2 * misses.min())[-1]]
    terms = fit(float(chosen), slice(None)) * unit / np.concatenate([[1.0], units])
    return _terms(given, terms), lambda other: other.known + terms[0] + library(other) @ terms[1:]


def _terms(given: Signals, terms: Array) -> list[Json]:
    """Names of the active terms 1, x, v, a, sign v, of a sign that the effect can have."""
    forced = "inertia" in given.sets
    # A late axis is behind its speed and its direction; friction adds to the force.
    cannot = (terms < 0.0) if forced else (terms > 0.0)
    named = (terms != 0.0) & ~(cannot & np.array([False, False, True, False, True]))
    named[0] &= forced or given.sets["zero"] == "absolute"
    names = FORCED_TERMS if forced else COMMANDED_TERMS
    if given.sets.get("sensor"):
        names = SENSOR_TERMS
    return [finding_of(name, {}) for name, own in zip(names, named, strict=True) if own]


def by_textbook(given: Signals) -> tuple[list[Json], Callable[[Signals], Array]]:
    """Findings, and a prediction of another recording."""

    both_ways = np.ptp(np.sign(given.v[given.kept])) > 0.0

    def table(of: Signals) -> Array:
        # In a motion one way dry friction is an offset.
        way = np.sign(of.v) if both_ways else np.zeros_like(of.v)
        return np.column_stack([of.a, way, of.v, np.ones_like(of.v)])

    columns, rest = table(given)[given.kept], given.rest()
    units = np.sqrt(np.mean(columns**2, axis=0))
    units[units == 0.0] = 1.0
    inverse = np.linalg.pinv(columns / units) / units[:, None]
    terms = inverse @ rest
    free = len(rest) - len(terms)
    # As many terms as readings fit anything, and show no error.
    variance = float(np.sum((rest - columns @ terms) ** 2)) / free if free > 0 else np.inf
    errors = np.sqrt(variance * np.sum(inverse**2, axis=1))
    names = {
        "inertia": "inertia",
        "joint_friction": "torque",
        "viscous_friction": "coefficient",
        "effort_offset": "offset",
    }
    findings = []
    for (effect, value), term, error in zip(names.items(), terms, errors, strict=True):
        if (abs(term) if value in ("inertia", "offset") else term) > SURE_T * error:
            healthy = given.sets["inertia"] if effect == "inertia" else 0.0
            findings.append(finding_of(effect, {value: size_of(healthy + term, 1.96 * error)}))
    return findings, lambda other: other.known + table(other) @ terms


TOOLS = {"lmfit": by_lmfit, "PySINDy": by_pysindy, "textbook": by_textbook}
LIBRARIES = {
    "lmfit": ["lmfit"],
    "PySINDy": ["pysindy"],
    "FIGAROH": ["figaroh.identification.base_identification"],
    "sysid, true set": ["mujoco.sysid"],
    "sysid, all": ["mujoco.sysid"],
}
"""What a tool loads before the first case."""


def answer(tool: str, folder: Path) -> Json:
    """Findings in the form of the diagnosis, with seconds and held-out error, of one case."""
    robot = json.loads((folder / "robot.json").read_text(encoding="utf-8"))
    if "forearm_m" in robot:
        return delta_tools.answer(tool, folder, robot)
    if "joints" in robot:
        return arm_tools.answer(tool, folder, robot)
    if tool == "textbook" and "inertia" not in robot:
        return NOT_TAKEN
    begun = time.process_time()
    try:
        given = signals(folder / "recording.csv.gz", robot)
        if tool not in TOOLS:
            return _by_sysid(tool, given, folder, begun)
        findings, predict = TOOLS[tool](given)
        seconds = time.process_time() - begun
        apart = folder / "holdout.csv.gz"
        other = signals(apart, robot) if apart.exists() else None
    except (ValueError, TypeError, np.linalg.LinAlgError) as error:
        return NOT_TAKEN | {"failure": str(error), "seconds": time.process_time() - begun}
    heldout = None
    if other is not None:
        left = (other.y - predict(other))[other.kept]
        heldout = float(np.sqrt(np.mean(left**2)))
    return {"findings": findings, "failure": None, "seconds": seconds, "heldout": heldout}


def _by_sysid(tool: str, given: Signals, folder: Path, begun: float) -> Json:
    from benchmarks.rivals.inverse_sysid import by_sysid_of_axes

    found = by_sysid_of_axes(tool, given, folder)
    seconds = time.process_time() - begun if found is not None else None
    return NOT_TAKEN | {"findings": found, "seconds": seconds}


def main(tool: str, folder: str, out: str, most_s: str = "inf") -> None:
    """Answer every axis in a folder."""
    warnings.simplefilter("ignore")
    libraries = LIBRARIES.get(tool, ())
    own = partial(answer, tool)
    answers, peak_mb = each_case(own, Path(folder), libraries, float(most_s))
    written = {"answers": answers, "peak_mb": peak_mb}
    Path(out).write_text(json.dumps(written), encoding="utf-8")


if __name__ == "__main__":
    main(*sys.argv[1:])
