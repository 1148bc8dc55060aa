"""Any models on the paper's curves and speeds, on the as-built robot."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np

from deltactl.firmware_py.robot_file import RobotFile
from deltactl.foundation.errors import RecordingError
from deltactl.models.robot import FloatArray
from deltactl.models.training.dataset import DataSet
from deltactl.reproduction.outcome import Sheet
from deltactl.reproduction.zhao_2023.as_built import AsBuiltFile, machine_of
from deltactl.reproduction.zhao_2023.tables import metres
from deltactl.reproduction.zhao_2023.tracking import CURVES, T_PWM_S, TITLES, follow, rms_m, targets

Angles = Callable[[FloatArray], FloatArray]


@dataclass(frozen=True)
class Row:
    """One run: RMS errors per axis [m]; None where the model has no answer for the curve."""

    curve: str
    model: str
    t_pwm_s: float
    seen_m: FloatArray | None
    true_m: FloatArray | None

    def as_json(self) -> dict[str, Any]:
        """Plain types."""
        return {
            "curve": self.curve,
            "model": self.model,
            "t_pwm_s": self.t_pwm_s,
            "rms_by_sensors_m": None if self.seen_m is None else self.seen_m.tolist(),
            "rms_true_m": None if self.true_m is None else self.true_m.tolist(),
        }


def check_same(data: DataSet, built: AsBuiltFile, path: Path) -> None:
    """Raise RecordingError when the data are of a robot that was built otherwise."""
    if data.settings.machine == "as-built" and data.settings.as_built != built.mark:
        raise RecordingError(
            f"{data.folder}: is of the as-built robot '{data.settings.as_built}', and {path} now "
            f"is '{built.mark}'; collect again, or name the file the data were taken with"
        )


def evaluate(
    models: dict[str, Angles], robot: RobotFile, built: AsBuiltFile, part: float, say: Any
) -> list[Row]:
    """All models on three curves at four speeds; `part` of each curve is followed."""
    assert robot.sensors is not None
    machine, rows = machine_of(built, robot), []
    low, high = np.radians(robot.limits.arm_deg) / robot.drive.rad_per_step
    for curve in CURVES:
        whole_m = targets(curve)
        target_m = whole_m[: int(np.ceil(part * len(whole_m)))]
        for name, angles in models.items():
            steps = angles(target_m) / robot.drive.rad_per_step
            for t_pwm_s in T_PWM_S:
                say(f"{curve}, {name}, T_PWM {t_pwm_s:g} s")
                if not np.isfinite(steps).all():
                    rows.append(Row(curve, name, t_pwm_s, None, None))
                    continue
                counts = np.rint(np.clip(steps, low, high)).astype(np.int64)
                rng = np.random.default_rng([CURVES.index(curve), round(1e4 * t_pwm_s)])
                track = follow(machine, robot.sensors, target_m, counts, t_pwm_s, rng)
                rows.append(
                    Row(curve, name, t_pwm_s, rms_m(track.seen_error_m), rms_m(track.true_error_m))
                )
    return rows


def sheet(rows: list[Row]) -> Sheet:
    """In the shape of the paper's Table 3."""
    lines = []
    for row in rows:
        seen = ["no answer"] * 3 if row.seen_m is None else metres(row.seen_m)
        true = ["no answer"] * 3 if row.true_m is None else metres(row.true_m)
        lines.append([TITLES[row.curve], row.model, f"{row.t_pwm_s:g}", *seen, *true])
    head = ["Curve", "Model", "T_PWM [s]", "e_x", "e_y", "e_z", "e_x true", "e_y true", "e_z true"]
    title = "RMS tracking errors on the as-built robot [m]: by its own sensors, and true"
    return Sheet(title, head, lines, 2)
