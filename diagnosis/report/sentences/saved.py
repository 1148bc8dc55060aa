"""What a corrected robot file holds, how well each part is supported, and what it leaves out."""

from __future__ import annotations

from diagnosis.answer.corrected_robot import lasts, sure, sure_of_correction
from diagnosis.answer.options import VERDICT
from diagnosis.answer.records import Diagnosis, Finding
from diagnosis.report.phrases import words
from diagnosis.report.phrases.percent import percent
from diagnosis.report.phrases.sureness import settled
from diagnosis.report.sentences.telling_apart import LONE, OTHERWISE, measurement, way_apart
from diagnosis.report.sentences.ways import TERMINAL, Ways

MOST_RIVALS = 3


def written(diagnosis: Diagnosis, all_of_them: bool) -> str:
    """How many findings a corrected robot file holds."""
    kept, _ = _kept_and_left(diagnosis, all_of_them)
    return (
        f"with {words.count(len(kept), 'finding')}"
        if kept
        else "unchanged: nothing is certain enough"
    )


def support(diagnosis: Diagnosis, all_of_them: bool, ways: Ways = TERMINAL) -> list[str]:
    """One line for each finding that lasts: how sure it is, and what would check it."""
    _, left = _kept_and_left(diagnosis, all_of_them)
    out = [f"- {ways.left_out}{_supported(one, diagnosis, ways)}" for one in left]
    return [*supported(diagnosis, all_of_them, ways), *out]


def supported(diagnosis: Diagnosis, all_of_them: bool, ways: Ways = TERMINAL) -> list[str]:
    """The same, of those in the file only."""
    kept, _ = _kept_and_left(diagnosis, all_of_them)
    return [f"- {_supported(one, diagnosis, ways)}" for one in kept]


def _kept_and_left(diagnosis: Diagnosis, all_of_them: bool) -> tuple[list[Finding], list[Finding]]:
    lasting = [one for one in diagnosis.findings if lasts(one)]
    kept = [one for one in lasting if all_of_them or sure(one, diagnosis)]
    return kept, [one for one in lasting if one not in kept]


def _supported(finding: Finding, diagnosis: Diagnosis, ways: Ways) -> str:
    name = words.effect(finding.effect, finding.component)
    probability = finding.probability
    if settled(finding) or (probability is None and not finding.alternatives):
        how = f" ({percent(probability)})" if probability is not None else ""
        return f"well supported{how}: {name}"
    together = sure_of_correction(finding)
    if probability is not None and together >= VERDICT.sure_enough:
        return (
            f"{percent(together)} sure that this is to be corrected, not of its cause: {name}"
            f" ({percent(probability)}){_or_else(finding)}, and that calls for the same"
            f" correction; to tell which it is, {_check(finding, diagnosis, ways)}"
        )
    sure_of = "not certain" if probability is None else f"only {percent(probability)} sure"
    return f"{sure_of}: {name}{_or_else(finding)}; to check, {_check(finding, diagnosis, ways)}"


def _or_else(finding: Finding) -> str:
    """The likeliest of what it may be instead."""
    others = sorted(finding.alternatives, key=lambda one: -(one.probability or 0.0))
    named = [
        words.rival(finding.effect, one.effect, one.component)
        + (f" ({percent(one.probability)})" if one.probability is not None else "")
        for one in others[:MOST_RIVALS]
    ]
    if len(others) > MOST_RIVALS:
        named.append(f"one of {len(others) - MOST_RIVALS} others")
    return f", which may be {words.listed(named, 'or')} instead" if named else ""


def _check(finding: Finding, diagnosis: Diagnosis, ways: Ways) -> str:
    plan = diagnosis.next_experiment
    if plan is not None and f"{finding.effect} {finding.component}" in plan.tells_apart:
        return ways.run
    if way := way_apart(finding):
        return way
    if finding.component == LONE or not finding.alternatives:
        return OTHERWISE + ", and diagnose both recordings"
    return measurement(frozenset({finding.effect, finding.alternatives[0].effect}))
