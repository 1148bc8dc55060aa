"""Answers about single axes against the truth: names, honesty, sizes, probabilities; the table.

The truth lists for each hidden effect the `names` that are right (itself, and what is the same
operator in that recording), its `ties` (what an ideal observer could not separate from it), and
under `also` what may be named beside. Effects of `axis` and of `motor1` count alike.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from operator import attrgetter
from typing import Any

import numpy as np

from deltactl.proof.prove.reliability import Claim
from deltactl.proof.prove.table import (
    EXACT,
    Row,
    bound_rows,
    gathered,
    inside,
    middle,
    reliability_rows,
    share,
)

SURE = 0.8
"""A probability above which something that cannot be known is claimed as if it were."""
CLEAR = 3.0
"""Root mean square over the noise's from which on nothing missing is a false statement."""
LEFT = 1.5
"""Likewise of what an answer leaves that calls the recording explained."""
INVISIBLE = 3.0
"""Standard deviations below which no observer could say that something is there."""
LIKE_TRUE = ("explained", "nothing_missing")
Json = dict[str, Any]


@dataclass
class AxisScore:
    """What an answer got right."""

    case: str
    seed: int
    tier: str
    machine: str
    style: str
    truth: list[str]
    said: list[str] = field(default_factory=list)
    failure: str | None = None
    named: bool = False
    """Every hidden effect is a finding."""
    within: bool = False
    """Every hidden effect is a finding, tied with one, or among the alternatives."""
    first: bool = False
    """The first finding is right, or tied with what is."""
    exact: bool = False
    """All within, and nothing needless."""
    needless: list[str] = field(default_factory=list)
    tie_reported: bool = False
    """In a tie both sides are offered, or neither is claimed as if it were known."""
    flagged: bool = False
    """Something unknown is found, or the verdict says that not all is explained."""
    misnamed: bool = False
    """An unknown is explained by named effects alone, with nothing left open."""
    right_driver: bool | None = None
    """Whether an unknown is said to follow what it does; None where the truth does not say."""
    contradictions: list[str] = field(default_factory=list)
    """How the answer contradicts what was hidden, or its own limits."""
    clarity: float = float("nan")
    """Standard deviations by which the faintest hidden effect is seen by an ideal observer."""
    covered: list[bool] = field(default_factory=list)
    over_bound: list[float] = field(default_factory=list)
    claims: list[Claim] = field(default_factory=list)
    diagnosed_s: float = 0.0

    @property
    def alarmed(self) -> bool:
        """Anything at all is said to be missing."""
        return bool(self.said) or self.failure is not None


def score_axis(result: Json) -> AxisScore:
    """Score what `run_axis` or `run_practice` returned."""
    truth, answer = result["truth"], result["diagnosis"]
    hidden: list[Json] = truth["answers"]
    marks = AxisScore(
        truth["case"],
        result["seed"],
        _tier(truth["tier"]),
        truth["machine"],
        truth["about"]["style"],
        [_shown(line) for line in hidden],
        diagnosed_s=result["diagnosed_s"],
    )
    sizes = [float(np.sqrt(line["chi2"])) for line in hidden if "chi2" in line]
    marks.clarity = min(sizes, default=float("nan"))
    if answer is None:
        marks.failure = result["failure"]
        return marks
    found: list[Json] = answer["findings"]
    marks.said = [finding["effect"] for finding in found]
    if not found and answer["verdict"] != "nothing_missing":
        marks.said = ["unknown"]
    _mark_names(marks, truth, found)
    _mark_unknown(marks, hidden, answer)
    marks.tie_reported = all(_reported(line, answer) for line in hidden)
    marks.contradictions = list(_contradicted(marks, truth, answer))
    _mark_sizes(marks, hidden, found, result.get("bound"))
    marks.claims = _claims(marks, truth, answer)
    return marks


