"""One finding in sentences: its size, how sure it is, where it shows, and what else it may be."""

from __future__ import annotations

import math
from collections.abc import Iterator

from deltactl.diagnosis.answer.records import Diagnosis, Finding, ParameterResult, Where
from deltactl.diagnosis.answer.verdict import NAMELESS, as_well, rather_unknown
from deltactl.diagnosis.report.phrases import sureness, words
from deltactl.diagnosis.report.phrases.percent import negligible, percent
from deltactl.diagnosis.report.phrases.rivals import as_well_line, rivals
from deltactl.diagnosis.report.phrases.share_words import share_line
from deltactl.diagnosis.report.phrases.sizes import Size, quantity, sizes, told
from deltactl.diagnosis.report.sentences.notes import how_sure, notes

MOST_NAMED = 4
"""Channels or stretches of time that a sentence names."""
PART_OF_UNKNOWN = "probably only a part of what is unknown, though it looks like this: "
FAR_LESS = "Far less probable:"


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


def finding_lines(
    finding: Finding, diagnosis: Diagnosis, span: tuple[float, float] = (math.nan, math.nan)
) -> list[str]:
    """Size, how sure, where, and what else it could be."""
    lines = [divided(finding)] if divided(finding) else []
    lines += [words.sentence(f"{size.name}: {size.text}") for _, _, size in told_sizes(finding)]
    lines += [*notes(finding, diagnosis), *how_sure(finding, diagnosis)]
    if math.isfinite(finding.share_of_mismatch):
        lines.append(share_line(finding, diagnosis.fit))
    lines += [where_line(finding, span), memory_line(finding), alternatives_line(finding)]
    return [line for line in lines if line]


def divided(finding: Finding) -> str:
    """Of a delay of which only the sum is known: that; empty of all else."""
    late_s = sureness.late_in_all_s(finding)
    if late_s is None:
        return ""
    return words.sentence(sureness.divided(quantity(late_s, "s", digits=3)))


def told_sizes(finding: Finding) -> Iterator[tuple[str, ParameterResult, Size]]:
    """What is told of its parameters: name, figures, and as shown; no parts of a mere sum."""
    if divided(finding):
        return
    for name, result in told(finding.parameters).items():
        for size in sizes(finding.effect, name, result):
            yield name, result, size


def memory_line(finding: Finding) -> str:
    """Of something unknown: whether what came before counts."""
    if finding.effect != NAMELESS or finding.has_memory is None:
        return ""
    return {
        True: "Earlier motion counts too (hysteresis).",
        False: "Earlier motion does not count (no hysteresis).",
    }[finding.has_memory]


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
    """What this recording cannot distinguish from the finding; empty where that is said already."""
    if not finding.alternatives:
        told = finding.effect == NAMELESS or finding.probability is not None
        return "" if told else "No other known effect fits these readings as well."
    if sureness.settled(finding):
        fit_worse = _rivals_of_settled(finding)
        rest = f"{FAR_LESS} {fit_worse}." if fit_worse else ""
        return " ".join(filter(None, (as_well_line(finding), rest)))
    if finding.probability is not None and sureness.is_open(finding):
        return ""
    if sureness.sure_of_one(finding):
        return ""
    return f"This recording cannot tell it from {rivals(finding)}."


def _rivals_of_settled(finding: Finding) -> str:
    """Each that fits worse with its probability, and once for all of those that have next to none;
    empty where none does.
    """
    worse = [one for one in finding.alternatives if not as_well(one)]
    rest = [one for one in worse if negligible(one.probability)]
    if len(rest) < 2:
        return rivals(finding, worse) if worse else ""
    names = words.listed([words.rival(finding.effect, one.effect, one.component) for one in rest])
    others = [one for one in worse if one not in rest]
    shown = [rivals(finding, others)] if others else []
    return "; ".join([*shown, f"{names} ({percent(0.0)} each)"])
