"""One table: a row a figure, a column a tool; what a tool cannot do is a dash with its reason."""

from __future__ import annotations

from collections.abc import Mapping, Sequence

import numpy as np

from benchmarks.rivals.cases import Scored
from deltactl.proof.prove.reliability import wilson

DASH = "-"
REASONS = {
    ("textbook", "commanded"): "textbook: needs a column of effort; commanded axes are left out",
    ("PySINDy", "coverage"): "PySINDy: STLSQ states no intervals",
}
WAVES = {"transmission_error", "encoder_error"}
EVENTS = {"lost_steps", "joint_compliance", "speed_limit", "effort_limit", "stribeck_friction"}
OUTSIDE_THE_LIST = {
    ("lmfit", "commanded"): {*WAVES, *EVENTS, "resonance"},
    ("lmfit", "effort"): EVENTS,
    ("PySINDy", "commanded"): {*WAVES, *EVENTS},
    ("PySINDy", "effort"): {*EVENTS, "effort_gain", "following_lag"},
    ("textbook", "effort"): {*EVENTS, "effort_gain", "following_lag"},
}
"""Effects that the written protocol of a tool has no name for."""


def share(hits: Sequence[bool]) -> str:
    """Hits of all and the 95 % limits of the share."""
    if not hits:
        return DASH
    low, high = wilson(sum(hits), len(hits))
    return f"{sum(hits)} of {len(hits)} [{low:.2f}, {high:.2f}]"


def middle(values: Sequence[float], digits: int = 2) -> str:
    """Median of the finite values."""
    finite = [value for value in values if np.isfinite(value)]
    return f"{np.median(finite):.{digits}f}" if finite else DASH


def in_list(tool: str, own: Scored) -> bool:
    """Whether the protocol of a tool has a name for all that is hidden."""
    return not OUTSIDE_THE_LIST.get((tool, own.marks.machine), set()) & set(own.marks.truth)


def column(tool: str, answers: Sequence[Scored], peak_mb: float) -> dict[str, str]:
    """Every figure of one tool."""
    rows: dict[str, str] = {}
    for machine, title in (("commanded", "commanded"), ("effort", "with effort")):
        own = [one for one in answers if one.marks.machine == machine]
        faulty = [one for one in own if one.marks.truth]
        healthy = [one for one in own if not one.marks.truth]
        rows |= {
            f"names right, {title}": share([one.right for one in faulty]),
            f"... of what its list has, {title}": share(
                [one.right for one in faulty if in_list(tool, one)]
            ),
            f"false claims on healthy axes, {title}": share([one.marks.alarmed for one in healthy]),
            f"coverage of 95 % intervals, {title}": share(
                [hit for one in faulty for hit in one.marks.covered]
            ),
        }
    return rows | {
        "held-out error over noise, commanded": middle([one.heldout_over_noise for one in answers]),
        "seconds, median": middle([one.seconds for one in answers]),
        "memory, peak, MB": f"{peak_mb:.0f}",
    }


def markdown(columns: Mapping[str, Mapping[str, str]]) -> str:
    """The table, and below it why there are dashes."""
    figures = list(dict.fromkeys(name for rows in columns.values() for name in rows))
    lines = [f"| | {' | '.join(columns)} |", "|---" * (len(columns) + 1) + "|"]
    for figure in figures:
        cells = [rows.get(figure, DASH) for rows in columns.values()]
        lines.append(f"| {figure} | {' | '.join(cells)} |")
    return "\n".join(lines) + "\n\n" + notes(columns)


def notes(columns: Mapping[str, Mapping[str, str]]) -> str:
    """Reasons of the dashes that are in the table, and what the figures leave out."""
    lines = [
        reason
        for (tool, part), reason in REASONS.items()
        if any(part in figure and cell == DASH for figure, cell in columns.get(tool, {}).items())
    ]
    lines += [
        "held-out error of axes with effort is left out: each tool has its own low-pass",
        "names right: all hidden effects and nothing needless; what an ideal observer cannot "
        "separate counts, an alternative does not",
    ]
    return "".join(f"- {line}\n" for line in lines)


def wrong(tool: str, answers: Sequence[Scored]) -> str:
    """What a tool named otherwise, one line an axis."""
    lines = []
    for one in answers:
        marks = one.marks
        if one.right if marks.truth else not marks.alarmed:
            continue
        truth, said = ", ".join(marks.truth) or "nothing", ", ".join(marks.said) or "nothing"
        about = f"{marks.tier}, {marks.machine}"
        lines.append(f"- {tool}, {marks.case} ({about}): {truth} -> {marks.failure or said}\n")
    return "".join(lines)