def _tier(name: str) -> str:
    """The practice folder calls two tiers otherwise."""
    return {"null": "none", "workshop": "tolerance"}.get(name, name)


def _shown(line: Json) -> str:
    return f"unknown: {line['physics']}" if "physics" in line else str(line["effect"])


def _others(finding: Json) -> list[str]:
    return [other["effect"] for other in finding["alternatives"]]


def _mark_names(marks: AxisScore, truth: Json, found: list[Json]) -> None:
    said = set(marks.said)
    offered = said | {name for finding in found for name in _others(finding)}
    hidden = truth["answers"]
    right = {name for line in hidden for name in line["names"]}
    right_or_tied = right | {name for line in hidden for name in line["ties"]}
    marks.named = all(said & set(line["names"]) for line in hidden)
    marks.within = all(
        said & {*line["names"], *line["ties"]} or offered & set(line["names"]) for line in hidden
    )
    marks.first = bool(marks.said) and bool(hidden) and marks.said[0] in right_or_tied
    marks.needless = sorted(said - right_or_tied - set(truth["also"]))
    marks.exact = marks.within and not marks.needless


def _mark_unknown(marks: AxisScore, hidden: list[Json], answer: Json) -> None:
    found = answer["findings"]
    marks.flagged = "unknown" in marks.said or answer["verdict"] not in LIKE_TRUE
    left_open = any("unknown" in _others(finding) for finding in found)
    marks.misnamed = bool(found) and not marks.flagged and not left_open
    follows = {
        name
        for finding in found
        for name in finding.get("depends_on", [])
        if finding["effect"] == "unknown"
    }
    drivers = {name for line in hidden for name in line.get("depends_on", [])}
    marks.right_driver = bool(follows & drivers) if drivers else None


def _reported(line: Json, answer: Json) -> bool:
    """Whether what cannot be separated from an effect in this motion is said to be a tie."""
    tied = {*line["names"], *line["ties"]}
    own = [finding for finding in answer["findings"] if finding["effect"] in tied]
    if not own:
        return bool(answer["verdict"] != "nothing_missing")
    if all(set(_others(finding)) & (tied - {finding["effect"]}) for finding in own):
        return True
    return all((finding["probability"] or 0.0) <= SURE for finding in own)


def _contradicted(marks: AxisScore, truth: Json, answer: Json) -> list[str]:
    """Statements that what was hidden, or the answer's own figures, prove false."""
    hidden, noise = truth["answers"], truth["noise_rms"]
    empty = answer["verdict"] == "nothing_missing"
    empty |= (answer.get("probability_nothing_missing") or 0.0) > 0.5
    wrong = [
        f"nothing missing beside {_shown(line)}"
        for line in hidden
        if empty and line["rms"] > CLEAR * noise and _over_limit(line, answer)
    ]
    high = max(truth["noise_rms_high"], truth.get("noise_rms_short", 0.0))
    left = answer["fit"]["rms_after_m"]
    # On a healthy machine only noise can be left, whatever smoothing the answer has.
    if hidden and answer["verdict"] in LIKE_TRUE and left > LEFT * high:
        wrong.append(f"{answer['verdict']} with {left / high:.1f} times the noise left")
    if marks.tier == "ambiguous":
        wrong += _sure_in_a_tie(hidden, answer)
    return wrong


def _sure_in_a_tie(hidden: list[Json], answer: Json) -> list[str]:
    """Claims without alternatives about what this motion cannot separate from something else."""
    open_ = {effect["effect"] for effect in answer.get("not_testable", [])}
    wrong = []
    for line in hidden:
        tied = {*line["names"], *line["ties"]}
        sure = [
            finding["effect"]
            for finding in answer["findings"]
            if finding["effect"] in tied
            and not finding["alternatives"]
            and (finding["probability"] or 0.0) > SURE
        ]
        if sure and len(tied) > 1 and not tied & open_:
            wrong.append(f"sure of {sure[0]}")
    return wrong


