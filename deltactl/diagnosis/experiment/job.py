"""The proposed run as a job file that `deltactl run` accepts (firmware_py/job_file.py)."""

from __future__ import annotations

from pathlib import Path

import yaml

from deltactl.diagnosis.answer.records import NextExperiment
from deltactl.foundation.plain_file import write_whole


def write_job(
    experiment: NextExperiment, path: Path, robot: Path, project: Path | None = None
) -> None:
    """Write the job for a robot file: in full, or by name beside the job or in `project`."""
    folder = robot.parent.resolve()
    known = [path.resolve().parent, *([project.resolve()] if project else [])]
    job = {**experiment.job, "robot": robot.name if folder in known else str(folder / robot.name)}
    head = (
        f"# Tells apart: {', '.join(experiment.tells_apart)}.\n"
        f"# {experiment.minutes:.1f} minutes, expected chi-square "
        f"{experiment.expected_delta_chi2:.0f}. Then diagnose both recordings together.\n"
    )
    body = yaml.safe_dump(job, sort_keys=False, allow_unicode=True, default_flow_style=None)
    write_whole(path, head + body)
