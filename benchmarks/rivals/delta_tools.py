"""Rotary deltas by lmfit with BIC and by a printer's delta calibration; their own kinematics.

Imports nothing of deltactl. A case's `robot.json` states what the robot file does: lengths [m],
azimuths and the angle of a microstep [rad], what the three sensors read at the origin [m].

Protocol. The reading of sensor x, y or z is its offset plus that coordinate of the platform, which
hangs from three arms. Readings with an invalid status are dropped.

lmfit (1.3): the written list has 28 entries. Of each arm or motor: `home_offset`, `gear_ratio`,
`upper_arm_length`, `forearm_length`, `motor_azimuth`, `following_lag` (a time constant, 0 to 1 s),
`gear_backlash` (0 to 0.05 rad); `base_radius`; of each sensor: `sensor_offset`, `sensor_scale`; of
all sensors: `sensor_latency` (0 to 0.5 s). Every set of up to three is compared by BIC on the
model's derivatives at the healthy robot; the 12 best are fitted by `leastsq`, and the least BIC is
the answer. Rows further than six robust deviations from the fit with all entries are dropped, and
BIC and intervals count rows by the correlation that this fit leaves, as in tools_outside.py. Left
out: friction, compliance, waves, lost steps, tilt, thermal growth, contact, resonance, drift.

Klipper: its documented method, written anew: each parameter in turn is moved by its step, kept
where the sum of squared mismatches falls, and its step grown by a tenth, or else shrunk by one,
until all steps are a thousandth of their first. Parameters are those of its enhanced calibration:
radius, and of each tower the angle, end stop (`home_offset`) and arm (`forearm_length`). It names
nothing: the calibration is repeated on four quarters of the readings, and a parameter that moved by
more than Student's 95 % interval of the four counts as named.
"""

from __future__ import annotations

import itertools
import time
from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
from scipy.signal import lfilter
from scipy.stats import t as student

from benchmarks.rivals.axis_signals import (
    NOT_TAKEN,
    WILD,
    Array,
    Json,
    finding_of,
    play,
    read,
    size_of,
)

MOTORS, ARMS, RANGES = (
    tuple(f"{part}{end}" for end in ends)
    for part, ends in (("motor", "123"), ("arm", "123"), ("range_", "xyz"))
)
Values = Mapping[str, float]
"""'effect place' -> its size; what is missing is healthy."""
SHARES = ("gear_ratio", "sensor_scale")
"""Effects whose healthy size is 1."""
SIZES = {
    "home_offset": ("angle", MOTORS, 0.001, -0.5, 0.5),
    "gear_ratio": ("scale", MOTORS, 1.0005, 0.8, 1.2),
    "upper_arm_length": ("length_error", ARMS, 1e-4, -0.05, 0.05),
    "forearm_length": ("length_error", ARMS, 1e-4, -0.05, 0.05),
    "motor_azimuth": ("angle", MOTORS, 0.001, -0.5, 0.5),
    "following_lag": ("time", MOTORS, 0.01, 0.0, 1.0),
    "gear_backlash": ("width", MOTORS, 0.001, 0.0, 0.05),
    "base_radius": ("length_error", ("frame",), 1e-4, -0.05, 0.05),
    "sensor_offset": ("offset", RANGES, 0.001, -0.5, 0.5),
    "sensor_scale": ("scale", RANGES, 1.001, 0.5, 2.0),
    "sensor_latency": ("time", ("sensors",), 0.01, 0.0, 0.5),
}
"""Effect -> its size, its places, where a fit of it starts, its least and largest."""
ENTRIES = {f"{effect} {place}": own for effect, own in SIZES.items() for place in own[1]}
MOST_NAMES, FITTED = 3, 12
TUNED = ("base_radius", "motor_azimuth", "home_offset", "forearm_length")
STEPS = {"base_radius": 1e-3, "forearm_length": 1e-3, "motor_azimuth": 3e-3, "home_offset": 3e-3}
GROW, SHRINK, DONE, ROUNDS = 1.1, 0.9, 1e-3, 400
PROBED = 300
"""Readings that the calibration uses; more take longer and change little."""