def _over_limit(line: Json, answer: Json) -> bool:
    """Whether an effect is larger than what the answer promises to detect; no promise: yes."""
    for limit in answer.get("smallest_detectable", []):
        value = line["values"].get(limit["parameter"])
        if limit["effect"] == line["effect"] and value is not None:
            size = value - 1.0 if limit["parameter"] == "scale" else value
            return bool(abs(size) > limit["value"])
    return True


def _mark_sizes(
    marks: AxisScore, hidden: list[Json], found: list[Json], bound: Json | None
) -> None:
    for line in hidden:
        match = next((finding for finding in found if finding["effect"] == line["effect"]), None)
        if match is None:
            continue
        for name, value in line["values"].items():
            interval = _interval(match["parameters"], name)
            if interval is None or name in ("phase", "time_of_event"):
                continue
            if line["effect"] == "lost_steps" and name == "time":
                continue
            low, middle, high = interval
            marks.covered.append(bool(low <= value <= high))
            deviation = (bound or {}).get(line["effect"], {}).get(name)
            if deviation:
                marks.over_bound.append(abs(middle - value) / deviation)


def _interval(parameters: Json, name: str) -> tuple[float, float, float] | None:
    """Lower end, value, upper end. The total of a delay is the sum of its parts, ends likewise."""
    if name == "total" and "total" not in parameters:
        parts = [_interval(parameters, part) for part in ("time", "dead_time")]
        there = [part for part in parts if part is not None]
        low, middle, high = (
            (sum(column) for column in zip(*there, strict=True)) if there else (0.0, 0.0, 0.0)
        )
        return (low, middle, high) if there else None
    size = parameters.get(name)
    if size is None or size["value"] is None or isinstance(size["value"], list):
        return None
    low, high = (
        end if end is not None else inf
        for end, inf in zip(size["ci95"], (-np.inf, np.inf), strict=True)
    )
    return float(low), float(size["value"]), float(high)


def _claims(marks: AxisScore, truth: Json, answer: Json) -> list[Claim]:
    """What the answer states: of a finding and its alternatives, those that are right are one."""
    hidden = truth["answers"]
    right = {name for line in hidden for name in line["names"]}
    claims: list[Claim] = []
    nothing = answer.get("probability_nothing_missing")
    if nothing is not None and not marks.clarity < INVISIBLE:
        claims.append((nothing, not hidden))
    for finding in answer["findings"]:
        stated = [(finding["effect"], finding["probability"])]
        stated += [(other["effect"], other["probability"]) for other in finding["alternatives"]]
        given: dict[str, float] = {}
        for name, probability in stated:
            if probability is not None:
                given.setdefault(name, probability)
        true = sum(p for name, p in given.items() if name in right)
        if any(name in right for name in given):
            claims.append((min(true, 1.0), True))
        beside = set(truth["also"])
        claims += [(p, False) for name, p in given.items() if name not in right | beside]
    return claims


NAMED, WITHIN = attrgetter("named"), attrgetter("within")
VISIBLE = 5.0


