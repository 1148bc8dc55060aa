"""A motion as a job that `deltactl run` accepts (firmware_py/job_file.py)."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import yaml

from diagnosis.answer.records import NextExperiment
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


def write_job(
    experiment: NextExperiment, path: Path, robot: Path, project: Path | None = None
) -> None:
    """Write the job for a robot file: in full, or by name beside the job or in `project`."""
    folder = robot.resolve().parent
    known = [path.resolve().parent, *([project.resolve()] if project else [])]
    job = {**experiment.job, "robot": robot.name if folder in known else str(robot.resolve())}
    head = (
        f"# Tells apart: {', '.join(experiment.tells_apart)}.\n"
        f"# {experiment.minutes:.1f} minutes, expected chi-square "
        f"{experiment.expected_delta_chi2:.0f}. Then diagnose both recordings together.\n"
    )
    body = yaml.safe_dump(job, sort_keys=False, allow_unicode=True, default_flow_style=None)
    path.write_text(head + body, encoding="utf-8")