@dataclass(frozen=True)
class Run:
    """One recording: times (n,) [s], motor angles (n, 3) [rad], readings and use (n, 3)."""

    t_s: Array
    motor_rad: Array
    read_m: Array
    kept: np.ndarray[Any, np.dtype[np.bool_]]
    robot: Json


def recording(file: Path, robot: Json) -> Run:
    """A flat recording."""
    columns = read(file)
    steps = np.column_stack([columns[f"steps_{motor}"] for motor in (1, 2, 3)])
    ranges = np.column_stack([columns[name] for name in RANGES])
    status = np.column_stack([columns[name.replace("range", "status")] for name in RANGES])
    return Run(columns["t"], robot["rad_per_step"] * steps, ranges, status == 0, robot)


def platform_m(arm_rad: Array, robot: Json, values: Values) -> Array:
    """Platform positions (n, 3) for arm angles (n, 3).

    Each forearm holds the platform on a sphere about its elbow, drawn in by the platform's radius;
    the lower of the two points that three spheres share. NaN where they share none.
    """
    centres = []
    for arm in range(3):
        azimuth = robot["azimuth_rad"][arm] + values.get(f"motor_azimuth {MOTORS[arm]}", 0.0)
        upper = robot["upper_arm_m"] + values.get(f"upper_arm_length {ARMS[arm]}", 0.0)
        out = robot["base_radius_m"] + values.get("base_radius frame", 0.0)
        out = out - robot["platform_radius_m"] + upper * np.cos(arm_rad[:, arm])
        down = -upper * np.sin(arm_rad[:, arm])
        centres.append(np.column_stack([out * np.cos(azimuth), out * np.sin(azimuth), down]))
    fore = [robot["forearm_m"] + values.get(f"forearm_length {arm}", 0.0) for arm in ARMS]
    # Differences of the spheres are planes; they meet in a line through `foot`.
    first, second = centres[1] - centres[0], centres[2] - centres[0]
    along = _cross(first, second)
    size = np.sqrt((along**2).sum(axis=1))[:, None]
    along *= -np.sign(along[:, 2:]) / size
    one = 0.5 * ((first**2).sum(axis=1) + fore[0] ** 2 - fore[1] ** 2)[:, None]
    other = 0.5 * ((second**2).sum(axis=1) + fore[0] ** 2 - fore[2] ** 2)[:, None]
    volume = (_cross(first, second) * along).sum(axis=1)[:, None]
    foot = (one * _cross(second, along) + other * _cross(along, first)) / volume
    with np.errstate(invalid="ignore"):
        reach = np.sqrt(fore[0] ** 2 - (foot**2).sum(axis=1))
    return np.asarray(centres[0] + foot + reach[:, None] * along, dtype=np.float64)


def _cross(a: Array, b: Array) -> Array:
    """Vector products of rows (n, 3); numpy's own is three times slower here."""
    (ax, ay, az), (bx, by, bz) = a.T, b.T
    product: Array = np.column_stack([ay * bz - az * by, az * bx - ax * bz, ax * by - ay * bx])
    return product


def model(run: Run, values: Values) -> Array:
    """What the sensors would read (n, 3)."""
    step_s = float(np.median(np.diff(run.t_s)))
    arms = []
    for column, motor in zip(run.motor_rad.T, MOTORS, strict=True):
        angle, lag_s = column, values.get(f"following_lag {motor}", 0.0)
        if lag_s > 0.0:
            keep = float(np.exp(-step_s / lag_s))
            # The motor turns evenly from one row to the next.
            share = lag_s / step_s * (1.0 - keep)
            start = [angle[0] * (share - keep)]
            angle = lfilter([1.0 - share, share - keep], [1.0, -keep], angle, zi=start)[0]
        angle = angle * values.get(f"gear_ratio {motor}", 1.0)
        if (width := values.get(f"gear_backlash {motor}", 0.0)) > 0.0:
            angle = play(angle, width)
        arms.append(angle + values.get(f"home_offset {motor}", 0.0))
    at: Array = platform_m(np.column_stack(arms), run.robot, values) + run.robot["sensor_m"]
    if (late_s := values.get("sensor_latency sensors", 0.0)) > 0.0:
        at = np.column_stack([np.interp(run.t_s - late_s, run.t_s, column) for column in at.T])
    for axis, name in enumerate(RANGES):
        scale = values.get(f"sensor_scale {name}", 1.0)
        at[:, axis] = at[:, axis] * scale + values.get(f"sensor_offset {name}", 0.0)
    return at


