"""What the next run would tell, and what no run can, in words."""

from __future__ import annotations

import math
from collections.abc import Sequence

from deltactl.diagnosis.answer.records import Diagnosis, OpenTie
from deltactl.diagnosis.report.phrases import words
from deltactl.diagnosis.report.phrases.sureness import CHI_SQUARE
from deltactl.diagnosis.report.sentences.telling_apart import measurement

NEEDS_DRIVE = "A run that tells them apart needs `drive` in the robot file."


def experiment_line(diagnosis: Diagnosis) -> str:
    """The next experiment in one sentence."""
    plan = diagnosis.next_experiment
    if plan is None:
        return ""
    apart = words.listed([words.spelled(name) for name in plan.tells_apart])
    minutes = _minutes(plan.minutes) if math.isfinite(plan.minutes) else "some minutes"
    gain = plan.expected_delta_chi2
    expected = f" (expected difference {gain:.0f} in {CHI_SQUARE})" if math.isfinite(gain) else ""
    one_sided = any(tie.minutes is None and not tie.needs_drive for tie in diagnosis.open_ties)
    would = "may" if one_sided else "would"
    return words.sentence(f"a run of {minutes} {would} tell apart {apart or 'them'}{expected}")


def _minutes(minutes: float) -> str:
    shown = f"{minutes:.2g}"
    return "1 minute" if shown == "1" else f"{shown} minutes"


def tie_lines(diagnosis: Diagnosis) -> list[str]:
    """What stays open whatever runs, and what helps then."""
    lines = [tie_line(tie) for tie in diagnosis.open_ties]
    return list(dict.fromkeys(lines))


def tie_line(tie: OpenTie) -> str:
    """One pair of explanations that a run tells apart on one condition, or not at all."""
    if tie.needs_drive:
        return NEEDS_DRIVE
    one, other = (_names(side) for side in (tie.one, tie.other))
    helps = measurement(frozenset(name.split(" ")[0] for name in (*tie.one, *tie.other)))
    if tie.minutes is not None:
        longest = f"not even one of {_minutes(tie.minutes)}"
        return f"No safe run, {longest}, can tell {one} from {other}. Instead: {helps}."
    return (
        f"If the cause is {one}, the proposed run will tell; "
        f"if it is {other}, both will still fit: then {helps}."
    )


def _names(side: Sequence[str]) -> str:
    """'effect component' names as noun phrases; one effect at several places once."""
    parts: dict[str, list[str]] = {}
    for name in side:
        effect, _, component = name.partition(" ")
        parts.setdefault(effect, []).append(component)
    return words.listed([words.effect(effect, *places) for effect, places in parts.items()])
