"""The summary in the terminal: plain sentences, the most important first."""

from __future__ import annotations

import math
from collections.abc import Iterator, Sequence

from rich.markup import escape

from diagnosis.answer.options import VERDICT
from diagnosis.answer.records import Alternative, Diagnosis, Finding, Thinned, Where
from diagnosis.answer.verdict import NAMELESS, claimed, fits_worse, rather_unknown, seen
from diagnosis.report.sentences import sureness, words
from diagnosis.report.sentences.fit_words import doubtful_floor, fit_lines, fit_title
from diagnosis.report.sentences.limit_words import faintest_line, untested_line
from diagnosis.report.sentences.next_run_words import experiment_line, tie_lines
from diagnosis.report.sentences.remedies import remedies, tied
from diagnosis.report.sentences.sizes import quantity, sizes, told
from diagnosis.report.sentences.telling_apart import hint
from diagnosis.report.sentences.ways import TERMINAL, Ways
from models.robot import RobotModel

ENDED_EARLY = (
    "The search stopped at its limit of work, with the best explanation so far: not everything was "
    "compared ({way})."
)
LOOSE = (
    "Beside the findings, small errors of {what} were allowed for, as large as those of a machine "
    "built with care: together they explain what no single finding does. They are in no corrected "
    "file, which therefore leaves a little more."
)
LENGTHS = frozenset({"upper_arm_length", "forearm_length", "base_radius"})
"""Of which a recording of arm angles shows nothing."""
WHY = "Why"
"""Title above the reasons: what comes before is what to do."""
NOT_TOLD = (
    "What is left is more than noise, and too faint to say what it is: record longer, or a motion "
    "that shows more."
)
"""Where no test sees anything, and the size of what is left is no noise's."""
MOST_NAMED = 4
"""Things of one kind that a sentence names; the rest are counted."""
PART_OF_UNKNOWN = "probably only a part of what is unknown, though it looks like this: "
MOSTLY_LEFT = 0.5
"""Share of the mismatch that nothing explains, from which on the headline says so first."""
CHECK_FIRST = "first check that each column and the robot file are the right ones"
FINE_COURSE = "the fine course of the readings points to"
IN_HEADLINE = 3
"""Findings that the headline names; of more it names two, and all have their own title below."""


def summary_lines(diagnosis: Diagnosis, robot: RobotModel | None = None) -> list[str]:
    """The summary as lines of rich markup, everything that came from outside escaped.

    robot: whose lengths what is to be done is said in.
    """
    lines = []
    for number, (style, line) in enumerate(_summary(diagnosis, robot)):
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


def headline(diagnosis: Diagnosis) -> str:
    """The verdict in one sentence."""
    findings = diagnosis.findings
    named = _named([finding for finding in findings if claimed(finding)])
    shown = named
    if len(named) > IN_HEADLINE:
        shown = [*named[: IN_HEADLINE - 1], f"{len(named) - IN_HEADLINE + 1} more, named below"]
    what = words.listed(shown)
    if diagnosis.verdict == "nothing_missing":
        return _nothing_missing(diagnosis)
    if diagnosis.verdict == "explained" and named:
        return words.sentence(f"the mismatch is explained by {what}")
    if diagnosis.verdict == "partly_explained" and named:
        more = any(one.effect == "unknown" for one in findings)
        rest = "; another part is real and matches no known effect" if more else ""
        left = diagnosis.unexplained.share_of_mismatch
        part = "part"
        if fits_worse(diagnosis.fit):
            return words.sentence(f"{FINE_COURSE} {what}, and yet the fit as a whole is no better")
        if left >= MOSTLY_LEFT:
            part, rest = (
                "only a small part",
                f"; {100.0 * left:.0f} % of it is left ({CHECK_FIRST})",
            )
        elif _nearly_all(diagnosis) and not rest:
            part = "nearly all"
        return words.sentence(f"{part} of the mismatch is explained by {what}{rest}")
    if unknown := [finding for finding in findings if finding.effect == "unknown"]:
        return words.sentence(
            "something is missing from the model that matches no known effect; "
            + words.listed([_enters(finding) for finding in unknown[:MOST_NAMED]])
        )
    nothing = diagnosis.probability_nothing_missing
    if nothing is not None and not seen(diagnosis.false_alarm_p):
        if nothing >= VERDICT.even:
            return NOT_TOLD
        likely = sureness.percent(1.0 - nothing)
        return (
            f"Something may be missing from the model (probability {likely}), too faint to say "
            "what: record longer, or a motion that shows more."
        )
    return "Something is missing from the model, and no known effect explains it."