def healthy(entry: str) -> float:
    """Size of an entry that is not there."""
    return 1.0 if entry.split()[0] in SHARES else 0.0


def off(run: Run, values: Values, kept: Any = None) -> Array:
    """Mismatches (m,) of the readings to use."""
    left = run.read_m - model(run, values)
    own: Array = np.nan_to_num(left[run.kept if kept is None else kept], nan=1.0)
    return own


def by_lmfit(run: Run) -> tuple[list[Json], Values]:
    """Findings, and the sizes of the best set."""
    slopes = np.array([_slope(run, entry) for entry in ENTRIES])
    start = run.read_m - model(run, {})
    kept, left = _without_wild(run, slopes, start)
    rest = np.where(kept, left, 0.0)
    pairs = kept[1:] & kept[:-1]
    r = float(np.clip((rest[1:] * rest[:-1])[pairs].sum() / (rest[1:] ** 2)[pairs].sum(), 0, 0.99))
    count = int(kept.sum())
    rows = count * (1.0 - r) / (1.0 + r)
    names = list(ENTRIES)
    table, aim = np.column_stack([slope[kept] for slope in slopes]), start[kept]
    gram, pull, total = table.T @ table, table.T @ aim, float(aim @ aim)

    def bic(squares: float, free: int) -> float:
        return float(rows * np.log(squares / count) + free * np.log(rows))

    quick: list[tuple[float, tuple[int, ...]]] = []
    for size in range(MOST_NAMES + 1):
        for own in itertools.combinations(range(len(names)), size):
            chosen = list(own)
            part = np.linalg.lstsq(gram[np.ix_(chosen, chosen)], pull[chosen], rcond=1e-12)[0]
            quick.append((bic(total - float(part @ pull[chosen]), size), own))
    best: tuple[float, list[str], Any] = (np.inf, [], None)
    for _, own in sorted(quick)[:FITTED]:
        chosen_names, result = [names[place] for place in own], None
        squares = total
        if own:
            result = _fitted(run, chosen_names, kept)
            squares = float(np.sum(result.residual**2))
        if (score := bic(squares, len(own))) < best[0]:
            best = score, chosen_names, result
    _, found, result = best
    widen = 1.96 * float(np.sqrt(count / rows))
    values = {entry: float(result.params[_key(entry)].value) for entry in found}
    errors = {entry: result.params[_key(entry)].stderr for entry in found}
    return [
        finding(entry, values[entry], None if error is None else widen * error)
        for entry, error in errors.items()
    ], values


def _without_wild(run: Run, slopes: Array, start: Array) -> tuple[Any, Array]:
    """Readings to use (n, 3), and what all entries together leave of those that are valid."""
    left = np.where(run.kept, start, np.nan)
    for _ in range(3):
        use = np.isfinite(left) & (np.abs(left - np.nanmedian(left)) < WILD * _robust(left))
        table = np.column_stack([slope[use] for slope in slopes])
        sizes = np.linalg.lstsq(table, start[use], rcond=1e-10)[0]
        left = np.where(run.kept, start - np.tensordot(sizes, slopes, 1), np.nan)
    return use, left


def _fitted(run: Run, entries: list[str], kept: Any) -> Any:
    import lmfit

    parameters = lmfit.Parameters()
    for entry in entries:
        _, _, begin, low, high = ENTRIES[entry]
        parameters.add(_key(entry), value=begin, min=low, max=high)

    def miss(p: Any) -> Array:
        return off(run, {entry: p[_key(entry)].value for entry in entries}, kept)

    return lmfit.minimize(miss, parameters, max_nfev=60 * len(entries), epsfcn=1e-10)


