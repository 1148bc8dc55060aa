"""The answer on one screen: the verdict, what to do, the findings, and where the rest is.

What does not fit is in the report, and the last line says so.
"""

from __future__ import annotations

import math
from bisect import bisect_left
from collections.abc import Iterator, Sequence
from dataclasses import replace
from functools import partial

from rich.markup import escape

from deltactl.diagnosis.answer.how_sure import after_its_effort, is_about, settled
from deltactl.diagnosis.answer.options import VERDICT
from deltactl.diagnosis.answer.records import Diagnosis, Finding
from deltactl.diagnosis.answer.verdict import NAMELESS
from deltactl.diagnosis.answer.what_is_left import apart
from deltactl.diagnosis.report.finding import (
    by_priors,
    finding_title,
    how_sure,
    open_causes,
    other_causes,
    shown_sizes,
)
from deltactl.diagnosis.report.fit import fit_line, fit_title, unexplained
from deltactl.diagnosis.report.headline import opening
from deltactl.diagnosis.report.limits import above_nothing, in_file, limit_alone, of_the_file
from deltactl.diagnosis.report.names import all_followed, count, numbers, part_of, percent, sentence
from deltactl.diagnosis.report.next_run import (
    experiment_line,
    hint,
    measured,
    saved_lines,
    tie_lines,
)
from deltactl.diagnosis.report.pairs import beside
from deltactl.diagnosis.report.remedies import main_of, remedies
from deltactl.diagnosis.report.sizes import Size, in_its_units, quantity
from deltactl.diagnosis.report.templates import TERMINAL, Ways, say
from deltactl.foundation.one_screen import (
    LINES,
    SHORT,
    WHOLE,
    Part,
    fitted,
    shortened,
    spaced,
    wrapped,
)
from deltactl.models.effects import card_of
from deltactl.models.effects.lone_axis import COMPONENT
from deltactl.models.robot import RobotModel

WIDTH = 80
LONG_HEADLINE = 3
SENTENCE = 100_000
"""Columns of a line that is not broken."""
NARROWEST_NAME = 12
MANY_ROWS = 8
"""As many rows of the table go before the parts below it, further ones after them."""


class Line(str):
    """A line of the answer. head: whether it is a title."""

    head: bool = False


def marked(lines: Sequence[Line]) -> list[str]:
    """Lines as rich markup, everything that came from outside escaped."""
    return [f"[bold]{_escaped(one)}[/bold]" if one.head else _escaped(one) for one in lines]


@in_its_units
def screen_lines(
    diagnosis: Diagnosis,
    robot: RobotModel | None = None,
    ways: Ways = TERMINAL,
    room: tuple[int, int] = (LINES, WIDTH),
    done: Part | None = None,
    closing: Sequence[Part] = (),
    saved: bool | None = None,
) -> list[Line]:
    """The answer as lines of plain text.

    Parameters
    ----------
    robot : RobotModel, optional
        Robot whose lengths the steps name.
    ways : Ways
        How a step is done: `TERMINAL` (options), `PAGE` (buttons) or `PYTHON` (methods).
    room : (int, int)
        Lines and columns that there are.
    done : Part, optional
        What has been done already, instead of the steps to take.
    closing : sequence of Part
        What else goes before the last line, which says where the rest is.
    saved : bool, optional
        A corrected robot file was written: whether with what is not certain.
    """
    most, width = room
    above_last = most - len(wrapped(_rest(ways, 0), width))

    def laid(rows: int, brief: bool, all_parts: bool) -> tuple[list[Part], int, bool]:
        """Parts, lines of an entry, and whether there is room."""
        named = replace(ways, rows=rows)
        above = [
            _verdict(diagnosis, width, brief, below=rows == len(diagnosis.findings)),
            _steps(diagnosis, robot, named) if done is None else done,
            _table(diagnosis.findings, rows, width, brief),
            _saved(diagnosis, saved, named, width),
        ]
        for in_one in (False, True):  # causes that have no line each share one
            below = _below_the_table(diagnosis, robot, named, width, above[1].entries, in_one)
            parts = [*above, *below, *closing]
            fit, longest = fitted(parts, width, above_last)
            if longest == WHOLE:
                break
        whole = all(now.entries or not was.entries for now, was in zip(fit, parts, strict=True))
        return fit, longest, longest > 1 and (whole or not all_parts)

    found = len(diagnosis.findings)
    parts, longest, fits = laid(found, brief=False, all_parts=True)
    for all_parts, fewest in ((True, MANY_ROWS), (False, 1)):
        rows = range(min(found, most), min(found, fewest) - 1, -1)
        if rows and found and not fits:
            with_parts = partial(laid, brief=True, all_parts=all_parts)
            first = bisect_left(rows, True, key=lambda number: with_parts(number)[2])
            parts, longest, fits = with_parts(rows[min(first, len(rows) - 1)])
    heads = {*parts[0].lines(width, longest), *(part.head for part in parts)}
    last = Part([_rest(ways, parts[1].left)], gap=False)
    lines = [Line(one) for one in spaced([*parts, last], width, longest, most)]
    for line in lines:
        line.head = line in heads
    return lines


