"""From a recorded run to a flat table, counts exactly as sent: readings gathered into rounds, the
samples of a servo's loop, or what was commanded where no sensor saw anything.
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from pathlib import Path

import numpy as np

from deltactl.foundation.errors import RecordingError
from deltactl.recording.reading.run import BoolArray, FloatArray, Int64Array, Readings, Run
from deltactl.recording.tables.flat import AnyArray, FlatRecording

_NS = 1e-9
STEMS = {
    "command": "reference_rad",
    "theta": "angle_rad",
    "current": "current_a",
    "disturbance": "disturbance_a",
}
"""Columns of the table and the fields of `deltactl.recording.run.Servo` they come from."""


def servo_rows(
    run: Run, fresh: dict[str, Readings]
) -> tuple[Int64Array, dict[str, FloatArray], dict[str, AnyArray]]:
    """Times [ns], columns of the contract, and columns beside it.

    `fresh` are the readings of each sensor without stale ones. A range is in the row whose
    time is nearest to the reading's own, which is kept as `t_x, t_y, t_z`; other rows are empty.
    """
    rising = np.concatenate([[True], np.diff(run.servo.t_ns) > 0])
    t_ns = run.servo.t_ns[rising]
    columns = {
        f"{stem}_{motor + 1}": getattr(run.servo, field)[rising, motor]
        for stem, field in STEMS.items()
        for motor in range(3)
    }
    extra: dict[str, AnyArray] = {}
    for axis, samples in fresh.items():
        rows = _nearest_sample(t_ns, samples.t_ns)
        columns[f"range_{axis}"] = _spread(len(t_ns), rows, samples.distance_m)
        columns[f"status_{axis}"] = _spread(len(t_ns), rows, samples.status.astype(np.float64))
        extra[f"t_{axis}"] = _spread(len(t_ns), rows, samples.t_ns * _NS)
    return t_ns, columns, extra


def _nearest_sample(t_ns: Int64Array, at_ns: Int64Array) -> Int64Array:
    """The row nearest to each time."""
    right = np.clip(np.searchsorted(t_ns, at_ns), 1, max(1, len(t_ns) - 1))
    right = np.minimum(right, len(t_ns) - 1)
    left = np.maximum(right - 1, 0)
    return np.where(at_ns - t_ns[left] <= t_ns[right] - at_ns, left, right)


def _spread(length: int, rows: Int64Array, values: FloatArray) -> FloatArray:
    """A column with values in some rows and nothing in the others."""
    column = np.full(length, np.nan)
    column[rows] = values
    return column


AXES = ("x", "y", "z")


@dataclass(frozen=True, slots=True)
class Rounds:
    """Readings gathered into rounds.

    sensors: fresh samples of x, y, z. chosen: shape (n, 3), index of each round's sample in
    its sensor, -1 = none. t_s: shape (n,), mean time of the samples of each round, increasing.
    """

    sensors: tuple[Readings, Readings, Readings]
    chosen: Int64Array
    t_s: FloatArray

    @property
    def t_ns(self) -> Int64Array:
        """Times of the rounds; shape (n,)."""
        t_ns: Int64Array = np.rint(self.t_s / _NS).astype(np.int64)
        return t_ns

    def pick(self, name: str) -> FloatArray:
        """A field of `Readings` for every round; shape (n, 3), NaN where there is no sample."""
        parts = [
            _pick(getattr(samples, name), self.chosen[:, k])
            for k, samples in enumerate(self.sensors)
        ]
        return np.stack(parts, axis=1)


def gather(run: Run) -> Rounds:
    """The reading rounds of a run. Raises RecordingError when it holds no readings."""
    x, y, z = (_fresh(run.readings[axis]) for axis in AXES)
    sensors = (x, y, z)
    if not any(len(samples.t_ns) for samples in sensors):
        raise RecordingError(f"{run.path}: holds no readings of the distance sensors")
    chosen = _choose(list(sensors), run.path)
    t_s = np.nanmean(Rounds(sensors, chosen, np.zeros(0)).pick("t_ns"), axis=1) * _NS
    rising = np.concatenate([[True], np.diff(t_s) > 0.0])
    return Rounds(sensors, chosen[rising], t_s[rising])


def flatten(run: Run, with_truth: bool = False) -> FlatRecording:
    """One row a reading round, in the columns of the contract.

    `t` is the mean time at which the readings of the row were taken; the time of each one is
    kept beside it as `t_x, t_y, t_z`. A sensor that gave nothing new within half a period has
    an empty cell. `steps_i` is what was really sent up to `t`. `with_truth` adds
    `truth_x_m..truth_z_m` and `truth_theta_1_rad..3` of a simulated robot.

    The run of a servo has a row for each sample of its loop instead, see `servo_table`.
    Raises RecordingError when the run holds no readings.
    """
    if len(run.servo.t_ns):
        return _flatten_servo(run, with_truth)
    rounds = gather(run)
    columns = _steps(run, rounds.t_ns) | _named("range", rounds.pick("distance_m"))
    columns |= _named("status", rounds.pick("status"))
    t_pwm_s = run.settings.t_pwm_at(rounds.t_ns)
    if np.isfinite(t_pwm_s).any():
        columns["t_pwm"] = t_pwm_s
    extra: dict[str, AnyArray] = dict(_named("t", rounds.pick("t_ns") * _NS))
    if with_truth:
        extra |= _truth(run, rounds.t_ns)
    return FlatRecording(rounds.t_s, columns, extra, str(run.path), _whole(run, len(rounds.t_s)))


def _flatten_servo(run: Run, with_truth: bool) -> FlatRecording:
    fresh = {axis: _fresh(run.readings[axis]) for axis in AXES}
    t_ns, columns, extra = servo_rows(run, fresh)
    if with_truth:
        extra |= _truth(run, t_ns)
    return FlatRecording(t_ns * _NS, columns, extra, str(run.path), _whole(run, len(t_ns)))


def _whole(run: Run, rows: int) -> int:
    """About how many rows the whole file has, where only stretches of it were read; else 0."""
    return round(rows / run.share) if run.share < 1.0 else 0


def _fresh(samples: Readings) -> Readings:
    """Without samples that repeat the one before (same stream count)."""
    return samples.where(~samples.stale)


def _choose(sensors: list[Readings], path: Path) -> Int64Array:
    """Which sample of each sensor belongs to which round; shape (rounds, 3), -1 = none."""
    leader = max(sensors, key=lambda samples: len(samples.t_ns))
    period_ns = _period_ns(leader.t_ns)
    if period_ns <= 0.0:
        raise RecordingError(f"{path}: readings of {leader.axis} have no times apart")
    grid_ns = _grid(leader.t_ns, sensors, period_ns)
    chosen = np.stack([_nearest(samples.t_ns, grid_ns, period_ns) for samples in sensors], axis=1)
    some: BoolArray = (chosen >= 0).any(axis=1)
    return chosen[some]


def _period_ns(t_ns: Int64Array) -> float:
    return float(np.median(np.diff(t_ns))) if len(t_ns) > 1 else 20e6


def _grid(leader_ns: Int64Array, sensors: list[Readings], period_ns: float) -> FloatArray:
    """Middles of the rounds: the busiest sensor's times, continued where it was silent and
    another was not.
    """
    seen = np.sort(np.concatenate([samples.t_ns for samples in sensors]))
    before = _round_numbers((leader_ns[0] - seen[seen < leader_ns[0]]) / period_ns)
    after = _round_numbers((seen[seen > leader_ns[-1]] - leader_ns[-1]) / period_ns)
    inside = [leader_ns.astype(np.float64)]
    for gap in np.flatnonzero(np.diff(leader_ns) > 1.5 * period_ns):
        start, end = leader_ns[gap : gap + 2]
        count = round((end - start) / period_ns)
        first, last = np.searchsorted(seen, (start, end))
        numbers = _round_numbers((seen[first:last] - start) / (end - start) * count)
        inside.append(start + (end - start) / count * numbers[numbers < count])
    grid_ns: FloatArray = np.concatenate(
        [
            (leader_ns[0] - period_ns * before)[::-1],
            np.sort(np.concatenate(inside)),
            leader_ns[-1] + period_ns * after,
        ]
    )
    return grid_ns + _shift_ns(leader_ns, sensors, period_ns)


def _round_numbers(turns: FloatArray) -> FloatArray:
    """Numbers from 1 of the rounds that samples may fall into, so many periods away."""
    nearest = np.rint(turns)
    numbers: FloatArray = np.unique(np.concatenate([nearest - 1.0, nearest, nearest + 1.0]))
    return numbers[numbers >= 1.0]


def _shift_ns(leader_ns: Int64Array, sensors: list[Readings], period_ns: float) -> float:
    """From the busiest sensor's sample to the middle of the three sensors' samples.

    Sensors on one bus are read one after another. A round is cut where the silence between
    its samples is longest, so that jitter cannot push a sample into the next round.
    """
    turns = []
    for samples in sensors:
        if len(samples.t_ns):
            behind_ns = samples.t_ns - leader_ns[_nearest_index(leader_ns, samples.t_ns)]
            angle = np.angle(np.mean(np.exp(2j * np.pi * behind_ns / period_ns)))
            turns.append(float(angle / (2 * np.pi)) % 1.0)
    turns.sort()
    silences = np.diff([*turns, turns[0] + 1.0])
    widest = int(np.argmax(silences))
    start = turns[(widest + 1) % len(turns)]
    middle = start + (1.0 - float(silences[widest])) / 2.0
    return period_ns * ((middle + 0.5) % 1.0 - 0.5)


def _nearest_index(sorted_ns: FloatArray | Int64Array, t_ns: Int64Array) -> Int64Array:
    """Index of the entry of `sorted_ns` nearest to each time."""
    right = np.clip(np.searchsorted(sorted_ns, t_ns), 1, max(1, len(sorted_ns) - 1))
    right = np.minimum(right, len(sorted_ns) - 1)
    left = np.maximum(right - 1, 0)
    closer_left = t_ns - sorted_ns[left] <= sorted_ns[right] - t_ns
    return np.where(closer_left, left, right)


def _nearest(t_ns: Int64Array, grid_ns: FloatArray, period_ns: float) -> Int64Array:
    """For each round the sample nearest to its middle, within half a period; -1 = none."""
    chosen = np.full(len(grid_ns), -1, dtype=np.int64)
    if not len(t_ns):
        return chosen
    rounds = _nearest_index(grid_ns, t_ns)
    off_ns = np.abs(t_ns - grid_ns[rounds])
    # The farthest first, so that the nearest is the one that stays.
    for_all = np.argsort(-off_ns, kind="stable")
    for_all = for_all[off_ns[for_all] <= period_ns / 2]
    chosen[rounds[for_all]] = for_all
    return chosen


def _pick(values: AnyArray, index: Int64Array) -> FloatArray:
    """Values at the chosen samples, NaN where there is none."""
    if not len(values):
        return np.full(len(index), np.nan)
    return np.where(index >= 0, values[np.maximum(index, 0)], np.nan)


def _named(stem: str, values: FloatArray) -> dict[str, FloatArray]:
    """Columns `stem_x..z` from shape (n, 3)."""
    return {f"{stem}_{axis}": values[:, k] for k, axis in enumerate(AXES)}


def _steps(run: Run, t_ns: Int64Array) -> dict[str, FloatArray]:
    counts = run.edges.counts_at(t_ns)
    return {f"steps_{k + 1}": counts[:, k].astype(np.float64) for k in range(3)}


def _truth(run: Run, t_ns: Int64Array) -> dict[str, AnyArray]:
    """Simulated truth at the rows, straight between the recorded samples."""
    truth = run.truth
    if not len(truth.t_ns):
        raise RecordingError(f"{run.path}: holds no simulated truth; only simulated runs do")
    named = {f"truth_{axis}_m": truth.position_m[:, k] for k, axis in enumerate(AXES)}
    named |= {f"truth_theta_{k + 1}_rad": truth.angles_rad[:, k] for k in range(3)}
    return {
        name: np.interp(t_ns, truth.t_ns, values, left=np.nan, right=np.nan)
        for name, values in named.items()
    }


OF_SENSORS = frozenset(f"{stem}_{axis}" for stem in ("range", "status", "t") for axis in AXES)


def has_readings(run: Run) -> bool:
    """Whether a distance sensor gave anything."""
    return any(len(samples.t_ns) for samples in run.readings.values())


def flatten_unseen(run: Run, with_truth: bool = False) -> FlatRecording:
    """As `flatten`, without columns of sensors; a stepper's rows are those of the control loop.

    Raises RecordingError when nothing was commanded, or there is no truth to add.
    """
    if with_truth and not len(run.truth.t_ns):
        raise RecordingError(f"{run.path}: holds no simulated truth; only simulated runs do")
    if len(run.servo.t_ns):
        table = flatten(run, with_truth)
        columns = {name: values for name, values in table.columns.items() if name not in OF_SENSORS}
        extra = {name: values for name, values in table.extra.items() if name not in OF_SENSORS}
        return replace(table, columns=columns, extra=extra)
    t_ns = np.unique(run.commanded.t_ns)
    if not len(t_ns):
        raise RecordingError(f"{run.path}: nothing was commanded, and no sensor read")
    counts = run.edges.counts_at(t_ns).astype(np.float64)
    steps = {f"steps_{motor + 1}": counts[:, motor] for motor in range(counts.shape[1])}
    t_pwm_s = run.settings.t_pwm_at(t_ns)
    timed = {"t_pwm": t_pwm_s} if np.isfinite(t_pwm_s).any() else {}
    truth: dict[str, AnyArray] = {}
    if with_truth:
        named = {f"truth_{axis}_m": run.truth.position_m[:, k] for k, axis in enumerate(AXES)}
        named |= {f"truth_theta_{k + 1}_rad": run.truth.angles_rad[:, k] for k in range(3)}
        truth = {
            name: np.interp(t_ns, run.truth.t_ns, values, left=np.nan, right=np.nan)
            for name, values in named.items()
        }
    return FlatRecording(t_ns * _NS, steps | timed, truth, str(run.path))
