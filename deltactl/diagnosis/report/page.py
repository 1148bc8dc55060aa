"""The report of a diagnosis: one HTML file that needs no network."""

from __future__ import annotations

import html
import json
import math
from collections.abc import Iterable, Iterator, Sequence
from dataclasses import dataclass
from datetime import datetime
from functools import cache
from importlib.resources import files
from pathlib import Path
from typing import Any

import yaml

from deltactl.charts.page import columns, facts, folded, heading, page, paragraph, unfolds
from deltactl.charts.scenes import badge, hue
from deltactl.diagnosis.answer.records import Diagnosis, Finding
from deltactl.diagnosis.answer.what_is_left import doubtful_floor
from deltactl.diagnosis.report.finding import (
    Span,
    finding_title,
    how_sure,
    open_causes,
    other_causes,
    span_s,
    where_line,
    without_line,
)
from deltactl.diagnosis.report.fit import (
    Pair,
    fit_line,
    fit_title,
    more_of_the_fit,
    pair_bars,
    unexplained,
)
from deltactl.diagnosis.report.headline import opening
from deltactl.diagnosis.report.limits import limit_name, limit_size
from deltactl.diagnosis.report.machines import machine_drawing
from deltactl.diagnosis.report.mismatch import mismatch_sections
from deltactl.diagnosis.report.names import count, effect, listed, sentence, upper
from deltactl.diagnosis.report.next_run import experiment_line, hint, made_to_distinguish, tie_lines
from deltactl.diagnosis.report.pairs import beside
from deltactl.diagnosis.report.remedies import remedies
from deltactl.diagnosis.report.screen import remarks, table_rows
from deltactl.diagnosis.report.sizes import in_its_units, scale_of
from deltactl.diagnosis.report.templates import TERMINAL, Ways, say
from deltactl.foundation.plain_file import said_of_output, write_whole
from deltactl.foundation.release import own_version
from deltactl.models.robot import RobotModel


@dataclass(frozen=True, slots=True)
class Origin:
    """Where a report comes from, as far as known."""

    robot_file: str = ""
    columns: Sequence[str] = ()
    """Those that were read, with what they are called in the file."""
    command: str = ""
    remarks: Sequence[str] = ()
    """On what was read."""


def write_report(
    diagnosis: Diagnosis,
    robot: RobotModel,
    path: Path,
    ways: Ways = TERMINAL,
    origin: Origin = Origin(),
) -> None:
    """Write the report; an earlier one is replaced whole or not at all. Raises RecordingError."""
    text = report_html(diagnosis, robot, ways, origin)
    with said_of_output(path):
        write_whole(path, text)


@in_its_units
def report_html(
    diagnosis: Diagnosis, robot: RobotModel, ways: Ways = TERMINAL, origin: Origin = Origin()
) -> str:
    """The report as one HTML document."""
    parts = [
        _verdict(diagnosis, robot, ways),
        columns([machine_drawing(robot, diagnosis.findings), _improvement(diagnosis)]),
        *_findings(diagnosis, ways),
        *mismatch_sections(diagnosis, robot),
        *_open_questions(diagnosis, robot),
        *_next(diagnosis),
        *_details(diagnosis, origin),
    ]
    names = listed(diagnosis.recordings)
    lead = say("page.lead", recordings=names) if names else ""
    return page(say("page.title", robot=robot.name), parts, lead=lead, extra_style=style())


@cache
def style() -> str:
    """The report's style sheet."""
    return (files("deltactl.diagnosis.report") / "report.css").read_text(encoding="utf-8")


def _verdict(diagnosis: Diagnosis, robot: RobotModel, ways: Ways) -> str:
    do = "".join(f"<li>{html.escape(line)}</li>" for line in remedies(diagnosis, robot, ways))
    what = html.escape(say("summary.do_this"))
    parts = [
        *map(paragraph, opening(diagnosis)),
        f'<p><strong>{what}</strong></p><ol class="do">{do}</ol>' if do else "",
        *map(paragraph, (*remarks(diagnosis, ways), *tie_lines(diagnosis))),
    ]
    return f'<section class="verdict {diagnosis.verdict}">{"".join(parts)}</section>'


def _improvement(diagnosis: Diagnosis) -> str:
    fit, found = diagnosis.fit, bool(diagnosis.findings)
    scale = scale_of(fit.unit)
    pairs = [
        Pair(name, scale(before), scale(after) if found else math.nan)
        for name, before, after in (
            (say("page.this_recording"), fit.rms_before_m, fit.rms_after_m),
            (say(f"page.{fit.holdout}"), fit.holdout_rms_before_m, fit.holdout_rms_after_m),
        )
    ]
    floor = math.nan if doubtful_floor(fit) else scale(fit.noise_floor_m)
    bars = pair_bars(fit_title(diagnosis), pairs, floor, scale.unit)
    held = say(f"page.not_fitted_{fit.holdout}")
    lines = map(paragraph, (fit_line(diagnosis), *more_of_the_fit(fit)))
    return f"{bars}{''.join(lines)}{paragraph(say('page.rms', held=held), 'note')}"


