"""The report of a diagnosis: one HTML file that needs no network.

One card a finding says what, how large, how sure, where, and what else it could be.
"""

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

from deltactl.charts.page import columns, heading, page, paragraph, table
from deltactl.diagnosis.answer.how_sure import alternatives_case, exclusive, settled
from deltactl.diagnosis.answer.records import Alternative, Diagnosis, Finding, ParameterResult
from deltactl.diagnosis.answer.verdict import as_well
from deltactl.diagnosis.answer.what_is_left import doubtful_floor
from deltactl.diagnosis.report.drawings import Pair, badge, hue, interval_bar, pair_bars
from deltactl.diagnosis.report.finding import (
    Span,
    alternatives_line,
    as_well_line,
    divided,
    finding_title,
    how_sure,
    in_chi_square,
    memory_line,
    notes,
    span_s,
    told_sizes,
    where_line,
)
from deltactl.diagnosis.report.fit import fit_lines, fit_title, share_line, unexplained_line
from deltactl.diagnosis.report.headline import opening
from deltactl.diagnosis.report.limits import limit_name, limit_size
from deltactl.diagnosis.report.machines import machine_drawing
from deltactl.diagnosis.report.mismatch import mismatch_sections
from deltactl.diagnosis.report.names import (
    all_followed,
    count,
    effect,
    listed,
    other_cause,
    percent,
    sentence,
)
from deltactl.diagnosis.report.next_run import experiment_line, hint, made_to_distinguish, tie_lines
from deltactl.diagnosis.report.remedies import remedies
from deltactl.diagnosis.report.screen import remarks
from deltactl.diagnosis.report.sizes import Size, departure, forced, number, scale_of
from deltactl.diagnosis.report.templates import TERMINAL, Ways, say
from deltactl.foundation.plain_file import said_of_output, write_whole
from deltactl.foundation.release import own_version
from deltactl.models.effects import Trait, has
from deltactl.models.robot import RobotModel

NOT_FROM_ZERO = frozenset(
    {"time", "time_constant", "period", "height", "frequency", "stiffness", "times_s", "speed"}
)
"""Parameters for which zero is not 'nothing wrong', so that a bar from zero would mislead."""


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
        *_details(diagnosis),
        *_origin(diagnosis, origin),
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
        f'<p><strong>{what}</strong></p><ul class="do">{do}</ul>' if do else "",
        *map(paragraph, (*remarks(diagnosis, ways), *tie_lines(diagnosis))),
    ]
    return f'<section class="verdict {diagnosis.verdict}">{"".join(parts)}</section>'


def _improvement(diagnosis: Diagnosis) -> str:
    fit, found = diagnosis.fit, bool(diagnosis.findings)
    scale, doubtful = scale_of(fit.unit), doubtful_floor(fit)
    held = say("page.another_run" if fit.holdout == "run" else "page.held_out_parts")
    pairs = [
        Pair(name, scale(before), scale(after) if found else math.nan)
        for name, before, after in (
            (say("page.this_recording"), fit.rms_before_m, fit.rms_after_m),
            (held, fit.holdout_rms_before_m, fit.holdout_rms_after_m),
        )
    ]
    floor = math.nan if doubtful else scale(fit.noise_floor_m)
    bars = pair_bars(fit_title(diagnosis), pairs, floor, scale.unit)
    doubt = doubtful or not math.isfinite(floor)
    case = "page.rms" if not found else "page.rms_no_floor" if doubt else "page.rms_floor"
    lines = "".join(map(paragraph, fit_lines(diagnosis)))
    return f"{bars}{lines}{paragraph(say(case), 'note')}"


def _findings(diagnosis: Diagnosis, ways: Ways) -> list[str]:
    cards = finding_cards(diagnosis, span_s(diagnosis), ways)
    if not cards:
        nothing = diagnosis.verdict == "nothing_missing"
        cards = [paragraph(say("page.nothing_shown" if nothing else "page.nothing_named"))]
    return [heading(say("page.what_is_wrong")), *cards]