def _nearly_all(diagnosis: Diagnosis) -> bool:
    """Whether next to nothing is left, also of what the tests take for noise."""
    fit = diagnosis.fit
    left = fit.rms_after_m**2 < VERDICT.faint_rest * fit.rms_before_m**2
    return left and diagnosis.unexplained.share_of_mismatch < VERDICT.faint_rest


def _named(findings: Sequence[Finding]) -> list[str]:
    """Findings by name, those of one kind at several parts as one where nothing else is open."""
    alike: dict[str, list[Finding]] = {}
    for finding in findings:
        certain = not finding.alternatives or sureness.settled(finding)
        own = f"{finding.effect}@{finding.component}"
        alike.setdefault(finding.effect if certain else own, []).append(finding)
    return [
        words.effect(same[0].effect, *dict.fromkeys(one.component for one in same))
        if len(same) > 1
        else _either(same[0])
        for same in alike.values()
    ]


def _nothing_missing(diagnosis: Diagnosis) -> str:
    """As surely as it is known, and in the noise only where what is left is that."""
    sure = diagnosis.probability_nothing_missing
    doubtful = doubtful_floor(diagnosis.fit)
    within = "as far as this recording shows" if doubtful else "within the noise"
    if sure is not None and sure < sureness.SETTLED:
        likely = sureness.percent(sure)
        return (
            f"Probably nothing is missing ({likely} sure): the machine behaves as its robot file"
            f" says, {within}."
        )
    return f"Nothing is missing: the machine behaves as its robot file says, {within}."


def _either(finding: Finding) -> str:
    """A finding by name, with what it cannot be told from."""
    name = words.effect(finding.effect, finding.component)
    others = [words.rival(finding.effect, o.effect, o.component) for o in finding.alternatives]
    if not others or sureness.settled(finding):
        return name
    if (rival := sureness.likelier(finding)) is not None:
        likelier = words.rival(finding.effect, rival.effect, rival.component)
        more = len(others) - 1
        beside = f" (or {words.count(more, 'other')} that look the same)" if more > 1 else ""
        return f"{name} or, more probably, {likelier}{beside}"
    if len(others) == 1:
        return f"{name} (or {others[0]})"
    return f"{name} (or one of {len(others)} others that look the same)"


def _enters(finding: Finding) -> str:
    follows = words.listed([words.followed(name) for name in finding.depends_on])
    alone = finding.component == "axis" and "distance" in finding.depends_on
    at = f"it enters at {'the sensor' if alone else words.part(finding.component)}"
    return f"{at} and follows {follows}" if follows else at


def _summary(
    diagnosis: Diagnosis, robot: RobotModel | None, ways: Ways = TERMINAL
) -> Iterator[tuple[str, str]]:
    yield "head", headline(diagnosis)
    yield from (("", f"Look at this first: {line}") for line in diagnosis.doubts)
    if do := remedies(diagnosis, robot, ways):
        yield "head", "Do this"
        yield from (("", f"- {line}") for line in do)
        yield "head", WHY
    yield "", sureness.false_alarm(diagnosis)
    for number, finding in enumerate(diagnosis.findings, 1):
        title = finding_title(finding)
        yield "head", f"{number}. {title}"
        if robot is not None and _known(finding, robot):
            yield "", f"   {ways.on_top}"
        yield from (("", f"   {line}") for line in finding_lines(finding, span_s(diagnosis)))
        open_to_a_run = diagnosis.next_experiment is not None or diagnosis.open_ties
        if not open_to_a_run and tied(finding) and (tells := hint(finding)):
            yield "", f"   {tells}"
    yield from (("", line) for line in remarks(diagnosis, ways))
    yield "head", fit_title(diagnosis)
    yield from (("", line) for line in fit_lines(diagnosis))
    if left := unexplained_line(diagnosis):
        yield "", left
    if untested := untested_line(diagnosis):
        yield "", untested
    if faint := faintest_line(diagnosis):
        yield "", faint
    if following := experiment_line(diagnosis):
        yield "head", "What to do next"
        yield "", following


