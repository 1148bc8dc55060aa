"""How far from its targets a job was drawn, by the distance sensors, before and after.

A reading scatters by millimetres, and what is looked for is a tenth of that. Errors of tracking
change slowly along a path, so readings are averaged over half a second of it, over all repeats of
the same job, and what the noise of these means adds to their squares is taken away again.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from deltactl.models.chain import Chain, Commands
from deltactl.models.effects import Compensated, card_of
from deltactl.models.robot import AXES, DeltaRobot, FloatArray
from deltactl.recording.tables.flat import FlatRecording

BoolArray = np.ndarray[Any, np.dtype[np.bool_]]
IntArray = np.ndarray[Any, np.dtype[np.int64]]
BIN_S = 0.5
FEWEST = 4
"""Fewer good readings in a bin do not show how much they scatter."""
OUTLIER = 4.0
"""Readings farther from the median of their bin, in standard deviations, are left out."""
TO_SIGMA = 1.4826
"""From the median of absolute deviations to a standard deviation."""
TWO_SIDED_95 = 1.96
MOST_INFLATED = 20.0


@dataclass(frozen=True, eq=False)
class Seen:
    """One drawing: the readings of it, and the target at each of its times.

    target_at_m: (n, 3, 3) [m], the target at the time of each of the three readings of a row, NaN
    off the path.
    """

    table: FlatRecording
    target_at_m: FloatArray


@dataclass(frozen=True, slots=True)
class Distance:
    """Mean square distance from the target [m2], and its standard deviation."""

    square_m2: float
    sigma_m2: float

    @property
    def rms_m(self) -> float:
        """Root mean square; 0 where noise alone would show as much."""
        return float(np.sqrt(max(self.square_m2, 0.0)))

    @property
    def ci95_m(self) -> tuple[float, float]:
        """Ends of its 95 % interval [m]."""
        off = TWO_SIDED_95 * self.sigma_m2
        low, high = np.sqrt(np.maximum([self.square_m2 - off, self.square_m2 + off], 0.0))
        return float(low), float(high)

    @property
    def text(self) -> str:
        """In words."""
        if np.isnan(self.square_m2):
            return "not seen"
        low, high = self.ci95_m
        return f"{self.rms_m * 1e3:.2f} mm [{low * 1e3:.2f}, {high * 1e3:.2f}]"


@dataclass(frozen=True, slots=True)
class Gain:
    """By how much the mean square distance has become smaller [m2], and its standard deviation."""

    square_m2: float
    sigma_m2: float

    @property
    def sign(self) -> int:
        """1 where the job is drawn better for sure, -1 where worse for sure, else 0."""
        off = TWO_SIDED_95 * self.sigma_m2
        return int(self.square_m2 > off) - int(self.square_m2 < -off)

    @property
    def ci95_m2(self) -> tuple[float, float]:
        """Ends of its 95 % interval [m2]."""
        off = TWO_SIDED_95 * self.sigma_m2
        return self.square_m2 - off, self.square_m2 + off


def gain(before: Sequence[Seen], after: Sequence[Seen], robot: DeltaRobot) -> Gain:
    """What a correction has gained, paired over the path.

    Both drawings differ by what other counts do, d, which is known: with e the error after it, the
    one before is e + d, and the mean square is smaller by the mean of d (2 e + d), the sum of what
    both drawings err along d. That sum scatters far less than the two errors by themselves, where
    the correction is small. robot: the corrected one.
    """
    models = [_modelled(runs[0], robot) for runs in (before, after)]

    def moved_m(share: FloatArray) -> FloatArray:
        """d at shares of the path, (n, 3)."""
        columns = [
            np.interp(share, models[0][0], models[0][1][:, axis])
            - np.interp(share, models[1][0], models[1][1][:, axis])
            for axis in range(len(AXES))
        ]
        return np.stack(columns, axis=1)

    along = [_along(runs, robot, moved_m) for runs in (before, after)]
    return Gain(sum(mean for mean, _ in along), float(np.sqrt(sum(var for _, var in along))))


def _along(
    runs: Sequence[Seen], robot: DeltaRobot, moved_m: Callable[[FloatArray], FloatArray]
) -> tuple[float, float]:
    """Mean of error times d over all coordinates [m2], and its variance [m4]."""
    phase, error_m, share = _on_path(runs, robot)
    d_m = moved_m(share)
    mean = variance = 0.0
    for axis in range(len(AXES)):
        values, along_m = error_m[:, axis], d_m[:, axis]
        good = np.zeros(len(values), dtype=np.bool_)
        leftovers = []
        for number in np.unique(phase):
            rows = np.flatnonzero((phase == number) & np.isfinite(values))
            rows = rows[_usual(values[rows])]
            if len(rows) >= FEWEST:
                good[rows] = True
                leftovers.append(values[rows] - values[rows].mean())
        if not leftovers:
            return np.nan, np.nan
        freedom = sum(len(left) - 1 for left in leftovers)
        scatter = sum(float(left @ left) for left in leftovers) / freedom
        count = int(good.sum())
        mean += float(values[good] @ along_m[good]) / count
        variance += (
            _inflation(leftovers) * scatter * float(along_m[good] @ along_m[good]) / count**2
        )
    return mean, variance


def _modelled(seen: Seen, robot: DeltaRobot) -> tuple[FloatArray, FloatArray]:
    """Share of the path (n,), and the error there by the robot file and the counts, (n, 3) [m]."""
    on_path = _rows_on_path(seen)
    position_m = _chain(robot).simulate(_commands(seen.table, robot), robot.effects).position
    target_m = seen.target_at_m.mean(axis=1)
    return _share(target_m[on_path]), (position_m - target_m)[on_path]


def _share(target_m: FloatArray) -> FloatArray:
    """How much of the path is done at each of its targets, 0 to 1."""
    way_m = np.concatenate([[0.0], np.cumsum(np.linalg.norm(np.diff(target_m, axis=0), axis=1))])
    share: FloatArray = way_m / max(float(way_m[-1]), 1e-12)
    return share


def _rows_on_path(seen: Seen) -> BoolArray:
    on_path: BoolArray = np.isfinite(seen.target_at_m).all(axis=(1, 2))
    return on_path


def _on_path(runs: Sequence[Seen], robot: DeltaRobot) -> tuple[IntArray, FloatArray, FloatArray]:
    """All rows on the path: number of the bin (n,), error (n, 3) [m], share of the path (n,)."""
    phases, errors, shares = [], [], []
    for seen in runs:
        on_path = _rows_on_path(seen)
        t_s = seen.table.t_s[on_path]
        phases.append(np.floor((t_s - t_s[:1]) / BIN_S).astype(np.int64))
        errors.append(errors_m(seen, robot)[on_path])
        shares.append(_share(seen.target_at_m.mean(axis=1)[on_path]))
    return np.concatenate(phases), np.concatenate(errors), np.concatenate(shares)


def distance(runs: Sequence[Seen], robot: DeltaRobot) -> Distance:
    """Distance of repeated drawings of one job from its path, by the sensors as `robot` has them.

    Needs a robot with sensors. Where nothing good was read, both figures are NaN.
    """
    phase, error_m, _ = _on_path(runs, robot)
    axes = [_one_axis(phase, error_m[:, axis]) for axis in range(error_m.shape[1])]
    return Distance(
        float(sum(square for square, _ in axes)),
        float(np.sqrt(sum(variance for _, variance in axes))),
    )


def errors_m(seen: Seen, robot: DeltaRobot) -> FloatArray:
    """Measured position minus target for every row, (n, 3) [m]; NaN where nothing good was read.

    What the robot's sensors are known to do to a reading is taken off first.
    """
    assert robot.sensors is not None
    table = seen.table
    ranges_m = np.stack([table.columns[f"range_{axis}"] for axis in AXES], axis=1)
    good = np.stack([table.columns[f"status_{axis}"] == 0.0 for axis in AXES], axis=1)
    excess_m = np.where(good, ranges_m, np.nan) - robot.sensors.offsets_m
    excess_m -= np.einsum("nsc,sc->ns", seen.target_at_m, robot.sensors.axes)
    excess_m -= _of_sensors_m(table, robot)
    error_m = np.full_like(excess_m, np.nan)
    for coordinate, weights in enumerate(np.linalg.inv(robot.sensors.axes)):
        needed = np.abs(weights) > 1e-9
        error_m[:, coordinate] = excess_m[:, needed] @ weights[needed]
    return error_m


def _of_sensors_m(table: FlatRecording, robot: DeltaRobot) -> FloatArray:
    """What effects of sensors and of their frame add to every reading, (n, 3) [m]."""
    moving = [
        entry
        for entry in robot.effects
        if card_of(entry.effect).compensated is not Compensated.IN_READINGS
    ]
    if len(moving) == len(robot.effects):
        return np.zeros((len(table), len(AXES)))
    chain, commands = _chain(robot), _commands(table, robot)
    with_them, without = (chain.simulate(commands, e).ranges for e in (robot.effects, moving))
    added: FloatArray = with_them - without
    return added


def _chain(robot: DeltaRobot) -> Chain:
    """Without effects, which are given to it afresh."""
    return Chain(robot.model_copy(update={"effects": ()}))


def _commands(table: FlatRecording, robot: DeltaRobot) -> Commands:
    assert robot.drive is not None
    counts = np.stack([table.columns[f"steps_{motor}"] for motor in (1, 2, 3)], axis=1)
    return Commands.of_counts(table.t_s, counts, robot.drive)


def _one_axis(phase: IntArray, error_m: FloatArray) -> tuple[float, float]:
    """Mean square of one coordinate along the path [m2], and the variance of that [m4]."""
    means, noise, weights, leftovers = [], [], [], []
    for number in np.unique(phase):
        values = error_m[(phase == number) & np.isfinite(error_m)]
        values = values[_usual(values)]
        if len(values) < FEWEST:
            continue
        left = values - values.mean()
        means.append(values.mean())
        noise.append(left @ left / (len(values) - 1) / len(values))
        weights.append(len(values))
        leftovers.append(left)
    if not means:
        return np.nan, np.nan
    share = np.array(weights) / sum(weights)
    variance = _inflation(leftovers) * np.array(noise)
    square = np.square(means) - variance
    # The variance of the square of a mean that has this noise.
    spread = 4.0 * np.maximum(square, 0.0) * variance + 2.0 * variance**2
    return float(share @ square), float(share**2 @ spread)


def _usual(values: FloatArray) -> BoolArray:
    """Those that are no outliers, (n,)."""
    if not len(values):
        return np.zeros(0, dtype=np.bool_)
    off = np.abs(values - np.median(values))
    sigma = TO_SIGMA * float(np.median(off))
    usual: BoolArray = off <= OUTLIER * sigma if sigma > 0.0 else np.ones(len(off), dtype=np.bool_)
    return usual


def _inflation(leftovers: Sequence[FloatArray]) -> float:
    """How much more a mean scatters as successive readings err alike: (1 + r) / (1 - r)."""
    together = sum(float(left[1:] @ left[:-1]) for left in leftovers)
    alone = sum(float(left @ left) for left in leftovers)
    alike = max(together / alone, 0.0) if alone > 0.0 else 0.0
    return min((1.0 + alike) / max(1.0 - alike, 1e-6), MOST_INFLATED)