def _below_the_table(
    diagnosis: Diagnosis,
    robot: RobotModel | None,
    ways: Ways,
    width: int,
    steps: Sequence[str],
    in_one: bool,
) -> list[Part]:
    """The parts after the findings."""
    or_else = _or_else(diagnosis, ways, steps, in_one)
    return [
        Part(_helps(diagnosis), turns=0, rank=1),
        Part(or_else, say("screen.or_else"), turns=0, rank=2),
        Part([*_on_top(diagnosis, robot, ways), *remarks(diagnosis, ways, True)], short=2, rank=3),
        Part(_not_shown(diagnosis, width), gap=False, rank=4),
    ]


@in_its_units
def sentences_by_topic(
    diagnosis: Diagnosis, robot: RobotModel | None = None, ways: Ways = TERMINAL
) -> dict[str, list[str]]:
    """All that a screen says, with a paragraph for each finding."""
    findings = [
        " ".join([f"{number}. {finding_title(one)}", *_in_full(one, diagnosis)])
        for number, one in enumerate(diagnosis.findings, 1)
    ]
    more = [*_on_top(diagnosis, robot, ways), *remarks(diagnosis, ways)]
    steps = list(_steps(diagnosis, robot, ways).entries)
    return {
        "verdict": opening(diagnosis),
        "steps": steps,
        "findings": findings,
        "helps": _helps(diagnosis),
        "or_else": _or_else(diagnosis, ways, steps, in_one=False),
        "remarks": [*more, *_not_shown(diagnosis, SENTENCE)],
    }


def sentences(
    diagnosis: Diagnosis, robot: RobotModel | None = None, ways: Ways = TERMINAL
) -> list[str]:
    """The same one after the other: `says` of the JSON."""
    by_topic = sentences_by_topic(diagnosis, robot, ways).values()
    return [line for lines in by_topic for line in lines]


def _in_full(finding: Finding, diagnosis: Diagnosis) -> Iterator[str]:
    """Its sizes with their intervals, what goes with them, and how sure it is."""
    for _, size in shown_sizes(finding):
        yield sentence(f"{size.name}: {size.text}")
    yield from beside(finding, diagnosis)
    yield from how_sure(finding, diagnosis)


def _escaped(line: str) -> str:
    text = escape(line)
    return f"{text}\\" if text.endswith("\\") else text  # it would escape the closing tag


def _verdict(diagnosis: Diagnosis, width: int, brief: bool, below: bool) -> Part:
    lines = opening(diagnosis, below=below)
    if sum(len(wrapped(line, width)) for line in lines) > LONG_HEADLINE - brief:
        lines = opening(diagnosis, brief=True, below=below)
    return Part(["\n".join(shortened(line, width, LONG_HEADLINE + 1)) for line in lines])


def _steps(diagnosis: Diagnosis, robot: RobotModel | None, ways: Ways) -> Part:
    steps = remedies(diagnosis, robot, ways)
    numbered = [f"{number}. {step}" for number, step in enumerate(steps, 1)]
    return Part(numbered, say("summary.do_this"))


