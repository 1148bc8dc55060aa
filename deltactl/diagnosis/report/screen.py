"""The answer on one screen: the verdict, what to do, the findings, and where the rest is.

What does not fit is in the report, and the last line says so.
"""

from __future__ import annotations

import math
from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace

from rich.markup import escape

from deltactl.diagnosis.answer.how_sure import is_about, late_in_all_s, tied
from deltactl.diagnosis.answer.records import Diagnosis, Finding, SmallestDetectable
from deltactl.diagnosis.answer.verdict import NAMELESS
from deltactl.diagnosis.answer.what_is_left import apart, doubtful_floor
from deltactl.diagnosis.report.finding import (
    as_well_line,
    by_priors,
    divided,
    finding_title,
    how_sure,
    notes,
    other_causes,
    told_sizes,
)
from deltactl.diagnosis.report.fit import (
    fit_lines,
    fit_title,
    gain,
    unexplained_line,
    without_unit_of,
)
from deltactl.diagnosis.report.headline import opening
from deltactl.diagnosis.report.limits import (
    above_nothing,
    allowed_line,
    in_file,
    limit_alone,
    of_the_file,
)
from deltactl.diagnosis.report.names import (
    all_followed,
    count,
    listed,
    part_of,
    percent,
    sentence,
)
from deltactl.diagnosis.report.next_run import experiment_line, hint, tie_lines
from deltactl.diagnosis.report.remedies import main_of, remedies
from deltactl.diagnosis.report.sizes import quantity
from deltactl.diagnosis.report.templates import TERMINAL, Ways, say
from deltactl.foundation.one_screen import Part, fitted, spaced, wrapped
from deltactl.models.robot import RobotModel

LINES, WIDTH = 25, 80
LONG_HEADLINE = 3
SENTENCE = 100_000
"""Columns of a line that is not broken."""
NARROWEST_NAME = 12


class Line(str):
    """A line of the answer. head: whether it is a title."""

    head: bool = False


def marked(lines: Sequence[Line]) -> list[str]:
    """Lines as rich markup, everything that came from outside escaped."""
    return [f"[bold]{_escaped(one)}[/bold]" if one.head else _escaped(one) for one in lines]


def screen_lines(
    diagnosis: Diagnosis,
    robot: RobotModel | None = None,
    ways: Ways = TERMINAL,
    most: int = LINES,
    width: int = WIDTH,
    done: Part | None = None,
    closing: Sequence[Part] = (),
) -> list[Line]:
    """The answer as lines of plain text.

    Parameters
    ----------
    robot : RobotModel, optional
        Robot whose lengths the steps name.
    ways : Ways
        How a step is done: `TERMINAL` (options), `PAGE` (buttons) or `PYTHON` (methods).
    most, width : int
        Lines and columns that there are.
    done : Part, optional
        What has been done already, instead of the steps to take.
    closing : sequence of Part
        Goes before the last line, which says where everything else is.
    """
    steps = _steps(diagnosis, robot, ways) if done is None else done
    parts = [
        _verdict(diagnosis, width),
        steps,
        _table(diagnosis.findings, width),
        _helps(diagnosis),
        _or_else(diagnosis, ways),
        Part([*_on_top(diagnosis, robot, ways), *remarks(diagnosis, ways)], short=2, rank=3),
        *closing,
        Part(_not_shown(diagnosis, width), gap=False, rank=4),
    ]
    parts, longest = fitted(parts, width, most - len(wrapped(_rest(ways, 0), width)))
    heads = {*parts[0].lines(width, longest), *(part.head for part in parts)}
    last = Part([_rest(ways, parts[1].left)], gap=False)
    lines = [Line(one) for one in spaced([*parts, last], width, longest, most)]
    for line in lines:
        line.head = line in heads
    return lines


@dataclass(frozen=True, slots=True)
class Sentences:
    """All sentences of an answer, by topic."""

    verdict: list[str]
    steps: list[str]
    findings: list[str]
    """A paragraph for each, in the order of the answer."""
    helps: list[str]
    or_else: list[str]
    """What else the findings could be, and what would tell."""
    remarks: list[str]


