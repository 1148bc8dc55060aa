"""One table: a row a figure, a column a tool; what a tool cannot do is a dash with its reason."""

from __future__ import annotations

from collections.abc import Mapping, Sequence

import numpy as np

from benchmarks.rivals.cases import Scored
from deltactl.proof.prove.reliability import wilson
from deltactl.proof.prove.table import gathered

DASH = "-"
TOLD = "sysid, true set"
"""A tool that is given the names finds none."""
REASONS = {
    ("textbook", "commanded"): "textbook: needs a column of effort; other axes are left out",
    ("PySINDy", "intervals"): "PySINDy: STLSQ states no sizes with intervals",
    (
        "sysid, true set",
        "names right",
    ): "sysid, true set: is given the names; healthy machines, and what "
    "its list has not, are left out",
    ("sysid, all", "commanded"): "sysid: a commanded axis has no effort, and the errors of its "
    "kinematics are no parameters of bodies",
    ("sysid, all", "held-out"): "sysid: held-out recordings were not simulated",
    ("PySINDy", "in range"): "PySINDy: its terms are shares of a motion, no sizes of parts",
}
WAVES = {"transmission_error", "encoder_error"}
EVENTS = {"lost_steps", "joint_compliance", "speed_limit", "effort_limit", "stribeck_friction"}
OTHER_DELTAS = (
    {"joint_friction", "viscous_friction", "joint_compliance", "transmission_error", "lost_steps"}
    | {"frame_tilt", "thermal_expansion", "contact", "resonance"}
    | {"sensor_crosstalk", "sensor_drift", "stale_reading"}
)
OUTSIDE_THE_LIST = {
    ("lmfit", "commanded"): {*WAVES, *EVENTS, "resonance"},
    ("lmfit", "with effort"): EVENTS,
    ("lmfit", "real recordings"): {*WAVES, *EVENTS, "resonance"},
    ("PySINDy", "commanded"): {*WAVES, *EVENTS},
    ("PySINDy", "with effort"): {*EVENTS, "effort_gain", "following_lag"},
    ("PySINDy", "real recordings"): {*WAVES, *EVENTS, "effort_gain"},
    ("lmfit", "deltas"): OTHER_DELTAS,
    ("Klipper", "deltas"): OTHER_DELTAS
    | {"gear_ratio", "upper_arm_length", "following_lag", "gear_backlash", "sensor_offset"}
    | {"sensor_scale", "sensor_latency"},
    ("sysid, all", "deltas"): OTHER_DELTAS | {"following_lag", "sensor_scale", "sensor_latency"},
    ("sysid, all", "with effort"): {*EVENTS, "effort_gain"},
    ("FIGAROH", "arms"): {"effort_gain", "following_lag"},
    ("textbook", "with effort"): {*EVENTS, "effort_gain", "following_lag"},
    ("textbook", "real recordings"): {*EVENTS, "effort_gain"},
    ("sysid, all", "real recordings"): {*EVENTS, "effort_gain"},
}
"""Effects that the written protocol of a tool has no name for."""


def share(hits: Sequence[bool | None]) -> str:
    """Hits of all that are no None, and the 95 % limits of the share."""
    known = [hit for hit in hits if hit is not None]
    if not known:
        return DASH
    low, high = wilson(sum(known), len(known))
    return f"{sum(known)} of {len(known)} [{low:.2f}, {high:.2f}]"


def middle(values: Sequence[float], digits: int = 2) -> str:
    """Median of the finite values."""
    finite = [value for value in values if np.isfinite(value)]
    return f"{np.median(finite):.{digits}f}" if finite else DASH


def in_list(tool: str, own: Scored) -> bool:
    """Whether the protocol of a tool has a name for all that is hidden."""
    hidden = {name.split()[0] for name in own.truth}
    return not OUTSIDE_THE_LIST.get((tool, own.group), set()) & hidden


def column(tool: str, answers: Sequence[Scored], peak_mb: float) -> dict[str, str]:
    """Every figure of one tool."""
    rows: dict[str, str] = {}
    for group in dict.fromkeys(one.group for one in answers):
        rows |= _rows(tool, group, [one for one in answers if one.group == group])
    return rows | {
        "processor seconds, median": middle([one.seconds for one in answers]),
        "memory of a case, peak, MB": f"{peak_mb:.0f}",
    }


def _rows(tool: str, group: str, own: Sequence[Scored]) -> dict[str, str]:
    faulty = [one for one in own if one.truth]
    found = [] if tool == TOLD else faulty
    listed = [one for one in found if in_list(tool, one)]
    false, sizes = "false claims on healthy machines", "95 % intervals that hold"
    if group.startswith("real"):
        false, sizes = "false claims", "sizes in range"
    over_bound = gathered(own, lambda one: one.over_bound)
    rows = {
        "names right": share([one.right for one in found]),
        "... of what its list has": share([one.right for one in listed]),
        "... by findings alone": share([one.outright for one in faulty]),
        false: share([one.false for one in own]),
        sizes: share(gathered(own, lambda one: one.sizes)),
        "intervals: size errors over Cramer-Rao, median": middle(over_bound),
        "intervals of two halves agree": share(gathered(own, lambda one: one.agree)),
        "held-out error over noise": middle([one.heldout_over_noise for one in own]),
    }
    return {f"{figure}, {group}": value for figure, value in rows.items()}


def markdown(columns: Mapping[str, Mapping[str, str]]) -> str:
    """The table, and below it why there are dashes; a figure that no tool has is left out."""
    figures = list(dict.fromkeys(name for rows in columns.values() for name in rows))
    lines = [f"| | {' | '.join(columns)} |", "|---" * (len(columns) + 1) + "|"]
    for figure in figures:
        cells = [rows.get(figure, DASH) for rows in columns.values()]
        if any(cell != DASH for cell in cells):
            lines.append(f"| {figure} | {' | '.join(cells)} |")
    return "\n".join(lines) + "\n\n" + notes(columns)


def notes(columns: Mapping[str, Mapping[str, str]]) -> str:
    """Reasons of the dashes that are in the table, and what the figures leave out."""
    figures = {name for rows in columns.values() for name in rows}
    lines = [
        reason
        for (tool, part), reason in REASONS.items()
        if tool in columns
        and any(part in name and columns[tool].get(name, DASH) == DASH for name in figures)
    ]
    lines += [
        "held-out error of axes with effort and of arms is left out: each has its own low-pass",
        "of arms no Cramer-Rao bound is known: what their drawings leave open is no noise",
        "names right, of drawn machines: all hidden effects and nothing needless; what an ideal "
        "observer cannot separate counts, an alternative does not; of real ones: all known effects "
        "and nothing that must not be claimed",
        "an efficient estimator has a median size error of 0.67 over Cramer-Rao",
    ]
    return "".join(f"- {line}\n" for line in lines)


def wrong(tool: str, answers: Sequence[Scored]) -> str:
    """What a tool named otherwise, one line a case."""
    lines = []
    for one in answers:
        if not one.false and (one.right or not one.truth):
            continue
        truth, said = ", ".join(one.truth) or "nothing", ", ".join(one.said) or "nothing"
        lines.append(f"- {tool}, {one.case} ({one.group}): {truth} -> {one.failure or said}\n")
    return "".join(lines)
