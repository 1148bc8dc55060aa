"""What a corrected robot file holds, how well each part is supported, and what it leaves out."""

from __future__ import annotations

from collections.abc import Sequence

from deltactl.diagnosis.answer.corrected_robot import (
    corrected_alike,
    lasts,
    sure,
    sure_of_correction,
)
from deltactl.diagnosis.answer.options import VERDICT
from deltactl.diagnosis.answer.records import Alternative, Diagnosis, Finding
from deltactl.diagnosis.answer.verdict import NAMELESS
from deltactl.diagnosis.report.phrases import words
from deltactl.diagnosis.report.phrases.percent import percent
from deltactl.diagnosis.report.phrases.rivals import rivals
from deltactl.diagnosis.report.phrases.sureness import called, settled
from deltactl.diagnosis.report.sentences.telling_apart import (
    LONE,
    OTHERWISE,
    UNEVEN,
    beside_friction,
    measurement,
    way_apart,
)
from deltactl.diagnosis.report.sentences.ways import TERMINAL, Ways
from deltactl.models.effects import VOCABULARY

MOST_RIVALS = 3


def written(diagnosis: Diagnosis, all_of_them: bool) -> str:
    """How many of the findings a corrected robot file holds."""
    kept, _ = _kept_and_left(diagnosis, all_of_them)
    if not kept:
        return "unchanged: nothing is certain enough"
    of = len(diagnosis.findings)
    if len(kept) == of:
        return f"with {words.count(of, 'finding')}"
    return f"with {len(kept)} of {words.count(of, 'finding')}"


def support(diagnosis: Diagnosis, all_of_them: bool, ways: Ways = TERMINAL) -> list[str]:
    """One line for each finding: how sure it is and what would check it, or why it is left out."""
    _, left = _kept_and_left(diagnosis, all_of_them)
    out = [f"- {ways.left_out}{_supported(one, diagnosis, ways)}" for one in left]
    found = diagnosis.findings
    never = [f"- not written: {_never(one, found)}" for one in found if not lasts(one)]
    return [*supported(diagnosis, all_of_them, ways), *out, *never]


def supported(diagnosis: Diagnosis, all_of_them: bool, ways: Ways = TERMINAL) -> list[str]:
    """The same, of those in the file only."""
    kept, _ = _kept_and_left(diagnosis, all_of_them)
    return [f"- {_supported(one, diagnosis, ways)}" for one in kept]


def _kept_and_left(diagnosis: Diagnosis, all_of_them: bool) -> tuple[list[Finding], list[Finding]]:
    lasting = [one for one in diagnosis.findings if lasts(one)]
    kept = [one for one in lasting if all_of_them or sure(one, diagnosis)]
    return kept, [one for one in lasting if one not in kept]


def _never(finding: Finding, findings: Sequence[Finding]) -> str:
    """A finding that no robot file holds, and why; findings: all."""
    if finding.effect == NAMELESS:
        name = words.unknown(finding.component, finding.depends_on)
        name = UNEVEN if beside_friction(finding, findings) else name
        return f"{name} (a robot file has entries only for what has a name)"
    name = called(finding)
    kind = VOCABULARY.get(finding.effect)
    if kind is not None and kind.event:
        return f"{name} (it happened once, and is no property of the machine)"
    return f"{name} (a robot file has no entry for it in this form)"


def _supported(finding: Finding, diagnosis: Diagnosis, ways: Ways) -> str:
    name = called(finding)
    own = finding.probability
    if settled(finding) or (own is None and not finding.alternatives):
        how = f" ({percent(own)})" if own is not None else ""
        return f"well supported{how}: {name}"
    check = _check(finding, diagnosis, ways)
    together, alike = sure_of_correction(finding), corrected_alike(finding)
    if own is not None and alike and together >= VERDICT.sure_enough:
        return (
            f"the same correction, {percent(together)} sure to be right, whether the cause is"
            f" {name} ({percent(own)}) or {_likeliest(finding, alike)}; to tell which, {check}"
        )
    sure_of = "not certain"
    if own is not None:
        only = "" if own >= VERDICT.sure_enough else "only "
        sure_of = f"{only}{percent(own)} sure"
    instead = f", which may be {_likeliest(finding, finding.alternatives)} instead"
    return f"{sure_of}: {name}{instead if finding.alternatives else ''}; to check, {check}"


def _likeliest(finding: Finding, others: Sequence[Alternative]) -> str:
    """The likeliest of what it may be instead; the rest are counted."""
    first = sorted(others, key=lambda one: -(one.probability or 0.0))
    return rivals(finding, first[:MOST_RIVALS], max(len(first) - MOST_RIVALS, 0))


def _check(finding: Finding, diagnosis: Diagnosis, ways: Ways) -> str:
    plan = diagnosis.next_experiment
    if plan is not None and f"{finding.effect} {finding.component}" in plan.tells_apart:
        return ways.run
    if way := way_apart(finding, ways, diagnosis.pull_said):
        return way
    if finding.component == LONE or not finding.alternatives:
        return OTHERWISE + ", and diagnose both recordings"
    return measurement(frozenset({finding.effect, finding.alternatives[0].effect}))
