"""One answer against one truth, and the matrix of all: what was hidden, what was named first."""

from __future__ import annotations

from collections import Counter
from collections.abc import Sequence
from dataclasses import dataclass, field
from typing import Any
from xml.sax.saxutils import escape

import numpy as np

from deltactl.diagnosis.answer.records import Diagnosis, Finding, ParameterResult
from deltactl.diagnosis.answer.verdict import rather_unknown
from deltactl.proof.hidden.hidden import Value
from deltactl.proof.prove.reliability import Claim, claims_of

Name = tuple[str, str]
ROUNDING_M = 1e-3
NOTHING = "nothing"


@dataclass
class Score:
    """What an answer got right."""

    case: str
    group: str
    motion: str
    truth: list[Name]
    said: list[Name]
    kind: str = ""
    failure: str | None = None
    false_alarm_p: float = float("nan")
    first_right: bool = False
    """The first finding is the (first) truth, with its component."""
    offered: bool = False
    """Every truth is among the findings or their alternatives."""
    exact: bool = False
    """The findings are the truth, no more and no less."""
    flagged: bool = False
    """A finding is `unknown`."""
    right_driver: bool = False
    right_place: bool = False
    right_memory: bool | None = None
    """Whether it is right about the memory of what it calls unknown; None where it says nothing."""
    misnamed: bool = False
    """Unknown physics explained by named effects alone, none of which is left open."""
    named: bool = False
    """Every named effect that was hidden is among the findings."""
    needless: bool = False
    """A named effect that was not hidden is among the findings."""
    clarity: float = float("nan")
    """Distance from nothing in standard deviations of the noise; below 5 nobody could be sure."""
    covered: list[bool] = field(default_factory=list)
    over_bound: list[float] = field(default_factory=list)
    """|error| over the Cramer-Rao standard deviation."""
    event_error_s: list[float] = field(default_factory=list)
    holdout_over_floor: float = float("nan")
    holdout_improved: bool = False
    """What was modelled, a free term too, lowers the RMS of the run that was held out."""
    claims: list[Claim] = field(default_factory=list)
    """Every probability that the answer states, and whether it is so."""

    @property
    def alarmed(self) -> bool:
        """Anything at all is said to be missing."""
        return bool(self.said) or self.failure is not None


def score(result: dict[str, Any]) -> Score:
    """Score what `run_case` returned."""
    truth, answer = result["truth"], result["diagnosis"]
    names = [(line["effect"], line["where"]) for line in truth["answers"]]
    marks = Score(truth["case"], truth["group"], truth["motion"], names, [])
    if result.get("distance") is not None:
        marks.clarity = result["distance"]
    marks.kind = "+".join(line.get("kind", line["effect"]) for line in truth["answers"])
    if answer is None:
        marks.failure = result["failure"]
        return marks
    diagnosis = Diagnosis.model_validate(answer)
    found = diagnosis.findings
    # What the answer itself holds for a part of something unknown is no claim of a name.
    own = [finding for finding in found if not rather_unknown(finding)]
    marks.said = [(finding.effect, finding.component) for finding in own]
    if not found and diagnosis.verdict != "nothing_missing":
        marks.said = [("unknown", "anywhere")]
    marks.false_alarm_p = diagnosis.false_alarm_p
    true = [*names, *_through(truth["answers"])]
    marks.claims = claims_of(diagnosis, true)
    _mark_names(marks, true, found)
    _mark_unknown(marks, truth["answers"], found)
    _mark_sizes(marks, truth["answers"], found, result.get("bound"))
    floor = np.sqrt(truth["sigma"] ** 2 + ROUNDING_M**2 / 12.0)
    before, after = diagnosis.fit.holdout_rms_before_m, diagnosis.fit.holdout_rms_after_m
    marks.holdout_improved = after < before
    marks.holdout_over_floor = after / float(floor)
    return marks


def _through(truths: list[dict[str, Any]]) -> list[Name]:
    """Named effects by which an unknown shows."""
    return [(effect, where) for line in truths for effect, where in line.get("through", [])]


def _open_names(found: list[Finding]) -> list[Name]:
    return [(other.effect, other.component) for f in found for other in f.alternatives]


def _mark_names(marks: Score, true: list[Name], found: list[Finding]) -> None:
    names, said = marks.truth, set(marks.said)
    marks.first_right = bool(names) and bool(found) and marks.said[0] == names[0]
    marks.offered = set(names) <= said | set(_open_names(found))
    marks.exact = set(names) == said
    marks.named = {name for name in names if name[0] != "unknown"} <= said
    marks.needless = any(name not in true for name in said if name[0] != "unknown")
    marks.flagged = any(finding.effect == "unknown" for finding in found)


def _mark_unknown(marks: Score, truths: list[dict[str, Any]], found: list[Finding]) -> None:
    for line in truths:
        if line["effect"] != "unknown":
            continue
        places = {line["where"], *line["also_where"]}
        unknown = [finding for finding in found if finding.effect == "unknown"]
        marks.right_place = any(finding.component in places for finding in unknown)
        marks.right_driver = any(
            set(finding.depends_on) & set(line["depends_on"]) for finding in unknown
        )
        said = [finding.has_memory for finding in unknown if finding.has_memory is not None]
        if said and line["memory"] is not None:
            marks.right_memory = said[0] == line["memory"]
        left_open = any(name[0] == "unknown" for name in _open_names(found))
        marks.misnamed = bool(found) and not unknown and not left_open