def _open_questions(diagnosis: Diagnosis, robot: RobotModel) -> list[str]:
    left = unexplained_line(diagnosis) or say("page.nothing")
    parts = [heading(say("page.what_is_left")), paragraph(left)]
    if untested := diagnosis.not_testable:
        rows = [(effect(one.effect, one.component), one.why) for one in untested]
        parts += [
            heading(say("page.not_testable")),
            _folded(say("page.not_tested", effects=count(len(rows), "effect")), rows, "page.why"),
        ]
    if tested := diagnosis.smallest_detectable:
        force = forced(diagnosis.fit.unit)
        limits = [
            (limit_name(one.effect, [one.component], robot, force), limit_size(one, robot))
            for one in tested
        ]
        effects = say("page.tested", effects=count(len(tested), "effect"))
        parts += [
            heading(say("page.limits")),
            paragraph(say("page.about_limits")),
            _folded(effects, limits, "page.size_shown"),
        ]
    return parts


def _folded(summary: str, rows: Iterable[tuple[str, str]], second: str) -> str:
    shown = [(sentence(first).rstrip("."), more) for first, more in rows]
    inside = table((say("page.effect"), say(second)), shown, numbers_from=9)
    return f"<details><summary>{html.escape(summary)}</summary>{inside}</details>"


def _next(diagnosis: Diagnosis) -> list[str]:
    plan = diagnosis.next_experiment
    if plan is None:
        return []
    job = yaml.safe_dump(_plain(plan.job), sort_keys=False, allow_unicode=True)
    return [
        heading(say("summary.next")),
        paragraph(experiment_line(diagnosis)),
        paragraph(say("page.save_job")),
        f"<pre>{html.escape(job)}</pre>",
    ]


def _details(diagnosis: Diagnosis) -> list[str]:
    parts = [heading(say("page.all_figures"))]
    if diagnosis.findings:
        head = say("page.columns").split("|")
        inside = table(head, list(_all_numbers(diagnosis.findings)), 4)
        parts.append(f"<details><summary>{say('page.every_parameter')}</summary>{inside}</details>")
    if (unit := diagnosis.fit.unit) != "m":
        parts.append(paragraph(say("page.unit", unit=unit), "note"))
    answer = json.dumps(_plain(diagnosis.to_json()), indent=1, ensure_ascii=False)
    inside = f"<pre>{html.escape(answer)}</pre>"
    return [*parts, f"<details><summary>{say('page.as_json')}</summary>{inside}</details>"]


def _origin(diagnosis: Diagnosis, origin: Origin) -> list[str]:
    """When, with what and from what the report was made."""
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
    return [heading(say("page.made")), table(("", ""), rows, numbers_from=9)]


def _plain(value: Any) -> Any:
    """Without NaN, which JSON does not know, and without tuples."""
    if isinstance(value, dict):
        return {str(key): _plain(inner) for key, inner in value.items()}
    if isinstance(value, list | tuple):
        return [_plain(inner) for inner in value]
    return None if isinstance(value, float) and not math.isfinite(value) else value


def _all_numbers(findings: Sequence[Finding]) -> Iterator[tuple[str, ...]]:
    """Rows of every parameter in SI units, as in the answer."""
    for row, one in enumerate(findings, 1):
        for name, size in one.parameters.items():
            sizes = (_si(size.value), _si(size.ci95), size.unit)
            yield f"{row}", one.effect, one.component, name, *sizes


def _si(value: object) -> str:
    if isinstance(value, list):
        return f"[{', '.join(map(_si, value))}]"
    if isinstance(value, float | int) and math.isfinite(value):
        return f"{value:.6g}"
    return "\u2013"


def finding_cards(diagnosis: Diagnosis, span: Span, ways: Ways = TERMINAL) -> list[str]:
    """All findings as cards, the strongest first as the answer has them."""
    return [
        _card(row, finding, diagnosis, span, ways)
        for row, finding in enumerate(diagnosis.findings, 1)
    ]