def _table(findings: Sequence[Finding], shown: int, width: int, brief: bool) -> Part:
    """A finding in each row, with its further sizes below it; brief: without them."""
    if not findings:
        return Part([])
    head = tuple(say("screen.columns").split("|"))
    rows = [list(table_rows(number, one)) for number, one in enumerate(findings[:shown], 1)]
    rows = [row[:1] if brief else row for row in rows]
    cells = [head, *(row for several in rows for row in several)]
    widths = [max(len(row[k]) for row in cells) for k in range(len(head))]
    others = sum(widths) - widths[1] + 2 * (len(head) - 1)
    widths[1] = max(min(widths[1], width - others), NARROWEST_NAME)
    first = _laid_out(head, widths)
    lines = [_laid_out(row, widths) for several in rows for row in several]
    left = len(findings) - shown
    more = [say("screen.more_findings", number=left)] * bool(left)
    return Part(["\n".join([*lines, *more])], first)


def _saved(diagnosis: Diagnosis, all_of_them: bool | None, ways: Ways, width: int) -> Part:
    """Which findings the corrected robot file holds, if there is one."""
    if all_of_them is None:
        return Part([])
    lines = saved_lines(diagnosis, all_of_them, ways)
    if any(len(wrapped(line, width)) >= SHORT for line in lines):
        lines = saved_lines(diagnosis, all_of_them, ways, brief=True)
    return Part(["\n".join(lines)] * bool(lines))


def table_rows(number: int, finding: Finding) -> Iterator[tuple[str, ...]]:
    """Its cells, the main size first; further sizes as rows below it."""
    name = _called(finding.effect, finding.component, after_its_effort(finding))
    if finding.effect == NAMELESS and finding.depends_on:
        name = say("screen.unknown", follows=all_followed(finding.depends_on))
    where = part_of(finding.effect, finding.component, finding.depends_on).removeprefix("the ")
    sure = "" if finding.probability is None else percent(finding.probability)
    sure = sure.replace("above", ">").replace("below", "<")
    main = main_of(finding) if finding.parameters else ""
    sizes = sorted(shown_sizes(finding), key=lambda size: size[0] != main)
    first = sizes[0][1] if sizes else None
    there = settled(finding)
    yield (f"{number}", name, where, *_cells(first, there), sure)
    for _, size in sizes[1:]:
        yield "", f"  {size.name}", "", *_cells(size, there), ""


def _called(effect: str, component: str, by_effort: bool = False) -> str:
    """An effect as its card calls it, without the part."""
    return card_of(effect).words.without_place(effect, component == COMPONENT, by_effort)


def _cells(size: Size | None, there: bool) -> tuple[str, str]:
    """A size, unknown of what is there with an interval that holds nothing, and its interval."""
    if size is None:
        return "", ""
    shown = say("size.not_known") if there and size.low < 0.0 < size.high else size.shown
    return shown, size.interval or say("size.not_known") * math.isfinite(size.value)


def _laid_out(row: Sequence[str], widths: Sequence[int]) -> str:
    """A row of the table: its second column goes on in the next line where it is long."""
    names = wrapped(row[1], widths[1])
    first = (row[0], names[0], *row[2:])
    line = "  ".join(cell.ljust(width) for cell, width in zip(first, widths, strict=True)).rstrip()
    return "\n".join([line, *(f"{' ' * (widths[0] + 2)}{name}" for name in names[1:])])


def _helps(diagnosis: Diagnosis) -> list[str]:
    """The error before and after, on this recording and held out, and the part that remains."""
    title = f"{fit_title(diagnosis)} " if diagnosis.findings else ""
    left = diagnosis.unexplained.says or unexplained(diagnosis)
    return [f"{title}{fit_line(diagnosis)}", sentence(left)]


