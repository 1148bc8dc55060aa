"""One answer against one truth. Nothing here knows how the answer came about."""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import Any

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
    """Every truth stands among the findings or their alternatives."""
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
    """Every named effect that was concealed stands among the findings."""
    needless: bool = False
    """A named effect stands among the findings that was not concealed."""
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
    marks.first_right = bool(names) and bool(found) and marks.said[0] == names[0]
    marks.offered = set(names) <= set(marks.said) | set(_open_names(found))
    marks.exact = sorted(set(names)) == sorted(set(marks.said))
    true = [*names, *_through(truth["answers"])]
    marks.named = {name for name in names if name[0] != "unknown"} <= set(marks.said)
    marks.needless = any(name not in true for name in marks.said if name[0] != "unknown")
    marks.claims = claims_of(diagnosis, true)
    marks.flagged = any(finding.effect == "unknown" for finding in found)
    _mark_unknown(marks, truth["answers"], found)
    _mark_sizes(marks, truth["answers"], found, result.get("bound"))
    floor = np.sqrt(truth["sigma"] ** 2 + ROUNDING_M**2 / 12.0)
    before, after = (
        diagnosis.fit.holdout_rms_before_m,
        diagnosis.fit.holdout_rms_after_m,
    )
    marks.holdout_improved = after < before
    marks.holdout_over_floor = diagnosis.fit.holdout_rms_after_m / float(floor)
    return marks


def _through(truths: list[dict[str, Any]]) -> list[Name]:
    """Named effects by which an unknown shows."""
    return [(effect, where) for line in truths for effect, where in line.get("through", [])]


def _open_names(found: list[Finding]) -> list[Name]:
    return [(other.effect, other.component) for f in found for other in f.alternatives]


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