def _card(row: int, finding: Finding, diagnosis: Diagnosis, span: Span, ways: Ways) -> str:
    share = math.isfinite(finding.share_of_mismatch)
    lines = {
        "size": _sizes(finding, diagnosis),
        "how_sure": html.escape(" ".join(how_sure(finding, diagnosis))),
        "share": html.escape(share_line(finding, diagnosis.fit)) if share else "",
        "where": html.escape(where_line(finding, span)),
        "depends_on": html.escape(_depends(finding)),
        "or_else": _alternatives(finding, diagnosis, ways),
        "statistics": html.escape(in_chi_square(finding, row == 1)),
    }
    body = (f"<dt>{say(f'card.{key}')}</dt><dd>{text}</dd>" for key, text in lines.items() if text)
    return (
        f'<section class="finding hue{hue(row)}" id="finding-{row}"><h3>{badge(row)}'
        f"{html.escape(finding_title(finding))}</h3><dl>{''.join(body)}</dl></section>"
    )


def _sizes(finding: Finding, diagnosis: Diagnosis) -> str:
    parts = [html.escape(divided(finding))]
    for name, result, size in told_sizes(finding):
        bar = _bar(finding, name, result, size, diagnosis)
        text = html.escape(f"{size.name}: {size.text}")
        parts.append(f'<div class="size">{text}{bar}</div>')
    parts += [f"<div>{html.escape(note)}</div>" for note in notes(finding, diagnosis)]
    return "".join(parts)


def _bar(
    finding: Finding, name: str, result: ParameterResult, size: Size, diagnosis: Diagnosis
) -> str:
    """The interval on a line, with the smallest visible size where the answer gives one."""
    duration = has(finding.effect, Trait.DELAY) and name == "time"
    if name in NOT_FROM_ZERO and not duration:
        return ""
    own = (finding.effect, finding.component, name)
    smallest = (
        departure(one.value, one.unit, name) * scale_of(one.unit, name, result.value).factor
        for one in diagnosis.smallest_detectable
        if own == (one.effect, one.component, one.parameter) and isinstance(result.value, float)
    )
    return interval_bar(size, 0.0, next(smallest, math.nan))


def _depends(finding: Finding) -> str:
    return f"{sentence(all_followed(finding.depends_on))} {memory_line(finding)}".strip()


def _alternatives(finding: Finding, diagnosis: Diagnosis, ways: Ways) -> str:
    """What else it may be: how much worse each fits, its probability standing under How sure."""
    if not finding.alternatives:
        return html.escape(alternatives_line(finding))
    surely = settled(finding)
    shown = [one for one in finding.alternatives if not (surely and as_well(one))]
    same = as_well_line(finding) if surely else ""
    head = say("alternatives.far_less_head") if surely and shown else ""
    if alternatives_case(finding) == "open":
        head = say("card.cannot_tell")
    told = " ".join(map(html.escape, filter(None, (same, head))))
    way = say("run.made_for_it")
    if not made_to_distinguish(finding, diagnosis):
        way = hint(finding, ways, diagnosis.pull_said)
    if not shown:
        return f"{told} {html.escape(way)}".strip()
    rows = "".join(_rival(finding, one) for one in shown)
    return f"{told}<ul>{rows}</ul>{html.escape(way)}"


def _rival(finding: Finding, other: Alternative) -> str:
    name = html.escape(other_cause(finding.effect, other.effect, other.component))
    known = other.probability is not None and exclusive(finding)
    parts = [percent(other.probability or 0.0)] if known else []
    if math.isfinite(other.delta_chi2):
        which = "worse" if other.delta_chi2 >= 0.0 else "better"
        size, unit = number(abs(other.delta_chi2), 1), say("evidence.chi_square")
        case = "as_well" if as_well(other) else which
        parts.append(say(f"card.fits_{case}", size=size, unit=unit))
    note = f' <span class="note">({"; ".join(parts)})</span>' if parts else ""
    return f"<li>{name}{note}</li>"
