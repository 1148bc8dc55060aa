"""The report of a diagnosis: one HTML file that needs no network."""

from __future__ import annotations

import html
import json
import math
from collections.abc import Iterable
from functools import cache
from importlib.resources import files
from pathlib import Path
from typing import Any

import yaml

from deltactl.charts.page import columns, heading, page, paragraph, table
from deltactl.diagnosis.answer.records import Diagnosis
from deltactl.diagnosis.report.drawing import machine_drawing
from deltactl.diagnosis.report.page.bars import Pair, pair_bars
from deltactl.diagnosis.report.page.cards import all_numbers, finding_cards
from deltactl.diagnosis.report.page.pictures import mismatch_sections
from deltactl.diagnosis.report.phrases import words
from deltactl.diagnosis.report.phrases.fit_words import fit_lines, fit_title
from deltactl.diagnosis.report.phrases.left_words import doubtful_floor
from deltactl.diagnosis.report.phrases.limit_words import by_effort, limit_name, limit_size
from deltactl.diagnosis.report.phrases.sizes import scale_of
from deltactl.diagnosis.report.sentences.finding_words import span_s
from deltactl.diagnosis.report.sentences.headline import opening
from deltactl.diagnosis.report.sentences.next_run_words import experiment_line
from deltactl.diagnosis.report.sentences.remedies import remedies
from deltactl.diagnosis.report.sentences.summary import of_the_file, remarks, unexplained_line
from deltactl.diagnosis.report.sentences.ways import TERMINAL, Ways
from deltactl.foundation.errors import RecordingError
from deltactl.foundation.plain_file import write_whole
from deltactl.models.robot import RobotModel


def write_report(
    diagnosis: Diagnosis, robot: RobotModel, path: Path, ways: Ways = TERMINAL
) -> None:
    """Write the report; an earlier one is replaced whole or not at all. Raises RecordingError."""
    text = report_html(diagnosis, robot, ways)
    try:
        write_whole(path, text)
    except OSError as error:
        raise RecordingError(f"{path}: cannot be written ({error.strerror})") from error


def report_html(diagnosis: Diagnosis, robot: RobotModel, ways: Ways = TERMINAL) -> str:
    """The report as one HTML document."""
    parts = [
        _verdict(diagnosis, robot, ways),
        columns([machine_drawing(robot, diagnosis.findings), _improvement(diagnosis)]),
        *_findings(diagnosis, ways),
        *mismatch_sections(diagnosis, robot),
        *_open_questions(diagnosis, robot),
        *_next(diagnosis),
        *_details(diagnosis),
    ]
    lead = f"Recorded in {words.listed(diagnosis.recordings)}." if diagnosis.recordings else ""
    return page(f"Diagnosis of {robot.name}", parts, lead=lead, extra_style=_style())


@cache
def _style() -> str:
    return (files("deltactl.diagnosis.report.page") / "report.css").read_text(encoding="utf-8")


def _verdict(diagnosis: Diagnosis, robot: RobotModel, ways: Ways) -> str:
    lines = [*of_the_file(diagnosis), *remarks(diagnosis, ways)]
    do = "".join(f"<li>{html.escape(line)}</li>" for line in remedies(diagnosis, robot, ways))
    body = "".join(map(paragraph, opening(diagnosis)))
    body += f'<p><strong>Do this</strong></p><ul class="do">{do}</ul>' if do else ""
    body += "".join(paragraph(line) for line in lines)
    return f'<section class="verdict {diagnosis.verdict}">{body}</section>'


def _improvement(diagnosis: Diagnosis) -> str:
    fit = diagnosis.fit
    scale = scale_of(fit.unit)
    held = "another run" if fit.holdout == "run" else "held-out parts"
    pairs = [
        Pair(name, scale(before), scale(after) if diagnosis.findings else math.nan)
        for name, before, after in (
            ("this recording", fit.rms_before_m, fit.rms_after_m),
            (held, fit.holdout_rms_before_m, fit.holdout_rms_after_m),
        )
    ]
    floor = math.nan if doubtful_floor(fit) else scale(fit.noise_floor_m)
    bars = pair_bars(fit_title(diagnosis), pairs, floor, scale.unit)
    about = "Root mean square of measured minus predicted."
    if diagnosis.findings:
        below = "Below the noise floor the tests see nothing more; no"
        start = below if math.isfinite(floor) else "No"
        about += f" {start} size was fitted to held-out data."
    lines = "".join(paragraph(line) for line in fit_lines(diagnosis))
    return f"{bars}{lines}{paragraph(about, 'note')}"