def sentences_by_topic(
    diagnosis: Diagnosis, robot: RobotModel | None = None, ways: Ways = TERMINAL
) -> Sentences:
    """All that a screen says, with the findings as sentences."""
    findings = [
        " ".join([f"{number}. {finding_title(one)}", *_in_full(one, diagnosis)])
        for number, one in enumerate(diagnosis.findings, 1)
    ]
    return Sentences(
        verdict=list(opening(diagnosis)),
        steps=list(_steps(diagnosis, robot, ways).entries),
        findings=findings,
        helps=list(_helps(diagnosis).entries),
        or_else=list(_or_else(diagnosis, ways).entries),
        remarks=[
            *_on_top(diagnosis, robot, ways),
            *remarks(diagnosis, ways),
            *_not_shown(diagnosis, SENTENCE),
        ],
    )


def sentences(
    diagnosis: Diagnosis, robot: RobotModel | None = None, ways: Ways = TERMINAL
) -> list[str]:
    """The same one after the other: `says` of the JSON."""
    by_topic = sentences_by_topic(diagnosis, robot, ways)
    return [
        *by_topic.verdict,
        *by_topic.steps,
        *by_topic.findings,
        *by_topic.helps,
        *by_topic.or_else,
        *by_topic.remarks,
    ]


def _in_full(finding: Finding, diagnosis: Diagnosis) -> Iterator[str]:
    """Its sizes with their intervals, what goes with them, and how sure it is."""
    for _, _, size in told_sizes(finding):
        yield sentence(f"{size.name}: {size.text}")
    yield from filter(None, [divided(finding)])
    yield from notes(finding, diagnosis)
    yield from how_sure(finding, diagnosis)


def _escaped(line: str) -> str:
    text = escape(line)
    return f"{text}\\" if text.endswith("\\") else text  # it would escape the closing tag


def _verdict(diagnosis: Diagnosis, width: int) -> Part:
    lines = opening(diagnosis)
    if sum(len(wrapped(line, width)) for line in lines) > LONG_HEADLINE:
        lines = opening(diagnosis, brief=True)
    return Part(lines, short=LONG_HEADLINE + 1)


def _steps(diagnosis: Diagnosis, robot: RobotModel | None, ways: Ways) -> Part:
    short = replace(ways, describe="", keep=ways.keep and ways.keep_briefly)
    steps = remedies(diagnosis, robot, short)
    numbered = [f"{number}. {step}" for number, step in enumerate(steps, 1)]
    return Part(numbered, say("summary.do_this"))


def _table(findings: Sequence[Finding], width: int) -> Part:
    """A finding in each row, with its further sizes below it."""
    if not findings:
        return Part([])
    head = tuple(say("screen.columns").split("|"))
    rows = [list(_rows(number, finding)) for number, finding in enumerate(findings, 1)]
    cells = [head, *(row for several in rows for row in several)]
    widths = [max(len(row[k]) for row in cells) for k in range(len(head))]
    others = sum(widths) - widths[1] + 2 * (len(head) - 1)
    widths[1] = max(min(widths[1], width - others), NARROWEST_NAME)
    first = _laid_out(head, widths)
    entries = ["\n".join(_laid_out(row, widths) for row in several) for several in rows]
    return Part(entries, first, say("screen.more_findings", number="{number}"), turns=2)


def _rows(number: int, finding: Finding) -> Iterator[tuple[str, ...]]:
    name = finding.effect.replace("_", " ")
    if finding.effect == NAMELESS and finding.depends_on:
        name = say("screen.unknown", follows=all_followed(finding.depends_on))
    where = part_of(finding.effect, finding.component, finding.depends_on).removeprefix("the ")
    sure = "" if finding.probability is None else percent(finding.probability)
    sure = sure.replace("above", ">").replace("below", "<")
    main = main_of(finding) if finding.parameters else ""
    told = sorted(told_sizes(finding), key=lambda size: size[0] != main)
    sizes = [(size.name, size.shown, size.interval) for _, _, size in told]
    if (late_s := late_in_all_s(finding)) is not None:
        sizes = [("", quantity(late_s, "s", digits=3), "")]
    (_, shown, interval), *others = sizes or [("", "", "")]
    yield f"{number}", name, where, shown, interval, sure
    for own, shown, interval in others:
        yield "", f"  {own}", "", shown, interval, ""


def _laid_out(row: Sequence[str], widths: Sequence[int]) -> str:
    """A row of the table: its second column goes on in the next line where it is long."""
    names = wrapped(row[1], widths[1])
    first = (row[0], names[0], *row[2:])
    line = "  ".join(cell.ljust(width) for cell, width in zip(first, widths, strict=True)).rstrip()
    return "\n".join([line, *(f"{' ' * (widths[0] + 2)}{name}" for name in names[1:])])


