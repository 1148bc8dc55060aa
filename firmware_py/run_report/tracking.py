"""How well a run followed its path: asked for against simulated truth, measured and commanded."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

import numpy as np

from deltactl.firmware_py.planner.plan import home_counts
from deltactl.firmware_py.robot_file import RobotFile
from deltactl.firmware_py.run_report.reference import (
    arrivals,
    path_windows,
    ran_to_its_end,
    seconds,
    targets_at,
)
from deltactl.foundation.strict_yaml import Document
from deltactl.models.calibrated_inverse import CalibratedInverse
from deltactl.models.chain import Chain, Commands
from deltactl.models.effects import Compensated, card_of
from deltactl.models.robot import AXES, DeltaRobot, EffectEntry, FloatArray
from deltactl.models.servo_drive import ServoDrive
from deltactl.recording.reading.run import Run, Targets
from deltactl.recording.tables.rounds import gather

JOINT_SHAPES = frozenset({"survey", "joints"})
ENDED_EARLY = "The path was not run to its end: errors are of the {:.1f} s that were run"
_NS = 1e-9


@dataclass(frozen=True, slots=True)
class Tracking:
    """Position minus target, where the target is the point asked for at the same time.

    t_s: shape (n,). position_m, error_m: shape (n, 3), NaN where an axis was not observed.
    """

    name: str
    t_s: FloatArray
    position_m: FloatArray
    error_m: FloatArray

    @property
    def samples(self) -> tuple[int, int, int]:
        """Observed samples per axis."""
        x, y, z = np.isfinite(self.error_m).sum(axis=0).tolist()
        return (x, y, z)

    @property
    def rms_m(self) -> tuple[float, float, float]:
        """Root mean square error per axis; NaN without samples."""
        return self._over_axes(lambda error_m: float(np.sqrt(np.mean(error_m**2))))

    @property
    def max_m(self) -> tuple[float, float, float]:
        """Largest error per axis, as a size; NaN without samples."""
        return self._over_axes(lambda error_m: float(np.max(np.abs(error_m))))

    def as_json(self) -> dict[str, Any]:
        """Plain types, None for what was not observed."""
        table = zip(AXES, self.rms_m, self.max_m, self.samples, strict=True)
        return {
            axis: {"rms_m": _plain(rms_m), "max_m": _plain(max_m), "samples": samples}
            for axis, rms_m, max_m, samples in table
        }

    def _over_axes(self, measure: Any) -> tuple[float, float, float]:
        columns = [column[np.isfinite(column)] for column in self.error_m.T]
        x, y, z = [measure(column) if len(column) else float("nan") for column in columns]
        return (x, y, z)


@dataclass(frozen=True, slots=True)
class RunTracking:
    """Tracking while the path was followed; None where the run holds nothing to compare with.

    `measured` is not corrected for the sensors' noise: it contains it.
    `commanded` is where the robot of the robot file would be, with all of its effects: the error
    of the inverse kinematics, of rounding to whole steps, and of what is not compensated.
    """

    windows_ns: tuple[tuple[int, int], ...]
    truth: Tracking | None
    measured: Tracking | None
    commanded: Tracking | None
    whole: bool = True
    """Whether the path was run to its end."""

    @property
    def on_path_s(self) -> float:
        """How long the path was followed."""
        return sum(end - start for start, end in self.windows_ns) * _NS

    def all(self) -> list[Tracking]:
        """Those there are."""
        return [seen for seen in (self.truth, self.measured, self.commanded) if seen is not None]


def robot_of(run: Run) -> RobotFile:
    """The robot file a recording carries. Raises ConfigError when it does not hold one."""
    name = Path(f"{run.path} (robot file in it)")
    return Document(name, run.configuration.robot_text).check(RobotFile)


def asked_path(run: Run, robot: RobotFile) -> Run:
    """The run with a target wherever one is meant.

    A path in joint space is straight in the arm angles, not in space, between targets that may
    be far apart: there every commanded count is a target, through the robot file's linkage.
    """
    job = Document(Path(f"{run.path} (job file in it)"), run.configuration.job_text)
    joint = any(shape in JOINT_SHAPES for shape in _shapes(job.data))
    if not joint or not len(run.commanded.t_ns):
        return run
    sent = run.commanded
    position_m = positions_of_counts(robot, sent.steps)
    dense = Targets(sent.t_ns, np.arange(len(sent.t_ns)), position_m, sent.steps)
    return replace(run, targets=dense)


def _shapes(value: Any) -> Iterator[str]:
    """The shapes of all paths in a job, also of an older form."""
    if isinstance(value, dict):
        if isinstance(value.get("shape"), str):
            yield value["shape"]
        value = list(value.values())
    if isinstance(value, list):
        for inner in value:
            yield from _shapes(inner)


def track(run: Run, robot: RobotFile) -> RunTracking:
    """Compare a run with what was asked of it, only while it followed its path."""
    asked = asked_path(run, robot)
    in_joint_space, run = asked is not run, asked
    windows_ns = path_windows(run)
    truth = measured = commanded = None
    if len(run.truth.t_ns):
        t_s = seconds(run.truth.t_ns)
        error_m = run.truth.position_m - targets_at(run, t_s)
        truth = _against(run, windows_ns, "simulated truth", t_s, error_m)
    if robot.sensors is not None and any(len(samples.t_ns) for samples in run.readings.values()):
        measured = _against(run, windows_ns, "measured", *measured_errors(run, robot))
    if len(run.targets.t_ns) and not in_joint_space:
        there, targets = arrivals(run), run.targets
        error_m = _commanded_m(run, robot)[there] - targets.position_m[there]
        t_s = seconds(targets.t_ns[there])
        commanded = _against(run, windows_ns, "commanded", t_s, error_m)
    return RunTracking(windows_ns, truth, measured, commanded, ran_to_its_end(run))


def measured_errors(run: Run, robot: RobotFile) -> tuple[FloatArray, FloatArray]:
    """Times [s], shape (n,), and measured position minus target [m], shape (n, 3), of every round.

    range_i = offset_i + axis_i . p (contract). The three sensors of a round are read one after
    another while the platform moves, so each range is compared with the target at its own time;
    with the axes as the rows of A, error = A^-1 (range - offset - axis . target). A coordinate is
    NaN when a sensor it depends on gave nothing good.
    """
    assert robot.sensors is not None
    rounds = gather(run)
    good = rounds.pick("good") == 1.0
    excess_m = np.where(good, rounds.pick("distance_m"), np.nan) - robot.sensors.offsets_m
    for sensor, (axis, t_ns) in enumerate(
        zip(robot.sensors.axes, rounds.pick("t_ns").T, strict=True)
    ):
        excess_m[:, sensor] -= targets_at(run, t_ns * _NS) @ axis
    error_m = np.zeros_like(excess_m)
    for coordinate, weights in enumerate(np.linalg.inv(robot.sensors.axes)):
        needed = np.abs(weights) > 1e-9
        error_m[:, coordinate] = excess_m[:, needed] @ weights[needed]
    return rounds.t_s, error_m


def positions_of_counts(robot: RobotFile, counts: Any) -> FloatArray:
    """Modelled position of the platform [m] for counts of shape (n, 3).

    By the robot file's linkage and those of its effects that do not remember.
    """
    angles_rad = np.asarray(counts, dtype=np.float64) * robot.drive.rad_per_step
    return CalibratedInverse(robot).position_m(angles_rad)


def _commanded_m(run: Run, robot: RobotFile) -> FloatArray:
    """Where the counts put the accepted model when each target is due, (k, 3) [m].

    Play and drives that follow late depend on what was commanded before: with effects the whole
    course of the commands is simulated, as `check` does. Without, counts are whole steps.
    """
    targets, effects = run.targets, acting(robot)
    if not effects or isinstance(robot.drive, ServoDrive):
        return positions_of_counts(robot, targets.steps)
    known_s = np.concatenate([seconds(run.commanded.t_ns), seconds(targets.t_ns)])
    known_s, rows = np.unique(known_s, return_index=True)
    counts = np.vstack([run.commanded.steps, targets.steps])[rows]
    t_s = np.union1d(np.arange(known_s[0], known_s[-1] + SAMPLE_S, SAMPLE_S), known_s)
    course = np.stack([np.interp(t_s, known_s, column) for column in counts.T], axis=1)
    return reached_m(robot, effects, t_s, course, seconds(targets.t_ns))


def acting(robot: DeltaRobot) -> tuple[EffectEntry, ...]:
    """The effects of a robot that move it, and are not in its readings alone."""
    return tuple(
        one
        for one in robot.effects
        if card_of(one.effect).compensated is not Compensated.IN_READINGS
    )


SAMPLE_S = 0.005
"""Steps of time in which a model follows commands."""


def reached_m(
    robot: DeltaRobot,
    effects: tuple[EffectEntry, ...],
    t_s: FloatArray,
    counts: FloatArray,
    at_s: FloatArray,
) -> FloatArray:
    """Where the platform of a robot with these effects is at given times, (k, 3) [m].

    t_s, counts: the course of its commands, (n,) and (n, 3).
    """
    assert robot.drive is not None
    commands = Commands.of_counts(t_s, counts, robot.drive)
    plain = robot.model_copy(update={"effects": ()})
    position_m = Chain(plain).simulate(commands, effects).position
    return np.stack([np.interp(at_s, t_s, column) for column in position_m.T], axis=1)


def _against(
    run: Run,
    windows_ns: tuple[tuple[int, int], ...],
    name: str,
    t_s: FloatArray,
    error_m: FloatArray,
) -> Tracking:
    inside = np.zeros(len(t_s), dtype=np.bool_)
    for start_ns, end_ns in windows_ns:
        inside |= (t_s >= start_ns * _NS) & (t_s <= end_ns * _NS)
    t_s, error_m = t_s[inside], error_m[inside]
    return Tracking(name, t_s, targets_at(run, t_s) + error_m, error_m)


def _plain(value: float) -> float | None:
    return value if np.isfinite(value) else None


TELLS = 0.8
"""Largest share of an axis' error that remains without this for it to be reported."""
ROUNDED = "Home itself is rounded to whole microsteps: up to {:.2f} mm of that are in {}."


