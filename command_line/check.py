"""`deltactl check`: what a job would do."""

from __future__ import annotations

from pathlib import Path

from command_line.output import console, duration, facts, print_json
from firmware_py.planner.check import check_job as dry_run
from firmware_py.planner.summary import CheckSummary
from firmware_py.robot_file import find


def check_job(job: Path, json_out: bool) -> None:
    """Print the dry run. Raises any DeltactlError when the job must not run."""
    summary = dry_run(find(str(job)))
    if json_out:
        print_json(summary.as_json())
        return
    console.print(facts(f"{summary.job} may run", _rows(summary)))


def _rows(summary: CheckSummary) -> list[tuple[str, str]]:
    rates = ", ".join(f"{rate:.0f}" for rate in summary.peak_step_rate_hz)
    angles = ", ".join(f"{low:.1f} to {high:.1f}" for low, high in summary.arm_range_deg)
    box = ", ".join(f"{low * 1e3:.0f} to {high * 1e3:.0f}" for low, high in summary.box_m)
    rows = [
        ("robot", summary.robot),
        ("inverse kinematics", summary.inverse_kinematics),
        ("timing", summary.timing),
        ("targets", f"{summary.targets}, {summary.repeats} times"),
        ("path length", f"{summary.path_length_m:.3f} m"),
        ("duration", f"{duration(summary.duration_s)} ({duration(summary.approach_s)} approach)"),
        ("mean speed", f"{summary.mean_speed_mps * 1e3:.2f} mm/s"),
        ("peak step rate", f"{rates} Hz"),
        ("arm angles", f"{angles} degrees"),
        ("platform box", f"{box} mm"),
        ("singularity margin", f"{summary.smallest_margin:.2f}"),
    ]
    if summary.path_per_step_period_m is not None:
        rows.append(("path per T_PWM", f"{summary.path_per_step_period_m * 1e3:.5f} mm"))
    return rows