def axis_rows(scores: Sequence[AxisScore]) -> list[Row]:
    """Every figure of some cases, always in the same order."""

    def of(*tiers: str) -> list[AxisScore]:
        return [marks for marks in scores if marks.tier in tiers]

    named = of("single", "faint", "gross", "pair", "three", "tolerance")
    faint = of("faint")
    rows = [
        share("false alarms, nothing missing", of("none"), attrgetter("alarmed"), 0.01, "most"),
        share("single: exactly that", of("single"), EXACT, 0.95),
        share("... named", of("single"), NAMED),
        share("gross: exactly that", of("gross"), EXACT, 0.98),
        share("faint: something false named", faint, _false, 0.05, "most"),
        share("... of those that could be seen: named",
              [marks for marks in faint if marks.clarity >= VISIBLE], NAMED),
        share("pair: exactly those", of("pair"), EXACT, 0.85),
        share("... all in findings or alternatives", of("pair"), WITHIN),
        share("three: exactly those", of("three"), EXACT),
        share("... all in findings or alternatives", of("three"), WITHIN),
        share("one culprit among tolerances: first", of("tolerance"), lambda s: s.first, 0.95),
        share("tie that the motion makes: reported", of("ambiguous"),
              lambda s: s.tie_reported, 0.90),
        share("unknown physics: flagged and not misnamed", of("unknown"),
              lambda s: s.flagged and not s.misnamed, 0.85),
        share("... misnamed", of("unknown"), lambda s: s.misnamed),
        share("... needless names beside it", of("unknown"), lambda s: bool(s.needless)),
        share("... right driver", of("unknown"), lambda s: s.right_driver),
        share("answers that contradict what was hidden", scores,
              lambda s: bool(s.contradictions), 0.0, "most"),
        inside("coverage of 95 % intervals", gathered(named, lambda s: s.covered)),
        *bound_rows(gathered(named, lambda s: s.over_bound)),
        *reliability_rows(gathered(scores, lambda s: s.claims)),
        share("diagnosis failed with an error", scores, lambda s: s.failure is not None),
        middle("seconds of a diagnosis, median",
               [marks.diagnosed_s for marks in scores], "", None),
    ]  # fmt: skip
    for machine in sorted({marks.machine for marks in scores}):
        own = [marks for marks in scores if marks.machine == machine]
        rows.append(share(f"right, {machine}", own, right))
    return rows


def right(marks: AxisScore) -> bool:
    """Whether an answer is what can be asked of its tier."""
    if marks.failure is not None:
        return False
    return {
        "none": not marks.alarmed,
        "faint": not _false(marks),
        "tolerance": marks.first,
        "ambiguous": marks.tie_reported,
        "unknown": marks.flagged and not marks.misnamed,
    }.get(marks.tier, marks.exact)


def _false(marks: AxisScore) -> bool:
    return bool(marks.needless) or marks.failure is not None


def beside(columns: Mapping[str, Sequence[Row]]) -> list[list[str]]:
    """Lines of cells: the figure, its goal, and for each column value, limits and cases."""
    names = list(dict.fromkeys(row.figure for rows in columns.values() for row in rows))
    lines = []
    for name in names:
        own = {
            title: next((r for r in rows if r.figure == name), None)
            for title, rows in columns.items()
        }
        goal = next((row.goal for row in own.values() if row is not None), "")
        lines.append([name, goal, *(_cell(row) for row in own.values())])
    return lines


def _cell(row: Row | None) -> str:
    if row is None or row.cases == 0:
        return "-"
    value = f"**{row.value}**" if row.met is False else row.value
    limits = "" if row.limits == "-" else f" [{row.limits.replace(' to ', ', ')}]"
    return f"{value}{limits} of {row.cases}"


def axis_markdown(columns: Mapping[str, Sequence[Row]]) -> str:
    """The table as Markdown; a figure in bold misses its goal."""
    heads = ["figure", "goal", *columns]
    lines = [f"| {' | '.join(heads)} |", "|" + "---|" * len(heads)]
    lines += [f"| {' | '.join(cells)} |" for cells in beside(columns)]
    return "\n".join(lines) + "\n"


def wrong_answers(scores: Sequence[AxisScore]) -> str:
    """What went wrong, one line a case, as Markdown."""
    lines = []
    for marks in scores:
        if right(marks) and not marks.contradictions:
            continue
        truth, said = ", ".join(marks.truth) or "nothing", ", ".join(marks.said) or "nothing"
        also = f" ({'; '.join(marks.contradictions)})" if marks.contradictions else ""
        about = f"{marks.tier}, {marks.machine}, {marks.style}"
        lines.append(f"- {marks.case} ({about}): {truth} -> {marks.failure or said}{also}")
    return "\n".join(lines) + "\n"
