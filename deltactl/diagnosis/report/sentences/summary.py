"""The summary in the terminal: plain sentences, the most important first."""

from __future__ import annotations

import math
from collections.abc import Iterator

from rich.markup import escape

from deltactl.diagnosis.answer.records import Diagnosis, Finding, Thinned
from deltactl.diagnosis.answer.verdict import claimed, too_little
from deltactl.diagnosis.report.phrases import sureness, words
from deltactl.diagnosis.report.phrases.allowed_words import allowed_line
from deltactl.diagnosis.report.phrases.fit_words import fit_lines, fit_title
from deltactl.diagnosis.report.phrases.known_words import known_line
from deltactl.diagnosis.report.phrases.limit_words import faintest_line, untested_lines
from deltactl.diagnosis.report.phrases.sizes import quantity
from deltactl.diagnosis.report.sentences.finding_words import finding_lines, finding_title, span_s
from deltactl.diagnosis.report.sentences.headline import SO_LITTLE, opening
from deltactl.diagnosis.report.sentences.next_run_words import experiment_line, tie_lines
from deltactl.diagnosis.report.sentences.remedies import remedies
from deltactl.diagnosis.report.sentences.remedy import tied
from deltactl.diagnosis.report.sentences.telling_apart import hint
from deltactl.diagnosis.report.sentences.ways import TERMINAL, Ways
from deltactl.models.robot import RobotModel

ENDED_EARLY = (
    "The search stopped at its limit of work, with the best explanation so far: not everything was "
    "compared ({way})."
)
BESIDE_KNOWN = (
    "What is left beyond the noise ({left}) is less than a tenth of what the effects in the robot"
    " file explain ({known})"
)
UNEXPLAINED = "Unexplained beyond the noise: {} (root mean square)"
WHY = "Why"
"""Title above the reasons: what comes before is what to do."""


def summary_lines(
    diagnosis: Diagnosis, robot: RobotModel | None = None, ways: Ways = TERMINAL
) -> list[str]:
    """The summary as lines of rich markup, everything that came from outside escaped.

    robot: whose lengths what is to be done is said in.
    """
    lines = []
    for number, (style, line) in enumerate(_summary(diagnosis, robot, ways)):
        if style == "head" and number:
            lines.append("")
        text = escape(line)
        if text.endswith("\\"):
            text += "\\"  # a lone backslash would escape the closing tag
        lines.append(f"[bold]{text}[/bold]" if style == "head" else text)
    return lines


def plain_lines(
    diagnosis: Diagnosis, robot: RobotModel | None = None, ways: Ways = TERMINAL
) -> list[str]:
    """The same lines without markup."""
    return [line for _, line in _summary(diagnosis, robot, ways)]


def head_lines(diagnosis: Diagnosis) -> list[str]:
    """Those of them that are titles."""
    return [line for style, line in _summary(diagnosis, None) if style == "head"]


def _summary(
    diagnosis: Diagnosis, robot: RobotModel | None, ways: Ways = TERMINAL
) -> Iterator[tuple[str, str]]:
    first, *others = opening(diagnosis)
    yield "head", first
    yield from (("", line) for line in others)
    if do := remedies(diagnosis, robot, ways):
        yield "head", "Do this"
        yield from (("", f"- {line}") for line in do)
        yield "head", WHY
    yield from (("", line) for line in of_the_file(diagnosis))
    for number, finding in enumerate(diagnosis.findings, 1):
        title = finding_title(finding)
        yield "head", f"{number}. {title}"
        if robot is not None and _known(finding, robot):
            yield "", f"   {ways.on_top}"
        lines = finding_lines(finding, diagnosis, span_s(diagnosis))
        yield from (("", f"   {line}") for line in lines)
        open_to_a_run = diagnosis.next_experiment is not None or diagnosis.open_ties
        tells = hint(finding, ways, diagnosis.pull_said)
        if not open_to_a_run and tied(finding) and tells:
            yield "", f"   {tells}"
    yield from (("", line) for line in remarks(diagnosis, ways))
    yield "head", fit_title(diagnosis)
    yield from (("", line) for line in fit_lines(diagnosis))
    if left := unexplained_line(diagnosis):
        yield "", left
    yield from (("", line) for line in untested_lines(diagnosis))
    if faint := faintest_line(diagnosis, robot):
        yield "", faint
    if following := experiment_line(diagnosis):
        yield "head", "What to do next"
        yield "", following


def _known(finding: Finding, robot: RobotModel) -> bool:
    """Whether the robot file has this effect already."""
    own = (finding.effect, finding.component)
    return any((one.effect, one.component) == own for one in robot.effects)


def of_the_file(diagnosis: Diagnosis) -> list[str]:
    """How surely the robot file is complete, and what is taken as known from it."""
    return [line for line in (sureness.false_alarm(diagnosis), known_line(diagnosis)) if line]


def remarks(diagnosis: Diagnosis, ways: Ways = TERMINAL) -> list[str]:
    """Remarks on the machine and the search as a whole, in addition to the findings."""
    lines = [allowed] if (allowed := allowed_line(diagnosis)) else []
    lines += [ENDED_EARLY.format(way=ways.all_compared)] if diagnosis.ended_early else []
    lines += map(left_out_line, diagnosis.left_out)
    lines += [thinned_line(one) for one in diagnosis.thinned]
    lines += [f"The torques were not read: {why}." for why in diagnosis.not_read]
    lines += [
        sureness.by_priors(one)
        for one in diagnosis.prior_sensitivity
        if not any(sureness.is_about(one, finding) for finding in diagnosis.findings)
    ]
    return [*lines, *tie_lines(diagnosis)]


def left_out_line(why: str) -> str:
    """That a recording of several was not used."""
    return f"Left out, and the other recordings used: {why}."


def thinned_line(thinned: Thinned) -> str:
    """That only stretches of a recording were used, and what follows from it."""
    return (
        f"Recording {thinned.recording} is long: {thinned.rows_used} of its {thinned.rows} rows "
        f"were used, in {thinned.stretches} stretches spread over {thinned.span_s / 3600:.2g} h. "
        "Events between them show only in what they changed; diagnose a part of the recording to "
        "look closer."
    )


def unexplained_line(diagnosis: Diagnosis) -> str:
    """What no finding explains; its size only where it is more than noise."""
    rest, fit = diagnosis.unexplained, diagnosis.fit
    says = words.sentence(rest.says)
    told_size = bool(diagnosis.findings) and rest.share_of_mismatch > 0.0
    beyond_m = math.sqrt(max(fit.rms_after_m**2 - fit.noise_floor_m**2, 0.0))
    size = quantity(beyond_m, fit.unit, digits=2)
    follows = words.listed([words.followed(name) for name in rest.depends_on])
    little = too_little(fit, rest.share_of_mismatch, bool(diagnosis.findings))
    if little and not diagnosis.findings and rest.share_of_mismatch > 0.0:
        known = quantity(fit.done_by_known_m, fit.unit, digits=2)
        return f"{BESIDE_KNOWN.format(left=size, known=known)}{SO_LITTLE}."
    if told_size and little and any(map(claimed, diagnosis.findings)):
        what = f"; it follows {follows}" if follows else ""
        return f"{UNEXPLAINED.format(size)}{SO_LITTLE}{what}."
    head = f"{UNEXPLAINED.format(size)}." if told_size else ""
    more = words.sentence(f"it follows {follows}") if follows and not says else ""
    return " ".join(text for text in (head, says, more) if text)