def _findings(diagnosis: Diagnosis, ways: Ways) -> list[str]:
    """A table: of each finding its sizes, and below them all that goes with it."""
    head = heading(say("page.what_is_wrong"))
    if not diagnosis.findings:
        return [head, paragraph(say("page.nothing"))]
    titles = "".join(f"<th>{title}</th>" for title in say("screen.columns").split("|"))
    rows = "".join(finding_rows(diagnosis, span_s(diagnosis), ways))
    inside = f'<table class="findings"><thead><tr>{titles}</tr></thead>{rows}</table>'
    return [head, f'<div class="wide">{inside}</div>']


def finding_rows(diagnosis: Diagnosis, span: Span, ways: Ways = TERMINAL) -> list[str]:
    """The rows of each finding, the strongest first as the answer has them."""
    found = []
    for number, finding in enumerate(diagnosis.findings, 1):
        first, *more = (list(map(html.escape, row[1:])) for row in table_rows(number, finding))
        rows = [[badge(number), *first], *(["", *row] for row in more)]
        cells = "".join(f"<tr>{''.join(f'<td>{cell}</td>' for cell in row)}</tr>" for row in rows)
        title = f"<p><strong>{html.escape(finding_title(finding))}</strong></p>"
        lines = map(paragraph, _beside_sizes(finding, diagnosis, span, ways))
        found.append(
            f'<tbody class="hue{hue(number)}" id="finding-{number}">{cells}'
            f'<tr><td></td><td colspan="5">{title}{"".join(lines)}</td></tr></tbody>'
        )
    return found


def _beside_sizes(finding: Finding, diagnosis: Diagnosis, span: Span, ways: Ways) -> Iterator[str]:
    """Where it shows, how sure it is, what it is worth, and what else it could be."""
    fit = diagnosis.fit
    parts = (where_line(finding, span), without_line(finding, fit.unit, fit.rms_before_m))
    yield from filter(None, (*parts, *beside(finding, diagnosis)))
    yield from how_sure(finding, diagnosis)
    if not finding.alternatives:
        return
    way = ""
    if open_causes(finding):
        made = made_to_distinguish(finding, diagnosis)
        way = say("run.made_for_it") if made else upper(hint(finding, diagnosis, ways))
    yield say("other.line", names=other_causes(finding, in_full=True), way=way).strip()


def _open_questions(diagnosis: Diagnosis, robot: RobotModel) -> list[str]:
    left = sentence(diagnosis.unexplained.says or unexplained(diagnosis))
    parts = [heading(say("page.what_is_left")), paragraph(left)]
    untested, tested = diagnosis.not_testable, diagnosis.smallest_detectable
    if untested or tested:
        parts.append(heading(say("page.limits")))
    if untested:
        rows = [(effect(one.effect, one.component), one.why) for one in untested]
        parts.append(_folded(say("page.not_tested", effects=count(len(rows), "effect")), rows))
    if tested:
        rows = [(limit_name(one.effect, [one.component], robot), limit_size(one)) for one in tested]
        parts.append(paragraph(say("page.about_limits")))
        parts.append(_folded(say("page.tested", effects=count(len(rows), "effect")), rows))
    return parts


def _folded(summary: str, rows: Iterable[tuple[str, str]]) -> str:
    shown = [(sentence(first).rstrip("."), more) for first, more in rows]
    return unfolds(summary, [facts(shown)])


def _next(diagnosis: Diagnosis) -> list[str]:
    plan = diagnosis.next_experiment
    if plan is None:
        return []
    job = yaml.safe_dump(_plain(plan.job), sort_keys=False, allow_unicode=True)
    lines = map(paragraph, (experiment_line(diagnosis), say("page.save_job")))
    return [heading(say("page.next")), *lines, f"<pre>{html.escape(job)}</pre>"]


def _details(diagnosis: Diagnosis, origin: Origin) -> list[str]:
    """When, with what and from what the report was made, and the answer as JSON."""
    answer = json.dumps(_plain(diagnosis.to_json()), indent=1, ensure_ascii=False)
    values = (
        f"{datetime.now().astimezone():%Y-%m-%d %H:%M}",
        own_version(),
        origin.robot_file or diagnosis.robot,
        ", ".join(diagnosis.recordings),
        ", ".join(origin.columns),
        origin.command,
        " ".join(origin.remarks),
    )
    rows = [row for row in zip(say("page.origin").split("|"), values, strict=True) if row[1]]
    return [
        heading(say("page.made")),
        facts(rows),
        folded(say("page.as_json"), answer),
    ]


def _plain(value: Any) -> Any:
    """Without NaN, which JSON does not know, and without tuples."""
    if isinstance(value, dict):
        return {str(key): _plain(inner) for key, inner in value.items()}
    if isinstance(value, list | tuple):
        return [_plain(inner) for inner in value]
    return None if isinstance(value, float) and not math.isfinite(value) else value
