"""Open-loop tracking of the paper's curves on the as-built robot, in time, and how far it is off.

The paper gives neither sizes nor heights of its curves. The sizes are of the order its figures
show; the heights lie in the working cylinder, chosen so that the geometric model's errors on the
as-built robot have the sizes of Table 3 (the lower the platform, the less its height depends on the
arms).
"""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np

from deltactl.firmware_py.collecting.survey import settings_of
from deltactl.firmware_py.paths.shapes import circle, heart, spiral
from deltactl.firmware_py.robot_file import RobotFile
from deltactl.models.robot import FloatArray, Sensors
from deltactl.models.training.dataset import SAMPLES, DataSet, DataSetWriter, IntArray, load_dataset
from deltactl.proof.ranging import read
from deltactl.proof.recorded import Machine, sample_times
from deltactl.proof.robot.as_built import StepTrain, together
from deltactl.proof.robot.run import run
from deltactl.reproduction.zhao_2023.as_built import AsBuiltFile

SPACING_M = 0.0005
T_PWM_S = (0.002, 0.006, 0.01, 0.02)
TRAINED_T_PWM_S = 0.006
CURVES = ("circle", "heart", "spiral")
TITLES = {"circle": "Circle", "heart": "Heart curve", "spiral": "Logarithmic spiral"}


def targets(curve: str) -> FloatArray:
    """Points of a curve one after another, (n, 3) [m]."""
    if curve == "circle":
        return circle((0.0, 0.0, -0.35), 0.1, 1.0, SPACING_M).targets
    if curve == "heart":
        return heart((0.0, 0.0, -0.57), 0.2, 1, SPACING_M).targets
    return spiral((0.0, 0.0, -0.60), 0.025, 0.1, 3.0, SPACING_M).targets


BoolArray = np.ndarray[Any, np.dtype[np.bool_]]
JUMP_M = 0.015
"""A reading this far from the median of its neighbours is dropped, as the driver's gate does."""
NEIGHBOURS = 5
REST_S = 0.1


@dataclass(frozen=True)
class Track:
    """One run. true_m: where the platform was when each target was reached, (n, 3).

    seen_s, seen_m, seen_target_m: readings at 50 Hz that passed, and the target then, (k, 3); NaN
    where a sensor gave nothing. counts: (k, 3), commanded at these times.
    """

    target_m: FloatArray
    t_s: FloatArray
    true_m: FloatArray
    seen_s: FloatArray
    seen_m: FloatArray
    seen_target_m: FloatArray
    seen_counts: IntArray
    length_m: float
    seconds: float

    @property
    def true_error_m(self) -> FloatArray:
        """(n, 3)."""
        return self.true_m - self.target_m

    @property
    def seen_error_m(self) -> FloatArray:
        """(k, 3), NaN where nothing was seen."""
        return self.seen_m - self.seen_target_m


def follow(
    machine: Machine,
    sensors: Sensors,
    target_m: FloatArray,
    counts: IntArray,
    t_pwm_s: float,
    rng: np.random.Generator,
) -> Track:
    """Send counts (n, 3) for targets (n, 3), all motors stepping together every T_PWM.

    Raises UnreachablePoint when the robot cannot take a pose.
    """
    train, reached_s = train_through(counts, t_pwm_s)
    truth = run(machine.robot, train)
    true_m = at_times(truth.t_s, truth.position_m, reached_s)
    t_s = sample_times(train)
    t_s = t_s[t_s <= reached_s[-1]]
    ranges_m, status = read(machine.sensors, machine.noise, truth, t_s, rng)
    ranges_m = np.where(good(ranges_m, status), ranges_m, np.nan)
    return Track(
        target_m=target_m,
        t_s=reached_s,
        true_m=true_m,
        seen_s=t_s,
        seen_m=np.linalg.solve(sensors.axes, (ranges_m - sensors.offsets_m).T).T,
        seen_target_m=at_times(reached_s, target_m, t_s),
        seen_counts=train.at(t_s),
        length_m=float(np.linalg.norm(np.diff(target_m, axis=0), axis=1).sum()),
        seconds=float(reached_s[-1]),
    )


