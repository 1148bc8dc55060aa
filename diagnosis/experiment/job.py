"""A motion as a job that `deltactl run` accepts (firmware_py/job_file.py)."""

from __future__ import annotations

from typing import Any

from diagnosis.experiment.motions import Motion


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