def _helps(diagnosis: Diagnosis) -> Part:
    """The error before and after, on this recording and held out, and the part that remains."""
    fit = diagnosis.fit
    before, after, floor, held_before, held_after = (
        quantity(size, fit.unit, digits=3)
        for size in (
            fit.rms_before_m, fit.rms_after_m, fit.noise_floor_m,
            fit.holdout_rms_before_m, fit.holdout_rms_after_m,
        )
    )  # fmt: skip
    held = say("screen.nothing_held_out")
    if math.isfinite(fit.holdout_rms_before_m) and math.isfinite(fit.holdout_rms_after_m):
        where, gone = say(f"screen.{fit.holdout}"), gain(diagnosis)
        before_held = without_unit_of(held_before, held_after)
        held = say("screen.held", where=where, before=before_held, after=held_after, gain=gone)
    noise = "" if doubtful_floor(fit) else say("screen.floor", floor=floor)
    title, before = fit_title(diagnosis), without_unit_of(before, after)
    says = say("screen.helps", title=title, before=before, after=after, floor=noise, held=held)
    if not diagnosis.findings:
        says = " ".join(fit_lines(diagnosis))
    return Part([line for line in (says, unexplained_line(diagnosis)) if line], turns=0, rank=1)


def _or_else(diagnosis: Diagnosis, ways: Ways) -> Part:
    """What else the findings could be, and the run or the measurement that would tell."""
    following = experiment_line(diagnosis)
    entries = [f"{following} {ways.run_it}"] if following else []
    for number, finding in enumerate(diagnosis.findings, 1):
        if tied(finding):
            way = (
                "" if following or diagnosis.open_ties else hint(finding, ways, diagnosis.pull_said)
            )
            entries.append(say("screen.other", number=number, names=other_causes(finding), way=way))
        elif text := as_well_line(finding):
            entries.append(say("screen.rarer", number=number, says=text))
    entries += tie_lines(diagnosis)
    if not entries and diagnosis.findings:
        entries = [say("alternatives.none")]
    return Part([entry.strip() for entry in entries], say("screen.or_else"), rank=2)


def _on_top(diagnosis: Diagnosis, robot: RobotModel | None, ways: Ways) -> list[str]:
    """Which findings are further sizes of what the robot file has already."""
    which = [
        f"{number}"
        for number, one in enumerate(diagnosis.findings, 1)
        if in_file(robot, one.effect, one.component)
    ]
    named = say("do.these" if len(which) > 1 else "do.this", numbers=listed(which))
    return [ways.on_top.format(which=named)] if which else []


def remarks(diagnosis: Diagnosis, ways: Ways) -> list[str]:
    """What was not read, not used or not compared, what is known from the robot file, and what
    the answer as a whole hangs on.
    """
    by_assumption = [
        by_priors(one)
        for one in diagnosis.prior_sensitivity
        if not any(is_about(one, finding) for finding in diagnosis.findings)
    ]
    return [
        *([say("summary.ended_early", way=ways.all_compared)] if diagnosis.ended_early else []),
        *(say("summary.left_out", why=why) for why in diagnosis.left_out),
        *(
            say("summary.thinned", hours=one.span_s / 3600, **one.model_dump())
            for one in diagnosis.thinned
        ),
        *(say("summary.not_read", why=why) for why in diagnosis.not_read),
        *(say("fit.held_out_left_out", why=why) for why in diagnosis.not_held_out),
        *of_the_file(diagnosis),
        *_agreement(diagnosis),
        *filter(None, [allowed_line(diagnosis)]),
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
    """One line: effects that could not be seen at all, then those that could not below a size."""
    names = [one.effect.replace("_", " ") for one in diagnosis.not_testable]
    limits = [one for one in diagnosis.smallest_detectable if one.parameter != "stiffness"]
    largest = {one.effect: one for one in sorted(limits, key=above_nothing)}
    order = dict.fromkeys(one.effect for one in limits)
    names = [*dict.fromkeys(names), *(_below(largest[name]) for name in order)]
    for shown in range(len(names), 0, -1):
        text, more = ", ".join(names[:shown]), len(names) - shown
        named = say("screen.and_more", names=text, number=more) if more else text
        if len(line := say("screen.not_shown", names=named)) <= width:
            return [line]
    return []


def _below(one: SmallestDetectable) -> str:
    return say("screen.below", name=one.effect.replace("_", " "), size=limit_alone(one))


def _rest(ways: Ways, steps_left: int) -> str:
    """Where everything else is."""
    more = say("screen.steps_left", steps=count(steps_left, "more step")) if steps_left else ""
    return ways.rest.format(more=more)
