"""`deltactl check`: what a job would do, and whether its figures are good, in words."""

from __future__ import annotations

from pathlib import Path
from typing import NamedTuple

from deltactl.cli.output import console, duration, facts, millimetres, print_json, say, warn
from deltactl.firmware_py.feedback.feedback import farthest_m as farthest_m_of
from deltactl.firmware_py.named_files import JOB_KEY, ROBOT_KEY, find
from deltactl.firmware_py.planner.plan import home_counts
from deltactl.firmware_py.planner.summary import CheckSummary
from deltactl.firmware_py.program.coverage import Coverage, coverage
from deltactl.firmware_py.program.instructions import Program
from deltactl.firmware_py.program.totals import program_of, summarise_program
from deltactl.firmware_py.robot_file import load_robot
from deltactl.models.robot import AXES, FloatArray
from deltactl.repair.limit import Limit, limit_of_program, microstep_m


def check_job(job: Path, robot: str | None, json_out: bool) -> None:
    """Print the dry run. Raises any DeltactlError when the job must not run."""
    path = find(str(job), key=JOB_KEY)
    robot_file = None if robot is None else find(robot, key=ROBOT_KEY)
    program = program_of(path, None if robot_file is None else load_robot(robot_file))
    where = find(program.job.robot, beside=path) if robot_file is None else robot_file
    show_check(program, path, coverage(program.job, program.robot, path, where), json_out)


def show_check(program: Program, path: Path, covered: Coverage, json_out: bool = False) -> None:
    """Print what a program would do; path: of its job, beside which networks are sought."""
    summary = summarise_program(program, home_counts(program.robot))
    limit, farthest_m = limit_of_program(program, path), _farthest_m(program)
    moved_m = microstep_m(program)
    if json_out:
        print_json(
            summary.as_json()
            | {
                "effects": [effect.as_json() for effect in covered.effects],
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
    """The error to expect of a robot as its file says, and its parts, or why it is not known.

    With what the row 'commanded' of a run shows. path_m: size of the path, which it is
    compared with; 0 where that is not known.
    """
    if isinstance(limit, str):
        return [("expected error", limit)]
    corrected = limit.sizes_m > 0.0 or limit.left_m > 0.0
    size_m = limit.rms_m if corrected else limit.counted_m
    said = f"{millimetres(size_m)} RMS in x, y and z together{error_judged(size_m, path_m)}"
    if corrected:
        said += f": {errors_from(limit)}; the row 'commanded' of a run shows "
        said += f"{millimetres(limit.counted_m)}, for whole steps"
    else:
        said += ", as the row 'commanded' of a run shows it"
    return [("expected error", said)]


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
    for effect in covered.effects:
        name = f"{effect.effect} on {effect.component}"
        if effect.how:
            say(f"compensated: {name}, {effect.how}")
        else:
            say(f"not compensated: {name}: {effect.why_not}")
    if covered.warning:
        warn(f"warning: {covered.warning}")


def _steps(summary: CheckSummary) -> list[tuple[str, str]]:
    if summary.instructions is None:
        return []
    waits = duration(summary.waits_at_most_s)
    return [
        ("steps", f"{summary.instructions}"),
        *([("waits for inputs", f"{waits} at most")] if summary.waits_at_most_s else []),
        *([("pauses", f"{summary.pauses}, until 'deltactl job resume'")] if summary.pauses else []),
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


class Share(NamedTuple):
    """Up to so much of the path's size."""

    most: float
    word: str


SHARES = (
    Share(0.01, "good"),  # nobody sees it in a drawing: a pen's width on a sheet of paper
    Share(0.1, "coarse"),  # the shape is there, with visible steps or errors
)
TOO_COARSE = 0.1
"""Share of the path's size: an error of a tenth of it makes another shape."""
GOOD_MARGIN = 0.2
"""A sine: below it, play and errors of an arm reach the platform more than five times as large."""


def size_m(summary: CheckSummary) -> float:
    """The largest side of the box around the path [m]; 0 for a path of one place."""
    return max(high - low for low, high in summary.box_m)


def error_judged(rms_m: float, path_m: float) -> str:
    """How an error compares with the path; empty where the path has no size."""
    if path_m <= 0.0:
        return ""
    share = rms_m / path_m
    word = next((allowed.word for allowed in SHARES if share <= allowed.most), "")
    if not word:
        return f" (too coarse for a path of {wide(path_m)})"
    percent = "less than 1 %" if share <= SHARES[0].most else f"{100.0 * share:.2g} %"
    return f" ({word}: {percent} of the path's {wide(path_m)})"


def too_coarse(robot: str, moved_m: FloatArray, limit: Limit | str, path_m: float) -> str:
    """Why a job may run and yet not be drawn, to be said first; empty where it can be."""
    if isinstance(limit, str) or path_m <= 0.0:
        return ""
    step_m = float(moved_m.max())
    if step_m >= TOO_COARSE * path_m:
        return (
            f"but {robot} is too coarse for it: one microstep moves the platform by up to"
            f" {wide(step_m)}, and the path is {wide(path_m)} wide. Look at microsteps_per_rev and"
            " gear_ratio in the robot file"
        )
    if limit.rms_m >= TOO_COARSE * path_m:
        return (
            f"but not as it is drawn: errors of {wide(limit.rms_m)} are to be expected, and"
            f" the path is {wide(path_m)} wide"
        )
    return ""


def wide(size: float) -> str:
    """A length with as many digits as tell sizes apart."""
    return f"{size * 1e3:.3g} mm" if size < 1.0 else f"{size * 1e3:.0f} mm"


def errors_from(limit: Limit) -> str:
    """What the expected error is made of."""
    parts = {
        "whole microsteps": limit.steps_m,
        "how well the sizes of the compensated effects are known": limit.sizes_m,
        "what is not compensated": limit.left_m,
    }
    there = {why: size for why, size in parts.items() if size > 0.0}
    if len(there) == 1:
        return f"all of it from {next(iter(there))}"
    return ", ".join(f"{millimetres(size)} from {why}" for why, size in there.items())


def margin_judged(margin: float, least: float) -> str:
    """How well the arms hold the platform where they hold it worst."""
    word = "good" if margin >= GOOD_MARGIN else "low"
    return (
        f"{margin:.2f} ({word}: 1 is best, near 0 the arms do not hold the platform, below"
        f" {least:g} a job is refused)"
    )


def rate(hertz: float) -> str:
    """Steps a second; a slow motor's are not rounded away."""
    return f"{hertz:.0f}" if hertz >= 10.0 or hertz == 0.0 else f"{hertz:.2g}"