def _known(finding: Finding, robot: RobotModel) -> bool:
    """Whether the robot file has this effect already."""
    own = (finding.effect, finding.component)
    return any((one.effect, one.component) == own for one in robot.effects)


def finding_title(finding: Finding) -> str:
    """The finding's own sentence, components spelled out."""
    says = finding.says or words.effect(finding.effect, finding.component)
    return words.sentence(f"{PART_OF_UNKNOWN}{says}" if rather_unknown(finding) else says)


def span_s(diagnosis: Diagnosis) -> tuple[float, float]:
    """First and last time of the recording; NaN where no picture tells."""
    picture = diagnosis.picture
    if picture is None or not len(picture.t_s):
        return math.nan, math.nan
    return float(picture.t_s[0]), float(picture.t_s[-1])


def remarks(diagnosis: Diagnosis, ways: Ways = TERMINAL) -> list[str]:
    """Remarks on the machine and the search as a whole, in addition to the findings."""
    lines = [_loose(diagnosis)] if diagnosis.loosely_built else []
    lines += [ENDED_EARLY.format(way=ways.all_compared)] if diagnosis.ended_early else []
    lines += [thinned_line(one) for one in diagnosis.thinned]
    lines += [f"The torques were not read: {why}." for why in diagnosis.not_read]
    named = [one for one in diagnosis.prior_sensitivity if one.effect != NAMELESS]
    lines += [sureness.by_priors(one) for one in named]
    return [*lines, *tie_lines(diagnosis)]


def _loose(diagnosis: Diagnosis) -> str:
    """Which small errors were fitted beside the findings: those that the recording shows."""
    hidden = {one.effect for one in diagnosis.not_testable} >= LENGTHS
    return LOOSE.format(what="home angles and ratios" if hidden else "lengths and angles")


def thinned_line(thinned: Thinned) -> str:
    """That only stretches of a recording were used, and what follows from it."""
    return (
        f"Recording {thinned.recording} is long: {thinned.rows_used} of its {thinned.rows} rows "
        f"were used, in {thinned.stretches} stretches spread over {thinned.span_s / 3600:.2g} h. "
        "Events between them show only in what they changed; diagnose a part of the recording to "
        "look closer."
    )


def finding_lines(finding: Finding, span: tuple[float, float] = (math.nan, math.nan)) -> list[str]:
    """Size, how sure, where, and what else it could be."""
    lines = [
        words.sentence(f"{size.name}: {size.text}")
        for name, result in told(finding.parameters).items()
        for size in sizes(finding.effect, name, result)
    ]
    if (late_s := sureness.late_in_all_s(finding)) is not None:
        lines.insert(0, words.sentence(sureness.divided(quantity(late_s, "s", digits=2))))
    lines.append(sureness.evidence(finding))
    if math.isfinite(finding.share_of_mismatch):
        lines.append(share_line(finding))
    if shows := where_line(finding, span):
        lines.append(shows)
    if finding.effect == "unknown":
        lines.append(words.sentence(f"{_enters(finding)}{_memory(finding)}"))
    lines.append(alternatives_line(finding))
    return lines


SO_LITTLE = ", too little to act on"
MINOR = 20.0
"""Per cent: what comes back of less sounds like a minor cause, which it need not be."""


def share_line(finding: Finding) -> str:
    """What the other findings cannot take over: each is left out and the others fitted again."""
    share = 100.0 * finding.share_of_mismatch
    shown = f"{share:.0f} %" if share >= 1.0 else "less than 1 %"
    says = f"without it {shown} of the mismatch comes back"
    if share >= MINOR:
        return words.sentence(f"{says}, even with the others fitted again")
    if share >= 1.0:
        return words.sentence(f"{says}: the other findings stand in for the rest, at wrong sizes")
    if finding.evidence.p < sureness.SURE_P:
        return words.sentence(f"its part is small: {says}, which is still more than noise adds")
    return words.sentence(f"its part is small: {says}, with the others fitted again")