def _mark_sizes(
    marks: Score,
    truths: list[dict[str, Any]],
    found: list[Finding],
    bound: dict[str, list[float]] | None,
) -> None:
    for line in truths:
        match = next(
            (f for f in found if (f.effect, f.component) == (line["effect"], line["where"])), None
        )
        if match is None:
            continue
        if "when" in line:
            marks.event_error_s.append(_event_error(match, line["when"]))
        for name, value in line.get("parameters", {}).items():
            if name not in match.parameters or (name == "time" and "when" in line):
                continue
            size = match.parameters[name]
            marks.covered += _inside(value, size)
            main = value == line["value"]
            if bound is not None and main and name in bound:
                off = np.abs(np.array([v for v, _, _ in size.components]) - np.atleast_1d(value))
                marks.over_bound += (off / np.array(bound[name])).tolist()


def _event_error(finding: Finding, when_s: float) -> float:
    if "time" in finding.parameters:
        return abs(finding.parameters["time"].components[0][0] - when_s)
    starts = [start for start, _ in finding.where.times_s]
    return min((abs(start - when_s) for start in starts), default=float("inf"))


def _inside(value: Value, size: ParameterResult) -> list[bool]:
    values = np.atleast_1d(np.asarray(value, dtype=float))
    ends = [(low, high) for _, low, high in size.components]
    return [bool(low <= v <= high) for v, (low, high) in zip(values, ends, strict=True)]


CELL, LEFT, TOP, RIGHT = 26, 190, 190, 110
WRONG_PLACE = "right effect, wrong place"
GROUPS = ("nothing", "single", "faint", "tolerance", "unknown", "seen", "unseen")
"""Groups with one answer at most; several effects have no single cell."""
Matrix = dict[tuple[str, str], int]


def confusion(scores: Sequence[Score]) -> Matrix:
    """(hidden, named first) -> cases. An unknown kind is a row of its own."""
    cells: Counter[tuple[str, str]] = Counter()
    for marks in scores:
        if marks.group not in GROUPS:
            continue
        row = NOTHING
        if marks.truth:
            row = f"unknown: {marks.kind}" if marks.truth[0][0] == "unknown" else marks.truth[0][0]
        cells[row, _said(marks)] += 1
    return dict(cells)


def _said(marks: Score) -> str:
    if marks.failure is not None:
        return "failed"
    if not marks.said:
        return NOTHING
    effect = marks.said[0][0]
    same = bool(marks.truth) and effect == marks.truth[0][0] != "unknown"
    return WRONG_PLACE if same and marks.said[0] != marks.truth[0] else effect


def rows_and_columns(cells: Matrix) -> tuple[list[str], list[str]]:
    """Names in an order that puts right answers on the diagonal."""
    rows = sorted({row for row, _ in cells}, key=lambda name: (name.startswith("unknown"), name))
    plain = [name for name in rows if not name.startswith("unknown")]
    said = {column for _, column in cells}
    extra = sorted(said - set(plain) - {"unknown"})
    columns = [name for name in plain if name in said or name != NOTHING]
    return rows, [*columns, *extra, *(["unknown"] if "unknown" in said else [])]


def picture(cells: Matrix, title: str) -> str:
    """The matrix as an SVG drawing."""
    rows, columns = rows_and_columns(cells)
    width, height = LEFT + CELL * len(columns) + RIGHT, TOP + CELL * len(rows) + 20
    parts = [
        f'<svg xmlns="http://www.w3.org/2000/svg" width="{width}" height="{height}" '
        'font-family="sans-serif" font-size="12">',
        f'<rect width="{width}" height="{height}" fill="#ffffff"/>',
        f'<text x="10" y="20" font-size="13">{escape(title)}</text>',
        f'<text x="10" y="{TOP - 10}" fill="#555555">hidden, down; named first, across</text>',
    ]
    for j, name in enumerate(columns):
        x = LEFT + CELL * j + CELL // 2 + 4
        parts.append(
            f'<text transform="translate({x},{TOP - 8}) rotate(-60)">{escape(name)}</text>'
        )
    for i, row in enumerate(rows):
        y = TOP + CELL * i
        total = sum(count for (name, _), count in cells.items() if name == row)
        parts.append(f'<text x="{LEFT - 8}" y="{y + 17}" text-anchor="end">{escape(row)}</text>')
        for j, column in enumerate(columns):
            parts.append(_cell(LEFT + CELL * j, y, cells.get((row, column), 0), total, row, column))
    return "\n".join([*parts, "</svg>"]) + "\n"


def _cell(x: int, y: int, count: int, total: int, row: str, column: str) -> str:
    right = row == column or (row.startswith("unknown") and column == "unknown")
    red, green, blue = (30, 110, 60) if right else (170, 50, 40)
    shade = count / total if total else 0.0
    colour = "#{:02x}{:02x}{:02x}".format(
        *(round(255 - shade * (255 - channel)) for channel in (red, green, blue))
    )
    ink = "#ffffff" if shade > 0.5 else "#222222"
    box = f'<rect x="{x}" y="{y}" width="{CELL}" height="{CELL}" fill="{colour}" stroke="#dddddd"/>'
    if not count:
        return box
    return f'{box}<text x="{x + 13}" y="{y + 17}" text-anchor="middle" fill="{ink}">{count}</text>'