def _key(entry: str) -> str:
    return entry.replace(" ", "__")


def _robust(left: Array) -> float:
    return 1.4826 * float(np.nanmedian(np.abs(left - np.nanmedian(left)))) + 1e-9


def _slope(run: Run, entry: str) -> Array:
    begin = ENTRIES[entry][2]
    change: Array = (model(run, {entry: begin}) - model(run, {})) / (begin - healthy(entry))
    return change


def finding(entry: str, value: float, half: float | None) -> Json:
    """In the form of the diagnosis."""
    effect, place = entry.split()
    return finding_of(effect, {ENTRIES[entry][0]: size_of(value, half)}, place)


def by_klipper(run: Run) -> tuple[list[Json], Values]:
    """What moved by more than its own spread, and all that the calibration of all readings set."""
    left = np.where(run.kept, run.read_m - model(run, {}), np.nan)
    wild = np.abs(left - np.nanmedian(left, axis=0)) > WILD * _robust(left) + 0.05
    rows = np.flatnonzero((run.kept & ~wild).all(axis=1))
    rows = rows[:: max(1, len(rows) // PROBED)]
    whole = _descend(_part(run, rows))
    quarters = [_descend(_part(run, part)) for part in np.array_split(rows, 4)]
    findings = []
    for entry, value in whole.items():
        own = np.array([quarter[entry] for quarter in quarters])
        half = float(student.ppf(0.975, 3) * own.std(ddof=1) / 2.0)
        if abs(value) > half:
            findings.append(finding(entry, value, half))
    return findings, whole


def _part(run: Run, rows: Any) -> Run:
    return Run(run.t_s[rows], run.motor_rad[rows], run.read_m[rows], run.kept[rows], run.robot)


def _descend(run: Run) -> dict[str, float]:
    """Coordinate descent from the healthy robot."""
    values = {entry: 0.0 for entry in ENTRIES if entry.split()[0] in TUNED}
    steps = {entry: STEPS[entry.split()[0]] for entry in values}
    seen = run.read_m - np.array(run.robot["sensor_m"])

    def miss() -> float:
        arms = run.motor_rad + [values[f"home_offset {motor}"] for motor in MOTORS]
        squares = float(np.sum((seen - platform_m(arms, run.robot, values)) ** 2))
        return squares if np.isfinite(squares) else np.inf

    best = miss()
    for _ in range(ROUNDS):
        if all(step < DONE * STEPS[entry.split()[0]] for entry, step in steps.items()):
            break
        for entry, step in steps.items():
            before = values[entry]
            for change in (step, -step):
                values[entry] = before + change
                if (now := miss()) < best:
                    best, steps[entry] = now, step * GROW
                    break
            else:
                values[entry], steps[entry] = before, step * SHRINK
    return values


TOOLS = {"lmfit": by_lmfit, "Klipper": by_klipper}


def answer(tool: str, folder: Path, robot: Json) -> Json:
    """Findings in the form of the diagnosis, with seconds and held-out error, of one delta."""
    begun = time.process_time()
    try:
        run = recording(folder / "recording.csv.gz", robot)
        if tool not in TOOLS:
            from benchmarks.rivals.delta_sysid import by_sysid

            found = by_sysid(tool, run, folder)
            seconds = time.process_time() - begun if found is not None else None
            return NOT_TAKEN | {"findings": found, "seconds": seconds}
        findings, values = TOOLS[tool](run)
    except (ValueError, TypeError, np.linalg.LinAlgError) as error:
        return NOT_TAKEN | {"failure": str(error), "seconds": time.process_time() - begun}
    seconds = time.process_time() - begun
    heldout = None
    if (apart := folder / "holdout.csv.gz").exists():
        left = off(recording(apart, robot), values)
        # Readings that jump by centimetres are no error of a model.
        near = np.abs(left - np.median(left)) < WILD * _robust(left)
        heldout = float(np.sqrt(np.mean(left[near] ** 2)))
    return {"findings": findings, "failure": None, "seconds": seconds, "heldout": heldout}
