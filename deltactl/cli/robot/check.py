"""`deltactl check`: what a job would do."""

from __future__ import annotations

from pathlib import Path

from deltactl.cli.output import console, duration, facts, millimetres, print_json, say, warn
from deltactl.cli.robot.judged import (
    error_judged,
    errors_from,
    margin_judged,
    rate,
    size_m,
    too_coarse,
)
from deltactl.firmware_py.feedback.feedback import farthest_m as farthest_m_of
from deltactl.firmware_py.named_files import JOB_KEY, ROBOT_KEY, find
from deltactl.firmware_py.planner.check import home_counts
from deltactl.firmware_py.planner.summary import CheckSummary
from deltactl.firmware_py.program.dry_run import program_of
from deltactl.firmware_py.program.instructions import Program
from deltactl.firmware_py.program.totals import summarise_program
from deltactl.firmware_py.robot_file import load_robot
from deltactl.models.robot import AXES, FloatArray
from deltactl.repair.coverage import Coverage, coverage_of
from deltactl.repair.limit import Limit
from deltactl.repair.program_limit import limit_of_program, microstep_m


def check_job(job: Path, robot: str | None, json_out: bool) -> None:
    """Print the dry run. Raises any DeltactlError when the job must not run."""
    path = find(str(job), key=JOB_KEY)
    robot_file = None if robot is None else find(robot, key=ROBOT_KEY)
    program = program_of(path, None if robot_file is None else load_robot(robot_file))
    show_check(program, path, coverage_of(path, robot_file), json_out)


def show_check(program: Program, path: Path, covered: Coverage, json_out: bool = False) -> None:
    """Print what a program would do; path: of its job, beside which networks are sought."""
    summary = summarise_program(program, home_counts(program.robot))
    limit, farthest_m = limit_of_program(program, path), _farthest_m(program)
    moved_m = microstep_m(program)
    if json_out:
        print_json(
            summary.as_json()
            | {
                "effects": [one.as_json() for one in covered.effects],
                "warning": covered.warning or None,
                "too_coarse": too_coarse(summary.robot, moved_m, limit, size_m(summary)) or None,
                "limit": limit.as_json() if isinstance(limit, Limit) else None,
                "no_limit": limit if isinstance(limit, str) else None,
                "microstep_m": moved_m.tolist(),
                "feedback_moves_at_most_m": farthest_m,
            }
        )
        return
    path_m = size_m(summary)
    rows = [
        *_rows(summary, program.robot.limits.singularity_margin),
        *limit_rows(limit, path_m),
        *_single_steps(moved_m, limit),
    ]
    if farthest_m is not None:
        rows.append(("feedback", f"moves the platform by at most {millimetres(farthest_m)}"))
    coarse = too_coarse(summary.robot, moved_m, limit, path_m)
    title = f"{summary.job} may run" + (f", {coarse}" if coarse else "")
    console.print(facts(title, rows))
    say_covered(covered)
    if summary.slower is not None:
        warn(f"warning: {summary.slower.says()}")


def limit_rows(limit: Limit | str, path_m: float = 0.0) -> list[tuple[str, str]]:
    """The smallest error that is possible and its parts, or why it is not known.

    path_m: size of the path, which it is compared with; 0 where that is not known.
    """
    if isinstance(limit, str):
        return [("error at best", limit)]
    counted = millimetres(limit.counted_m)
    said = (
        f"{counted} RMS in x, y and z together{error_judged(limit.counted_m, path_m)}, as the row"
        " 'commanded' after a simulated run shows it"
    )
    if limit.sizes_m > 0.0 or limit.left_m > 0.0:
        evenly = millimetres(limit.rms_m)
        said += f"; {evenly} of it however evenly the motors turn ({errors_from(limit)})"
    return [("error at best", said)]


def _single_steps(moved_m: FloatArray, limit: Limit | str) -> list[tuple[str, str]]:
    """How large errors in the table after a run may be where nothing is wrong."""
    if isinstance(limit, str):
        return []
    each = ", ".join(
        f"{millimetres(size_m)} in {axis}" for axis, size_m in zip(AXES, moved_m, strict=True)
    )
    said = f"of all motors moves the platform by up to {each}: single errors up to that are normal"
    return [("one microstep", said)]


def _farthest_m(program: Program) -> float | None:
    """How far feedback may move the platform in any of the moves; None where it is off."""
    feedback = program.job.feedback
    if feedback is None:
        return None
    laps = [plan.first.lap for plan in program.plans()]
    return max(
        (farthest_m_of(program.robot, feedback, lap.angles_rad) for lap in laps), default=0.0
    )


def say_covered(covered: Coverage) -> None:
    """What is compensated, what is not and why; nothing where no effect is known."""
    for one in covered.effects:
        name = f"{one.effect} on {one.component}"
        if one.how:
            say(f"compensated: {name}, {one.how}")
        else:
            say(f"not compensated: {name}: {one.why_not}")
    if covered.warning:
        warn(f"warning: {covered.warning}")


def _steps(summary: CheckSummary) -> list[tuple[str, str]]:
    if summary.instructions is None:
        return []
    waits = duration(summary.waits_at_most_s)
    return [
        ("steps", f"{summary.instructions}"),
        *([("waits for inputs", f"{waits} at most")] if summary.waits_at_most_s else []),
        *([("pauses", f"{summary.pauses}, until 'deltactl resume'")] if summary.pauses else []),
    ]


def _rows(summary: CheckSummary, least_margin: float) -> list[tuple[str, str]]:
    rates = ", ".join(rate(hertz) for hertz in summary.peak_step_rate_hz)
    angles = ", ".join(f"{low:.1f} to {high:.1f}" for low, high in summary.arm_range_deg)
    box = ", ".join(f"{low * 1e3:z.0f} to {high * 1e3:z.0f}" for low, high in summary.box_m)
    repeats = f" in {summary.repeats} repeats" if summary.repeats > 1 else ""
    rows = [
        ("robot", summary.robot),
        ("inverse kinematics", summary.inverse_kinematics),
        ("timing", summary.timing),
        ("targets", f"{summary.targets_in_all}{repeats}"),
        *_steps(summary),
        ("path length", f"{summary.path_length_m:.3f} m"),
        (
            "duration",
            f"{duration(summary.duration_s)}, of which {duration(summary.approach_s)} to its start",
        ),
        ("mean speed", f"{summary.mean_speed_mps * 1e3:.2f} mm/s"),
        ("peak step rate", f"{rates} Hz"),
        ("arm angles", f"{angles} degrees"),
        ("platform box", f"{box} mm"),
        ("singularity margin", margin_judged(summary.smallest_margin, least_margin)),
    ]
    if summary.path_per_step_period_m is not None:
        rows.append(("path per T_PWM", f"{summary.path_per_step_period_m * 1e3:.5f} mm"))
    return rows