def _or_else(diagnosis: Diagnosis, ways: Ways, steps: Sequence[str], in_one: bool) -> list[str]:
    """What else the findings could be, and how to find out where the steps do not say it.

    in_one: the causes of all findings in one entry.
    """
    following = experiment_line(diagnosis)
    entries = [f"{following}{say('run.get', job=ways.job)}"] if following else []
    others: list[str] = []
    hints: list[str] = []
    unsure = {k: one for k, one in enumerate(diagnosis.findings, 1) if _unsure(one)}
    for number, finding in unsure.items():
        if number <= ways.rows:
            shown = open_causes(finding)
            way = measured(finding, diagnosis, ways)
            in_steps = way and any(way in step for step in steps)
            known = following or diagnosis.open_ties or in_steps
            apart = "" if known else hint(finding, diagnosis, ways)
            others.append(say("screen.other", number=number, names=other_causes(finding, shown)))
            hints += [say("screen.apart", number=number, hint=apart)] * bool(apart)
    entries += ["; ".join(one.rstrip(".") for one in others) + "."] if in_one and others else others
    entries += [*tie_lines(diagnosis), *hints]
    return entries or [say("other.none")] * (bool(diagnosis.findings) and not unsure)


def _unsure(finding: Finding) -> bool:
    weak = finding.effect != NAMELESS and (finding.probability or 1.0) < VERDICT.sure_enough
    return weak or bool(open_causes(finding))


def _on_top(diagnosis: Diagnosis, robot: RobotModel | None, ways: Ways) -> list[str]:
    """Which findings are further sizes of what the robot file has already."""
    which = {
        number: f"{number}"
        for number, one in enumerate(diagnosis.findings, 1)
        if in_file(robot, one.effect, one.component)
    }
    return [say("screen.on_top", which=numbers(which, ways.rows))] if which else []


def remarks(diagnosis: Diagnosis, ways: Ways, brief: bool = False) -> list[str]:
    """What the answer as a whole depends on; brief: without what is beyond doubt."""
    by_assumption = [
        by_priors(one)
        for one in diagnosis.prior_sensitivity
        if not any(is_about(one, finding) for finding in diagnosis.findings)
    ]
    return [
        *(say("summary.left_out", why=why) for why in diagnosis.left_out),
        *(
            say("summary.thinned", hours=one.span_s / 3600, **one.model_dump())
            for one in diagnosis.thinned
        ),
        *(say("summary.not_read", why=why) for why in diagnosis.not_read),
        *(say("summary.not_held_out", why=why) for why in diagnosis.not_held_out),
        *of_the_file(diagnosis, brief),
        *_agreement(diagnosis),
        *by_assumption,
    ]


def _agreement(answer: Diagnosis) -> list[str]:
    """Whether several recordings say the same."""
    disagree = apart(answer)
    if answer.agreement and not disagree:
        return [say("several.agree", p=min(one.p for one in answer.agreement))]
    return [
        say(
            "several.disagree",
            parameter=one.parameter.replace("_", " "),
            effect=one.effect.replace("_", " "),
            sizes=", ".join(quantity(size.components[0][0], size.unit) for size in one.sizes),
            p=one.p,
        )
        for one in disagree
    ]


def _not_shown(diagnosis: Diagnosis, width: int) -> list[str]:
    """A line of effects that could not be seen at all, then those that could not below a size.

    What a finding may be instead is none of them, though its size is not to be seen.
    """
    offered = {other.effect for one in diagnosis.findings for other in one.alternatives}
    unseen = (one for one in diagnosis.not_testable if one.effect not in offered)
    limits = [one for one in diagnosis.smallest_detectable if one.parameter != "stiffness"]
    largest = {one.effect: one for one in sorted(limits, key=above_nothing)}
    sizes = ((largest[one.effect], _called(one.effect, one.component)) for one in limits)
    below = (say("screen.below", name=name, size=limit_alone(one)) for one, name in sizes)
    names = [*(_called(one.effect, one.component) for one in unseen), *below]
    names = sorted(dict.fromkeys(names), key=lambda one: len(one) > width // 2 - 4)
    for shown in range(len(names), 0, -1):
        text, more = ", ".join(names[:shown]), len(names) - shown
        named = say("screen.and_more", names=text, number=more) if more else text
        line = say("screen.not_shown", names=named)
        if shown == 1 or len(line) <= width:
            return [line]
    return []


def _rest(ways: Ways, steps_left: int) -> str:
    """Where everything else is."""
    more = say("screen.steps_left", steps=count(steps_left, "more step")) if steps_left else ""
    return ways.rest.format(more=more)