def where_line(finding: Finding, span: tuple[float, float] = (math.nan, math.nan)) -> str:
    """In which channels, when (unless all the time), and in which regime it shows."""
    where = finding.where
    parts = []
    if where.axes:
        axes = [_the(words.channel(axis)) for axis in where.axes[:MOST_NAMED]]
        parts.append(f"in {words.listed(axes)}")
    if times := _stretches(where, *span):
        parts.append(times)
    if where.regime and finding.effect != "unknown":
        parts.append(where.regime)
    return words.sentence(f"it shows {', '.join(parts)}") if parts else ""


def _the(channel: str) -> str:
    """A channel of which there is one, in a sentence."""
    return channel if channel[-1:].isdigit() or channel[-2:-1] == " " else f"the {channel}"


def stretches(where: Where, start_s: float, end_s: float) -> list[tuple[float, float]]:
    """Those that say something: not the whole recording, or all of several."""
    times_s, slack = where.times_s, 0.02 * (end_s - start_s)
    if len(set(where.recordings)) > 1:
        return []
    if len(times_s) == 1 and times_s[0][0] <= start_s + slack and times_s[0][1] >= end_s - slack:
        return []
    return list(times_s)


def _stretches(where: Where, start_s: float, end_s: float) -> str:
    times = stretches(where, start_s, end_s)
    if len(times) == 1 and times[0][1] >= end_s:
        return f"from {times[0][0]:.1f} s on"
    shown = [f"from {start:.1f} to {end:.1f} s" for start, end in times[:MOST_NAMED]]
    more = len(times) - len(shown)
    return words.listed([*shown, f"{more} more times"] if more > 0 else shown)


def alternatives_line(finding: Finding) -> str:
    """What this recording cannot distinguish from the finding."""
    if not finding.alternatives:
        if finding.effect == "unknown":
            return "No known effect matches it."
        return "No other known effect fits these readings as well."
    if sureness.settled(finding):
        return f"Far less probable: {_rivals_of_settled(finding)}."
    others = [_rival(finding, other) for other in finding.alternatives]
    return f"This recording cannot tell it from {words.listed(others, 'or')}."


def _rivals_of_settled(finding: Finding) -> str:
    """Each with its probability, and once for all of those that have next to none."""
    rest = [one for one in finding.alternatives if sureness.negligible(one.probability)]
    if len(rest) < 2:
        return words.listed([_rival(finding, other) for other in finding.alternatives])
    named = words.listed([words.rival(finding.effect, one.effect, one.component) for one in rest])
    told = [_rival(finding, one) for one in finding.alternatives if one not in rest]
    return "; ".join([*told, f"{named} ({sureness.percent(0.0)} each)"])


def _rival(finding: Finding, other: Alternative) -> str:
    name = words.rival(finding.effect, other.effect, other.component)
    if other.probability is None:
        return name
    return f"{name} ({sureness.percent(other.probability)})"


def _memory(finding: Finding) -> str:
    if finding.has_memory is None:
        return ""
    return "; what came before counts too" if finding.has_memory else "; only the present counts"


def unexplained_line(diagnosis: Diagnosis) -> str:
    """What no finding explains; its share only where it is more than noise."""
    rest = diagnosis.unexplained
    says = words.sentence(rest.says)
    share = 100.0 * rest.share_of_mismatch
    told_share = bool(diagnosis.findings) and share > 0.0
    shown = f"{share:.0f} %" if share >= 1.0 else "under 1 %"
    follows = words.listed([words.followed(name) for name in rest.depends_on])
    if told_share and share < 1.0 and any(map(claimed, diagnosis.findings)):
        what = f"; it follows {follows}" if follows else ""
        return f"Unexplained: {shown} of the mismatch{SO_LITTLE}{what}."
    head = f"Unexplained: {shown} of the mismatch." if told_share else ""
    more = words.sentence(f"it follows {follows}") if follows and not says else ""
    return " ".join(text for text in (head, says, more) if text)
