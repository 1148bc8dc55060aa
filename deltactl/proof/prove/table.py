"""The table of the proof: every figure with its limits, its number of cases and its goal."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from operator import attrgetter
from typing import TypeVar

import numpy as np

from deltactl.proof.prove.reliability import (
    Claim,
    calibration_error,
    median_limits,
    sure_claims,
    wilson,
)
from deltactl.proof.prove.score import Score

Marks = TypeVar("Marks")
Part = TypeVar("Part")
FIRST, OFFERED, EXACT = attrgetter("first_right"), attrgetter("offered"), attrgetter("exact")
ROBUST = 0.6745
"""Median of |error| over the standard deviation of a normal error."""
EVENT_S = 0.1
CLEAR = 5.0


@dataclass(frozen=True)
class Row:
    """One figure. `met` is None where there was no case."""

    figure: str
    goal: str
    value: str
    limits: str
    cases: int
    met: bool | None


def table(scores: Sequence[Score]) -> list[Row]:
    """All rows, with the splits that explain them below."""

    def of(*groups: str) -> list[Score]:
        return [s for group in groups for s in scores if s.group == group]

    over_bound = gathered(of("single", "faint"), lambda s: s.over_bound)
    sized = of("single", "faint", "two", "three", "tolerance")
    # Build tolerances leave an error that is no cause: only clean machines reach the floor.
    clean = of("nothing", "single", "faint", "two", "three")
    floors = [s.holdout_over_floor for s in clean if np.isfinite(s.holdout_over_floor)]
    return [
        share("false alarms, nothing missing", of("nothing"), lambda s: s.alarmed, 0.01, "most"),
        share("... in surveys", _surveys(of("nothing")), lambda s: s.alarmed),
        share("... on curves only", _curves(of("nothing")), lambda s: s.alarmed),
        share("single, moderate: named first", of("single"), FIRST, 0.98),
        share("... in surveys", _surveys(of("single")), FIRST),
        share("... on curves only", _curves(of("single")), FIRST),
        share("... or among the alternatives", of("single"), OFFERED),
        share("... of those that could be seen: named first", _clear(of("single")), FIRST),
        share("single, a third: named first", of("faint"), FIRST, 0.92),
        share("single, a third: in findings or alternatives", of("faint"), OFFERED, 0.98),
        share("... of those that could be seen: named first", _clear(of("faint")), FIRST),
        share("two effects: exactly those", of("two"), EXACT, 0.95),
        share("... all in findings or alternatives", of("two"), OFFERED),
        share("three effects: exactly those", of("three"), EXACT, 0.90),
        share("... all in findings or alternatives", of("three"), OFFERED),
        share("one culprit among tolerances: first", of("tolerance"), FIRST, 0.95),
        share("unknown physics: flagged unknown", of("unknown"), lambda s: s.flagged, 0.85),
        share(
            "unknown physics: confidently misnamed", of("unknown"), lambda s: s.misnamed,
            0.05, "most",
        ),
        share("unknown physics: right driver", of("unknown"), lambda s: s.right_driver, 0.80),
        share("... right place", of("unknown"), lambda s: s.right_place),
        share("... unknown comes first", of("unknown"), _unknown_first),
        share("... and no named effect beside it", of("unknown"), _only_unknown),
        share("... right about memory, where it says", of("unknown"), lambda s: s.right_memory),
        share("... held-out RMS improved", of("unknown"), lambda s: s.holdout_improved),
        *bound_rows(over_bound),
        inside("coverage of 95 % intervals", gathered(sized, lambda s: s.covered)),
        middle("held-out RMS over noise floor, median", floors, "at most 1.05", 1.05),
        share("... at most 1.05", floors, lambda floor: floor <= 1.05),
        share("event times within 0.1 s", gathered(sized, lambda s: s.event_error_s),
              lambda error_s: error_s <= EVENT_S, 0.95),
        *reliability_rows(gathered(scores, lambda s: s.claims)),
        share("diagnosis failed with an error", scores, lambda s: s.failure is not None),
    ]  # fmt: skip


def more_rows(scores: Sequence[Score]) -> list[Row]:
    """Figures of the second set; no rows without a case."""

    def of(group: str) -> list[Score]:
        return [s for s in scores if s.group == group]

    rows = [
        share("four and five effects: exactly those", [*of("four"), *of("five")], EXACT, 0.80),
        *(share(f"... {group}", of(group), EXACT) for group in ("four", "five")),
        share("... all in findings or alternatives", [*of("four"), *of("five")], OFFERED),
    ]
    for group, words in (("seen", "may be looked at"), ("unseen", "kept out of sight")):
        rows += [
            share(f"new unknowns, {words}: flagged", of(group), lambda s: s.flagged, 0.90),
            share("... misnamed", of(group), lambda s: s.misnamed, 0.03, "most"),
            share("... needless names", of(group), lambda s: s.needless, 0.05, "most"),
            share("... right driver", of(group), lambda s: s.right_driver),
            share("... right place", of(group), lambda s: s.right_place),
        ]
    both = of("beside")
    rows += [
        share("unknown beside a named effect: both found", both, lambda s: s.flagged and s.named),
        share("... the unknown", both, lambda s: s.flagged),
        share("... the named effect", both, lambda s: s.named),
        share("... needless names", both, lambda s: s.needless),
    ]
    return rows if scores else []


def bound_rows(over_bound: Sequence[float]) -> list[Row]:
    """Errors in Cramer-Rao bounds: the median, and the spread that belongs to it."""
    spread = [error / ROBUST for error in over_bound]
    return [
        middle("error over Cramer-Rao bound, median", over_bound, "at most 1.25", 1.25),
        middle("... its robust spread over the bound", spread, "", None),
    ]


def reliability_rows(claims: Sequence[Claim]) -> list[Row]:
    """Whether stated probabilities hold."""
    error = calibration_error(claims)
    met = error <= 0.03 if claims else None
    value = f"{error:.3f}" if claims else "-"
    return [
        Row("calibration error of probabilities", "at most 0.03", value, "-", len(claims), met),
        portion("... of what is claimed with at least 0.95: true", sure_claims(claims), 0.95),
    ]


def gathered(scores: Sequence[Marks], parts: Callable[[Marks], Sequence[Part]]) -> list[Part]:
    """What all of them have of something, in one list."""
    return [part for marks in scores for part in parts(marks)]


def _surveys(scores: Sequence[Score]) -> list[Score]:
    return [s for s in scores if s.motion == "survey"]


def _curves(scores: Sequence[Score]) -> list[Score]:
    return [s for s in scores if s.motion != "survey"]


def _clear(scores: Sequence[Score]) -> list[Score]:
    """Without those too small to be seen by anyone; events have no bound and stay."""
    return [s for s in scores if not s.clarity < CLEAR]


def _unknown_first(marks: Score) -> bool:
    return bool(marks.said) and marks.said[0][0] == "unknown"


def _only_unknown(marks: Score) -> bool:
    return marks.flagged and {effect for effect, _ in marks.said} == {"unknown"}


def share(
    figure: str,
    scores: Sequence[Marks],
    test: Callable[[Marks], bool | None],
    goal: float | None = None,
    way: str = "least",
) -> Row:
    """Share of cases that pass a test, of those that it is about: it gives None for others."""
    tested = [test(s) for s in scores]
    return portion(figure, [passed for passed in tested if passed is not None], goal, way)


def portion(
    figure: str, hits: Sequence[bool], goal: float | None = None, way: str = "least"
) -> Row:
    """Share of hits with Wilson limits."""
    low, high = wilson(sum(hits), len(hits))
    text = "" if goal is None else f"at {way} {100 * goal:g} %"
    if not hits:
        return Row(figure, text, "-", "-", 0, None)
    value = sum(hits) / len(hits)
    met = None if goal is None else (value <= goal if way == "most" else value >= goal)
    limits = f"{100 * low:.1f} to {100 * high:.1f} %"
    return Row(figure, text, f"{100 * value:.1f} %", limits, len(hits), met)


def inside(figure: str, hits: Sequence[bool]) -> Row:
    """Coverage: neither too high nor too low."""
    row = portion(figure, hits)
    met = None if not hits else 0.93 <= sum(hits) / len(hits) <= 0.97
    return Row(figure, "93 to 97 %", row.value, row.limits, row.cases, met)


def middle(figure: str, values: Sequence[float], goal: str, most: float | None) -> Row:
    """A median with bootstrap limits."""
    if not values:
        return Row(figure, goal, "-", "-", 0, None)
    value = float(np.median(np.asarray(values, dtype=float)))
    low, high = median_limits(values)
    met = None if most is None else value <= most
    return Row(figure, goal, f"{value:.3f}", f"{low:.3f} to {high:.3f}", len(values), met)


def markdown(rows: Sequence[Row]) -> str:
    """The table as Markdown."""
    lines = ["| figure | goal | reached | 95 % limits | cases | met |", "|---|---|---|---|---|---|"]
    words = {True: "yes", False: "**no**", None: ""}
    lines += [
        f"| {r.figure} | {r.goal} | {r.value} | {r.limits} | {r.cases} | {words[r.met]} |"
        for r in rows
    ]
    return "\n".join(lines) + "\n"