def _findings(diagnosis: Diagnosis, ways: Ways) -> list[str]:
    cards = finding_cards(diagnosis, span_s(diagnosis), ways)
    if not cards:
        nothing = diagnosis.verdict == "nothing_missing"
        text = "that this recording can show" if nothing else "that could be named"
        return [heading("What is wrong"), paragraph(f"Nothing {text}.")]
    return [heading("What is wrong"), *cards]


def _open_questions(diagnosis: Diagnosis, robot: RobotModel) -> list[str]:
    parts = [heading("What is left"), paragraph(unexplained_line(diagnosis) or "Nothing.")]
    if rest := diagnosis.not_testable:
        rows = [(words.effect(o.effect, o.component), words.spelled(o.why)) for o in rest]
        parts += [
            heading("What this recording could not test"),
            _folded(f"{words.count(len(rows), 'effect')} not tested", rows, ("effect", "why")),
        ]
    if diagnosis.smallest_detectable:
        parts += [
            heading("Detection limits"),
            paragraph(
                "At these sizes four recordings of five show that something is missing; naming "
                "the effect may take more. Smaller effects may be there without showing."
            ),
            _folded(
                f"{words.count(len(diagnosis.smallest_detectable), 'effect')} tested",
                _smallest(diagnosis, robot),
                ("effect", "size that four recordings of five show"),
            ),
        ]
    return parts


def _smallest(diagnosis: Diagnosis, robot: RobotModel) -> Iterable[tuple[str, str]]:
    for one in diagnosis.smallest_detectable:
        name = limit_name(one.effect, [one.component], robot, by_effort(diagnosis))
        yield name, limit_size(one, robot)


def _next(diagnosis: Diagnosis) -> list[str]:
    plan = diagnosis.next_experiment
    if plan is None:
        return []
    job = yaml.safe_dump(_plain(plan.job), sort_keys=False, allow_unicode=True)
    return [
        heading("What to do next"),
        paragraph(experiment_line(diagnosis)),
        paragraph(
            "Save this as job.yaml, run it with deltactl run job.yaml, and diagnose both "
            "recordings together:"
        ),
        f"<pre>{html.escape(job)}</pre>",
    ]


def _details(diagnosis: Diagnosis) -> list[str]:
    parts = [heading("All figures")]
    if diagnosis.findings:
        head = ("", "effect", "component", "parameter", "value", "95 % interval", "unit")
        rows = list(all_numbers(diagnosis.findings))
        parts.append(
            f"<details><summary>Every parameter in SI units</summary>{table(head, rows, 4)}"
            "</details>"
        )
    if (unit := diagnosis.fit.unit) != "m":
        says = f"In fit, the figures whose names end in _m are in {unit} here, as fit.unit says."
        parts.append(paragraph(says, "note"))
    answer = json.dumps(_plain(diagnosis.to_json()), indent=1, ensure_ascii=False)
    parts.append(
        f"<details><summary>The answer as JSON</summary><pre>{html.escape(answer)}</pre></details>"
    )
    return parts


def _folded(summary: str, rows: Iterable[tuple[str, str]], head: tuple[str, str]) -> str:
    shown = [(words.sentence(first).rstrip("."), second) for first, second in rows]
    inside = table(head, shown, numbers_from=9)
    return f"<details><summary>{html.escape(summary)}</summary>{inside}</details>"


def _plain(value: Any) -> Any:
    """Without NaN, which JSON does not know, and without tuples."""
    if isinstance(value, dict):
        return {str(key): _plain(inner) for key, inner in value.items()}
    if isinstance(value, list | tuple):
        return [_plain(inner) for inner in value]
    if isinstance(value, float) and not math.isfinite(value):
        return None
    return value
