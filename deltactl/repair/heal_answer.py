"""What a healing came to, in lines of text: for a terminal and for the page."""

from __future__ import annotations

import math
from pathlib import Path
from typing import Any

MOST_NAMED = 4
HEALED, IMPROVED, NOTHING = "healed", "improved", "nothing_to_heal"
BY_HAND, ROLLED_BACK, REFUSED = "needs_a_hand", "rolled_back", "refused"
KEPT = (HEALED, IMPROVED)
"""Outcomes with the corrected robot file in force."""
VERDICTS = {
    HEALED: "Healed: the corrected robot file is in force.",
    IMPROVED: "Better, but not healed: the corrected robot file is in force.",
    NOTHING: "Nothing to heal: no correction would change what the robot draws.",
    BY_HAND: "Not healed: nothing that was found can be corrected in the robot file.",
    ROLLED_BACK: "Not healed: the sensors do not show that the correction helps; the old robot"
    " file is in force.",
    REFUSED: "Not healed: the correction is refused; the old robot file is in force.",
}

UNSURE = "Better, but not sure to be healed: the corrected robot file is in force."
"""The first line where a size misses the goal and its interval does not."""


def if_kept(answer: dict[str, Any]) -> str:
    """The outcome where a correction helps for sure."""
    return IMPROVED if misses(answer) else HEALED


def if_nothing(answer: dict[str, Any]) -> str:
    """The outcome where no correction would change what is drawn."""
    return BY_HAND if misses(answer) else NOTHING


def misses(answer: dict[str, Any]) -> bool:
    """Whether the job is farther from its path than the goal: by the sensors where they tell, else
    by the findings.
    """
    if "goal_m" not in answer:  # a path in arm angles, which are commanded as they are
        return False
    goal_m = answer["goal_m"]
    low_m, high_m = answer.get("after_ci95_m", (0.0, math.inf))
    return bool(low_m > goal_m or (high_m > goal_m and answer["expected_m"] > goal_m))


def lines_of(answer: dict[str, Any], go_on: str, undo: str) -> list[str]:
    """The answer of a `Healer`; go_on and undo: what to do for that, a command or a button."""
    unsure = answer["outcome"] == IMPROVED and not _shown(answer)
    lines = [UNSURE if unsure else VERDICTS[answer["outcome"]]]
    if "why" in answer:
        lines.append(f"  {answer['why']}")
    lines += _goal(answer, go_on)
    lines += _drawn(answer)
    lines += _named("found:", answer["found"])
    lines += _named("corrected:", answer.get("corrected", []))
    if len(worth := answer.get("worth", [])) > 1:
        heading = f"what each repair alone would do to it, now {_mm(worth[0]['now_m'])} mm:"
        lines += _named(heading, [_worth(one) for one in worth])
    if readings := answer.get("readings"):
        heading = f"by readings as they were taken before, {_mm(readings[0]['now_m'])} mm; with:"
        lines += _named(heading, [_worth(one) for one in readings])
    lines += _named("done by hand since:", answer["done_by_hand"])
    work = [f"{one['says']}: {one['why']}" for one in answer["by_hand"]]
    lines += _named(f"needs a hand; then {go_on}:", work)
    lines.append(f"robot time {_minutes(answer['robot_s'])}, in all {_minutes(answer['took_s'])}")
    if answer["outcome"] in KEPT:
        lines.append(f"back to the file before: {undo}")
    return lines


def _goal(answer: dict[str, Any], go_on: str) -> list[str]:
    """The remaining error beside the goal, and the next step where the goal is missed."""
    if "goal_m" not in answer:
        return []
    low, high = (_mm(end) for end in answer["expected_ci95_m"])
    found = f"the findings leave {_mm(answer['expected_m'])} mm [{low}, {high}]"
    lines = [f"  goal {_mm(answer['goal_m'])} mm: {found}"]
    if answer["outcome"] in (IMPROVED, BY_HAND):
        lines.append(f"  next: {_next(answer, go_on)}")
    return lines


def _next(answer: dict[str, Any], go_on: str) -> str:
    if not _shown(answer):
        return f"sizes are not known well enough; {go_on} surveys again"
    if answer["by_hand"]:
        return "the work that needs a hand, below"
    return f"the cause of the rest was not found; {go_on} surveys again"


def _shown(answer: dict[str, Any]) -> bool:
    """Whether an interval, and not only a size, is beyond the goal."""
    ends_m = [answer[name][0] for name in ("after_ci95_m", "expected_ci95_m") if name in answer]
    return bool(max(ends_m) > answer["goal_m"])


def _drawn(answer: dict[str, Any]) -> list[str]:
    """Before and after, where the job was drawn."""
    if "before_rms_m" not in answer:
        return []
    times = answer["drawings"]
    low, high = (1e6 * square for square in answer["gain_ci95_m2"])
    return [
        f"{Path(answer['job']).name}, RMS distance from its path by the sensors, 95 % intervals"
        f"{f', {times} drawings each' if times > 1 else ''}:",
        *(f"  {name:<7} {_size(answer, name)}" for name in ("before", "after")),
        f"  paired over the path: mean square smaller by {1e6 * answer['gain_m2']:.3g} mm2"
        f" [{low:.3g}, {high:.3g}]",
    ]


def _named(heading: str, items: list[str]) -> list[str]:
    if not items:
        return []
    more = [f"  - and {len(items) - MOST_NAMED} more"] if len(items) > MOST_NAMED else []
    return [heading, *(f"  - {item}" for item in items[:MOST_NAMED]), *more]


def _worth(one: dict[str, Any]) -> str:
    low, high = one["ci95_m"]
    return (
        f"{one['effect']} on {one['component']}: {_mm(one['alone_m'])} mm"
        f" [{_mm(low)}, {_mm(high)}], {one['share']:.0%} less"
    )


def _size(answer: dict[str, Any], name: str) -> str:
    low, high = answer[f"{name}_ci95_m"]
    return f"{_mm(answer[f'{name}_rms_m'])} mm  [{_mm(low)}, {_mm(high)}]"


def _mm(value_m: float) -> str:
    return f"{value_m * 1e3:.2f}"


def _minutes(seconds: float) -> str:
    minutes, rest = divmod(round(seconds), 60)
    return f"{minutes} min {rest:02d} s" if minutes else f"{rest} s"