def said_of_home(run: Run, robot: RobotFile, tracking: RunTracking) -> str:
    """One line where the truth of a simulated run is off by that; empty where it is not."""
    truth = tracking.truth
    if truth is None or isinstance(robot.drive, ServoDrive) or not len(run.targets.t_ns):
        return ""
    moved_m = moved_by_home_m(run, robot)
    mean_m = moved_m.mean(axis=0)
    errors_m = truth.error_m[np.isfinite(truth.error_m).all(axis=1)]
    if not len(errors_m):
        return ""
    left_m, all_m = (np.sqrt(np.mean(x**2, axis=0)) for x in (errors_m - mean_m, errors_m))
    told = [axis for axis, less in zip(AXES, left_m < TELLS * all_m, strict=True) if less]
    if not told:
        return ""
    most = max(told, key=lambda axis: abs(mean_m[AXES.index(axis)]))
    return ROUNDED.format(1e3 * float(np.abs(moved_m[:, AXES.index(most)]).max()), most)


def moved_by_home_m(run: Run, robot: RobotFile) -> FloatArray:
    """Offset of the platform at each target, (n, 3), as home is between two counts."""
    home_rad = np.deg2rad(robot.homing.angle_deg)
    off_steps = home_rad / robot.drive.rad_per_step - np.array(home_counts(robot))
    asked = asked_path(run, robot)
    counts = asked.targets.steps[arrivals(asked)]
    there_m = positions_of_counts(robot, counts)
    moved: FloatArray = positions_of_counts(robot, counts + off_steps) - there_m
    return moved
