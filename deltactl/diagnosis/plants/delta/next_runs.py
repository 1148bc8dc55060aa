"""The runs that a delta robot may do next, each as the engine would see it."""

from __future__ import annotations

from collections.abc import Iterable
from typing import Any

import numpy as np

from deltactl.diagnosis.observations.options import OBSERVATIONS
from deltactl.diagnosis.observations.readings import FloatArray
from deltactl.diagnosis.plants.delta.model import DeltaModel
from deltactl.diagnosis.plants.delta.motions import Motion, motions
from deltactl.diagnosis.plants.delta.options import NEXT_RUNS
from deltactl.diagnosis.plants.delta.safe_poses import MotionLimits
from deltactl.models.linkage import Linkage
from deltactl.recording.tables.flat import FlatRecording


class DeltaRun:
    """One repeat of a motion, straight moves through arm angles, that the machine may safely do.

    model: the machine in this motion, nothing read yet (all readings 0).
    """

    def __init__(self, motion: Motion, recorded: DeltaModel):
        assert recorded.robot.drive is not None
        step, readings = recorded.robot.drive.rad_per_step, recorded.readings
        self.motion = motion
        self.period_s = max(readings.period_s, NEXT_RUNS.shortest_period_s)
        self.minutes = duration_s(motion, step) / 60.0
        blank = as_recording(motion, step, self.period_s, readings.names)
        self.model = DeltaModel(recorded.robot, [blank])

    def holds_together(self, predicted: FloatArray) -> bool:
        """Whether the machine can be assembled all along a prediction (n, c): the model puts zeros
        where it cannot.
        """
        metres = [i for i, unit in enumerate(self.model.readings.units) if unit == "m"]
        return not metres or bool(predicted[:, metres].any(axis=1).all())

    def job(self, repeats: int) -> dict[str, Any]:
        """For `<name of the recorded robot>.yaml`."""
        return job_of(self.motion, self.model.robot.name, repeats)


def next_runs(
    recorded: DeltaModel, limits: MotionLimits | None, components: Iterable[str]
) -> list[DeltaRun] | None:
    """Every motion of the table that is safe, those of single arms for the components in question.

    recorded: the recording that left something open. None where the robot file has no drive.
    """
    drive = recorded.robot.drive
    if drive is None:
        return None
    about = {int(name[-1]) - 1 for name in components if name[-1] in "123"}
    linkage, limits = Linkage.of(recorded.robot.geometry), limits or MotionLimits()
    table = motions(linkage, limits, drive.rad_per_step, _top_speed(recorded), about)
    return [DeltaRun(motion, recorded) for motion in table]


def job_of(motion: Motion, robot: str, repeats: int) -> dict[str, Any]:
    """The job as plain data. robot: name of the recorded robot, its file is `<name>.yaml`."""
    return {
        "name": f"tell-apart-{motion.name}",
        "robot": f"{robot}.yaml",
        "path": {
            "shape": "joints",
            "angles_deg": [[float(angle) for angle in pose] for pose in motion.angles_deg],
            "dwell_s": motion.dwell_s,
        },
        "timing": {"mode": "together", "t_pwm_s": motion.t_pwm_s},
        "inverse_kinematics": {"kind": "geometry"},
        "repeats": repeats,
    }


def _top_speed(model: DeltaModel) -> float:
    """Highest joint speed of the recording [rad/s], single glitches aside."""
    readings = model.readings
    speed = np.abs(np.diff(model.commanded_rad, axis=0)) / np.diff(readings.t_s)[:, None]
    return float(np.quantile(speed.max(axis=1), OBSERVATIONS.top_speed_quantile))


def duration_s(motion: Motion, rad_per_step: float) -> float:
    """How long one repeat takes [s]."""
    return float(_corners(motion, rad_per_step)[0][-1])


def commanded(
    motion: Motion, rad_per_step: float, period_s: float
) -> tuple[FloatArray, FloatArray]:
    """Times (n,) [s] every `period_s` and commanded counts (n, 3) of one repeat."""
    at_s, counts = _corners(motion, rad_per_step)
    t_s = np.arange(0.0, at_s[-1] + NEXT_RUNS.readings_after_s, period_s)
    return t_s, np.stack([np.rint(np.interp(t_s, at_s, column)) for column in counts.T], axis=1)


def as_recording(
    motion: Motion, rad_per_step: float, period_s: float, channels: tuple[str, ...]
) -> FlatRecording:
    """A recording of one repeat in which nothing was read yet (all readings 0)."""
    t_s, counts = commanded(motion, rad_per_step, period_s)
    columns = {f"steps_{motor + 1}": counts[:, motor] for motor in range(3)}
    columns |= {name: np.zeros(len(t_s)) for name in channels}
    return FlatRecording(t_s, columns, {}, motion.name)


def _corners(motion: Motion, rad_per_step: float) -> tuple[FloatArray, FloatArray]:
    """Times at which moves begin and end, and the counts there: all motors step together, one tick
    every T_PWM (Zhao 2023).
    """
    counts = np.rint(motion.angles_rad / rad_per_step)
    ticks = np.abs(np.diff(counts, axis=0)).max(axis=1)
    moves_s = ticks * motion.t_pwm_s
    arrive = np.concatenate(
        [[0.0], np.cumsum(moves_s) + motion.dwell_s * np.arange(1, len(counts))]
    )
    leave = arrive + motion.dwell_s
    at_s = np.stack([arrive, leave], axis=1).ravel()
    return at_s + 1e-9 * np.arange(len(at_s)), np.repeat(counts, 2, axis=0)
