"""One card a finding: what, how large, how sure, where, what else it could be."""

from __future__ import annotations

import html
import math
from collections.abc import Iterable, Sequence

from deltactl.diagnosis.answer.records import Alternative, Diagnosis, Finding, ParameterResult
from deltactl.diagnosis.answer.verdict import as_well
from deltactl.diagnosis.report.drawing.machine import badge
from deltactl.diagnosis.report.drawing.scene import hue
from deltactl.diagnosis.report.page.bars import interval_bar
from deltactl.diagnosis.report.phrases import sureness, words
from deltactl.diagnosis.report.phrases.percent import percent
from deltactl.diagnosis.report.phrases.rivals import as_well_line, exclusive
from deltactl.diagnosis.report.phrases.share_words import share_line
from deltactl.diagnosis.report.phrases.sizes import Size, departure, number, scale_of
from deltactl.diagnosis.report.phrases.sureness import in_chi_square
from deltactl.diagnosis.report.sentences.finding_words import (
    FAR_LESS,
    alternatives_line,
    divided,
    finding_title,
    memory_line,
    told_sizes,
    where_line,
)
from deltactl.diagnosis.report.sentences.notes import how_sure, notes
from deltactl.diagnosis.report.sentences.telling_apart import hint
from deltactl.diagnosis.report.sentences.ways import TERMINAL, Ways
from deltactl.models.effects import Trait, has

NOT_FROM_ZERO = frozenset(
    {"time", "time_constant", "period", "height", "frequency", "stiffness", "times_s", "speed"}
)
"""Parameters for which zero is not 'nothing wrong', so that a bar from zero would mislead."""


def finding_cards(
    diagnosis: Diagnosis, span: tuple[float, float], ways: Ways = TERMINAL
) -> list[str]:
    """All findings as cards, the strongest first as the answer has them."""
    return [
        _card(number, finding, diagnosis, span, ways)
        for number, finding in enumerate(diagnosis.findings, 1)
    ]


def _card(
    number: int, finding: Finding, diagnosis: Diagnosis, span: tuple[float, float], ways: Ways
) -> str:
    rows = [
        ("Size", _sizes(finding, diagnosis)),
        ("How sure", _text(" ".join(how_sure(finding, diagnosis)))),
        ("Share", _share(finding, diagnosis)),
        ("Where", _text(where_line(finding, span))),
        ("Depends on", _depends(finding)),
        ("Or else", _alternatives(finding, diagnosis, ways)),
        ("Statistics", _text(in_chi_square(finding, number == 1))),
    ]
    body = "".join(f"<dt>{name}</dt><dd>{inside}</dd>" for name, inside in rows if inside)
    return (
        f'<section class="finding hue{hue(number)}" id="finding-{number}">'
        f"<h3>{badge(number)}{html.escape(finding_title(finding))}</h3><dl>{body}</dl></section>"
    )


def _sizes(finding: Finding, diagnosis: Diagnosis) -> str:
    parts = [_text(divided(finding))]
    for name, result, size in told_sizes(finding):
        text = f'<div class="size">{html.escape(f"{size.name}: {size.text}")}'
        parts.append(f"{text}{_bar(finding, name, result, size, diagnosis)}</div>")
    parts += [f"<div>{_text(note)}</div>" for note in notes(finding, diagnosis)]
    return "".join(parts)


def _bar(
    finding: Finding, name: str, result: ParameterResult, size: Size, diagnosis: Diagnosis
) -> str:
    duration = has(finding.effect, Trait.DELAY) and name == "time"
    if name in NOT_FROM_ZERO and not duration:
        return ""
    return interval_bar(size, 0.0, _smallest(finding, name, result, size, diagnosis))


def _smallest(
    finding: Finding, name: str, result: ParameterResult, size: Size, diagnosis: Diagnosis
) -> float:
    """Smallest visible size in the unit of `size`; NaN where the answer gives none."""
    for one in diagnosis.smallest_detectable:
        same = (one.effect, one.component, one.parameter) == (
            finding.effect, finding.component, name,
        )  # fmt: skip
        if same and isinstance(result.value, float):
            factor = scale_of(one.unit, name, result.value).factor
            return departure(one.value, one.unit, name) * factor
    return math.nan


def _share(finding: Finding, diagnosis: Diagnosis) -> str:
    if not math.isfinite(finding.share_of_mismatch):
        return ""
    return _text(share_line(finding, diagnosis.fit))


def _depends(finding: Finding) -> str:
    follows = words.listed([words.followed(name) for name in finding.depends_on])
    if not follows and finding.has_memory is None:
        return ""
    return _text(f"{words.sentence(follows)} {memory_line(finding)}".strip())


def _alternatives(finding: Finding, diagnosis: Diagnosis, ways: Ways) -> str:
    """What else it may be: how much worse each fits, its probability standing under How sure."""
    if not finding.alternatives:
        return _text(alternatives_line(finding))
    apart, settled = exclusive(finding), sureness.settled(finding)
    listed = [one for one in finding.alternatives if not (settled and as_well(one))]
    rows = "".join(
        f"<li>{html.escape(words.rival(finding.effect, one.effect, one.component))}"
        f"{_worse(one, apart)}</li>"
        for one in listed
    )
    told = ""
    if settled:
        same = _text(as_well_line(finding))
        if not listed:
            return f"{same} {_text(_told_apart(finding, diagnosis, ways))}".strip()
        told = f"{same} {FAR_LESS}".strip()
    elif alternatives_line(finding):
        told = "This recording cannot tell it from"
    return f"{told}<ul>{rows}</ul>{_text(_told_apart(finding, diagnosis, ways))}"


def _worse(other: Alternative, apart: bool) -> str:
    """apart: its probability is a share of one whole."""
    known = other.probability is not None and apart
    notes = [percent(other.probability or 0.0)] if known else []
    if math.isfinite(other.delta_chi2):
        notes.append("fits as well" if as_well(other) else f"fits {_than(other.delta_chi2)}")
    return f' <span class="note">({"; ".join(notes)})</span>' if notes else ""


def _than(delta_chi2: float) -> str:
    size = number(abs(delta_chi2), 1)
    which = "worse" if delta_chi2 >= 0.0 else "better"
    return f"{size} {which} in {sureness.CHI_SQUARE}"


def _told_apart(finding: Finding, diagnosis: Diagnosis, ways: Ways) -> str:
    """What would distinguish them."""
    plan = diagnosis.next_experiment
    mine = {words.effect(finding.effect, finding.component)}
    mine |= {words.effect(one.effect, one.component) for one in finding.alternatives}
    apart = [words.spelled(name) for name in plan.tells_apart] if plan is not None else []
    if any(name in text for name in mine for text in apart):
        return "The run proposed below is made to distinguish them."
    return hint(finding, ways, diagnosis.pull_said)


def _text(text: str) -> str:
    return html.escape(text)


def all_numbers(findings: Sequence[Finding]) -> Iterable[tuple[str, ...]]:
    """Rows of every parameter in SI units, as in the answer."""
    for number_, finding in enumerate(findings, 1):
        for name, result in finding.parameters.items():
            yield (
                f"{number_}", finding.effect, finding.component, name, _si(result.value),
                _si(result.ci95), result.unit,
            )  # fmt: skip


def _si(value: object) -> str:
    if isinstance(value, list):
        return "[" + ", ".join(_si(one) for one in value) + "]"
    if isinstance(value, float | int) and math.isfinite(value):
        return f"{value:.6g}"
    return "\u2013"
