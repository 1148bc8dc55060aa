"""What a finding may be instead, with probabilities that are shares of one whole."""

from __future__ import annotations

from collections.abc import Sequence

from deltactl.diagnosis.answer.records import Alternative, Finding
from deltactl.diagnosis.answer.verdict import as_well
from deltactl.diagnosis.report.phrases import words
from deltactl.diagnosis.report.phrases.percent import percent

ROUNDED = 0.005
"""Half a percent: what a sum of shares may be above one before the sentence would show it."""


def rivals(finding: Finding, shown: Sequence[Alternative] | None = None, more: int = 0) -> str:
    """'a (30 %) or b (15 %)'; shown: those to name, more: how many are only counted.

    A set of causes may hold several of them, so that their probabilities may come to more than what
    the finding leaves: then one share is told, of all of them.
    """
    named = list(finding.alternatives if shown is None else shown)
    apart = exclusive(finding)
    names = [_with_share(finding, one) if apart else _name(finding, one) for one in named]
    names += [f"one of {more} others"] if more else []
    text = words.listed(names, "or")
    return text if apart else f"{text} ({_of_all(finding, len(names))})"


def exclusive(finding: Finding) -> bool:
    """Whether the probabilities of a finding and its alternatives are shares of one whole."""
    given = [finding.probability, *(one.probability for one in finding.alternatives)]
    return sum(one or 0.0 for one in given) <= 1.0 + ROUNDED


def as_well_line(finding: Finding) -> str:
    """Of what fits a settled finding's readings as well: that it is only rarer; else empty."""
    same = [one for one in finding.alternatives if as_well(one)]
    if not same:
        return ""
    if len(same) > 1:
        text = f"{rivals(finding, same)} would fit these readings as well, but they are rarer"
    else:
        share = "" if same[0].probability is None else f" ({percent(same[0].probability)})"
        name = _name(finding, same[0])
        text = f"{name} would fit these readings as well, but is rarer{share}"
    return words.sentence(text)


def by_usage(finding: Finding) -> str:
    """What the shares of an open finding say where the fit does not tell it from others: a clause;
    empty where each of them fits worse.
    """
    same = [one for one in finding.alternatives if as_well(one)]
    if not same:
        return ""
    if len(same) == len(finding.alternatives):
        which = "both fit" if len(same) == 1 else "all fit"
        return f": {which} it as well, and the shares only say how usual each is"
    names = words.listed([_name(finding, one) for one in same], "or")
    return f": {names} would fit it as well, with a share that only says how usual that is"


def _name(finding: Finding, other: Alternative) -> str:
    return words.rival(finding.effect, other.effect, other.component)


def _with_share(finding: Finding, other: Alternative) -> str:
    told = "" if other.probability is None else f" ({percent(other.probability)})"
    return f"{_name(finding, other)}{told}"


def _of_all(finding: Finding, count: int) -> str:
    left = percent(max(1.0 - (finding.probability or 0.0), 0.0))
    return left if count == 1 else f"one or several of them: {left}"
