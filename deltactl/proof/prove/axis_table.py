"""The table of single axes: even seeds, odd seeds and a practice folder side by side."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence

from deltactl.proof.prove.axis_score import AxisScore
from deltactl.proof.prove.reliability import calibration_error, sure_claims
from deltactl.proof.prove.table import ROBUST, Row, inside, middle, portion

Test = Callable[[AxisScore], bool]
VISIBLE = 5.0


def axis_rows(scores: Sequence[AxisScore]) -> list[Row]:
    """Every figure of some cases, always in the same order."""

    def of(*tiers: str) -> list[AxisScore]:
        return [marks for marks in scores if marks.tier in tiers]

    def share(figure: str, chosen: Sequence[AxisScore], test: Test,
              goal: float | None = None, way: str = "least") -> Row:  # fmt: skip
        return portion(figure, [test(marks) for marks in chosen], goal, way)

    named = of("single", "faint", "gross", "pair", "three", "tolerance")
    claims = [claim for marks in scores for claim in marks.claims]
    error = calibration_error(claims)
    faint = of("faint")
    rows = [
        share("false alarms, nothing missing", of("none"), _alarmed, 0.01, "most"),
        share("single: exactly that", of("single"), _exact, 0.95),
        share("... named", of("single"), _named),
        share("gross: exactly that", of("gross"), _exact, 0.98),
        share("faint: something false named", faint, _false, 0.05, "most"),
        share("... of those that could be seen: named",
              [marks for marks in faint if marks.clarity >= VISIBLE], _named),
        share("pair: exactly those", of("pair"), _exact, 0.85),
        share("... all in findings or alternatives", of("pair"), _within),
        share("three: exactly those", of("three"), _exact),
        share("... all in findings or alternatives", of("three"), _within),
        share("one culprit among tolerances: first", of("tolerance"), lambda s: s.first, 0.95),
        share("tie that the motion makes: reported", of("ambiguous"),
              lambda s: s.tie_reported, 0.90),
        share("unknown physics: flagged and not misnamed", of("unknown"),
              lambda s: s.flagged and not s.misnamed, 0.85),
        share("... misnamed", of("unknown"), lambda s: s.misnamed),
        share("... needless names beside it", of("unknown"), lambda s: bool(s.needless)),
        portion("... right driver", [marks.right_driver for marks in of("unknown")
                                     if marks.right_driver is not None]),
        share("answers that contradict what was hidden", scores,
              lambda s: bool(s.contradictions), 0.0, "most"),
        inside("coverage of 95 % intervals", [hit for marks in named for hit in marks.covered]),
        middle("error over Cramer-Rao bound, median",
               [x for marks in named for x in marks.over_bound], "at most 1.25", 1.25),
        middle("... its robust spread over the bound",
               [x / ROBUST for marks in named for x in marks.over_bound], "", None),
        Row("calibration error of probabilities", "at most 0.03",
            f"{error:.3f}" if claims else "-", "-", len(claims), error <= 0.03 if claims else None),
        portion("... of what is claimed with at least 0.95: true", sure_claims(claims), 0.95),
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


def _alarmed(marks: AxisScore) -> bool:
    return marks.alarmed


def _exact(marks: AxisScore) -> bool:
    return marks.exact


def _named(marks: AxisScore) -> bool:
    return marks.named


def _within(marks: AxisScore) -> bool:
    return marks.within


def _false(marks: AxisScore) -> bool:
    return bool(marks.needless) or marks.failure is not None


def beside(columns: Mapping[str, Sequence[Row]]) -> list[list[str]]:
    """Lines of cells: the figure, its goal, and for each column value, limits and cases."""
    names = list(dict.fromkeys(row.figure for rows in columns.values() for row in rows))
    lines = []
    for name in names:
        own = {title: next((r for r in rows if r.figure == name), None)
               for title, rows in columns.items()}  # fmt: skip
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