def train_through(counts: IntArray, t_pwm_s: float) -> tuple[StepTrain, FloatArray]:
    """Steps through counts (n, 3) with a rest at the last, and when each is reached, (n,) [s]."""
    dwell_s = np.zeros(len(counts))
    dwell_s[-1] = REST_S
    ticks = np.cumsum(np.abs(np.diff(counts, axis=0, prepend=counts[:1])).max(axis=1))
    return together(counts[0], counts, dwell_s, t_pwm_s), ticks * t_pwm_s


def at_times(known_s: FloatArray, values: FloatArray, t_s: FloatArray) -> FloatArray:
    """Columns of values (n, k) known at times (n,), at others."""
    columns = [np.interp(t_s, known_s, column) for column in values.T]
    return np.stack(columns, axis=1)


def good(ranges_m: FloatArray, status: IntArray) -> BoolArray:
    """Readings that a driver's gate would let pass, (n, 3)."""
    half = NEIGHBOURS // 2
    valid = np.where(status == 0, ranges_m, np.nan)
    padded = np.pad(valid, ((half, half), (0, 0)), mode="edge")
    around = np.stack([padded[k : k + len(valid)] for k in range(NEIGHBOURS)])
    # A window without any valid reading judges nothing: NaN compares as false.
    good: BoolArray = np.abs(valid - _median(around)) <= JUMP_M
    return good


def _median(around: FloatArray) -> FloatArray:
    """Median over the first axis without NaN; NaN where there is nothing else."""
    ordered = np.sort(around, axis=0)
    count = np.isfinite(around).sum(axis=0)
    middle: FloatArray = np.take_along_axis(ordered, (np.maximum(count, 1) - 1)[None] // 2, axis=0)
    first: FloatArray = middle[0]
    return first


def rms_m(error_m: FloatArray) -> FloatArray:
    """Root mean square per axis, (3,), of errors (n, 3); NaN left out."""
    rms: FloatArray = np.sqrt(np.nanmean(error_m**2, axis=0))
    return rms


def greatest_m(error_m: FloatArray) -> FloatArray:
    """Largest size per axis, (3,); NaN left out."""
    largest: FloatArray = np.nanmax(np.abs(error_m), axis=0)
    return largest


def distance_m(error_m: FloatArray) -> float:
    """Root mean square of the distance, over rows without NaN."""
    return float(np.sqrt(np.nanmean(np.sum(error_m**2, axis=1))))


HALF_A_SECOND = 25
"""Readings."""


def slow_m(error_m: FloatArray) -> FloatArray:
    """A running mean over half a second of readings: noise taken off, for figures; (n, 3)."""
    known = np.isfinite(error_m)
    kernel = np.ones(HALF_A_SECOND)
    columns = []
    for axis in range(error_m.shape[1]):
        total = np.convolve(np.where(known[:, axis], error_m[:, axis], 0.0), kernel, "same")
        count = np.convolve(known[:, axis].astype(np.float64), kernel, "same")
        columns.append(total / np.maximum(count, 1.0))
    return np.stack(columns, axis=1)


def collect_on_curve(
    folder: Path, robot: RobotFile, built: AsBuiltFile, curve: str, track: Track
) -> DataSet:
    """Single readings at 50 Hz in motion: there is no time to rest. Writes it anew."""
    settings = settings_of(
        robot, "as-built", 0, built.mark, f"{curve}, once round", TRAINED_T_PWM_S
    )
    seen = np.isfinite(track.seen_m).all(axis=1)
    (folder / SAMPLES).unlink(missing_ok=True)
    with DataSetWriter(folder, settings) as writer:
        writer.append(zip(track.seen_counts[seen], track.seen_m[seen], strict=True))
    return load_dataset(folder)
