"""Whether a figure of a dry run is good, in words: how fine a robot is, how well its arms hold."""

from __future__ import annotations

from typing import NamedTuple

from deltactl.cli.output import millimetres
from deltactl.firmware_py.planner.summary import CheckSummary
from deltactl.models.robot import FloatArray
from deltactl.repair.limit import Limit


class Share(NamedTuple):
    """Up to so much of the path's size."""

    most: float
    word: str


SHARES = (
    Share(0.01, "good"),  # nobody sees it in a drawing: a pen's width on a sheet of paper
    Share(0.1, "coarse"),  # the shape is there, with visible steps or errors
)
TOO_COARSE = 0.1
"""Of the path's size: an error of a tenth of it makes another shape."""
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
    word = next((one.word for one in SHARES if share <= one.most), "")
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
            f"but not as it is drawn: errors of {wide(limit.rms_m)} are to be expected at best, and"
            f" the path is {wide(path_m)} wide"
        )
    return ""


def wide(size: float) -> str:
    """A length with as many digits as tell sizes apart."""
    return f"{size * 1e3:.3g} mm" if size < 1.0 else f"{size * 1e3:.0f} mm"


def errors_from(limit: Limit) -> str:
    """What the error at best is made of."""
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
