"""Contradictions that no answer may contain, whatever produced it."""

from __future__ import annotations

import math
from collections.abc import Iterator

from deltactl.diagnosis.answer.options import VERDICT
from deltactl.diagnosis.answer.records import Diagnosis, Finding
from deltactl.diagnosis.answer.verdict import at_floor, claimed, gained, grew, much_goes_on, seen
from deltactl.models.effects import Trait, has

NOTHING_MISSING = "nothing is missing"
ROUNDING = 1e-9
"""Of shares and probabilities that are added up: far above what sixteen digits lose."""


def contradictions(answer: Diagnosis) -> list[str]:
    """What in an answer cannot be true together, one line each; empty for a sound answer.

    The contract's paragraph "Answers that contradict themselves are defects", and what anybody
    sees who compares verdict, figures, sizes and sentences.
    """
    return [
        *_verdict(answer),
        *_chances(answer),
        *_shares(answer),
        *_figures(answer),
        *(line for finding in answer.findings for line in _sizes(finding)),
        *_probabilities(answer),
        *_sentences(answer),
    ]


def _verdict(answer: Diagnosis) -> Iterator[str]:
    named = [finding for finding in answer.findings if claimed(finding)]
    match answer.verdict:
        case "nothing_missing":
            if answer.findings:
                yield "nothing is missing, and there are findings"
            if not at_floor(answer.fit):
                yield "nothing is missing, and the residual is above the noise floor"
            if seen(answer.false_alarm_p):
                yield f"nothing is missing, with p = {answer.false_alarm_p:.2g}"
            if answer.unexplained.share_of_mismatch > ROUNDING:
                yield "nothing is missing, and a share of the model error is unexplained"
        case "explained":
            if not named or len(named) < len(answer.findings):
                yield "explained, and not by named effects alone"
            yield from _left_of_explained(answer)
        case "partly_explained":
            if not named:
                yield "partly explained by nothing that has a name"
        case "unexplained":
            if named:
                yield "unexplained, and a named effect is a finding"


def _left_of_explained(answer: Diagnosis) -> Iterator[str]:
    if not at_floor(answer.fit):
        yield "explained, and the residual is above the noise floor"
    if much_goes_on(answer.fit):
        yield "explained, and much is left that is no sensor's noise"
    if grew(answer.fit):
        yield "explained, and the held-out model error grew"
    elif not gained(answer.findings, answer.fit):
        yield "explained, and the held-out model error did not fall"


def _chances(answer: Diagnosis) -> Iterator[str]:
    for finding in answer.findings:
        alternatives = sum(other.probability or 0.0 for other in finding.alternatives)
        if finding.probability is not None and finding.probability + alternatives < VERDICT.even:
            where = f"{finding.effect} on {finding.component}"
            yield f"{where} is named, and more probably nothing is there"


def _shares(answer: Diagnosis) -> Iterator[str]:
    shares = [finding.share_of_mismatch for finding in answer.findings]
    shares.append(answer.unexplained.share_of_mismatch)
    if sum(shares) > 1.0 + ROUNDING:
        yield f"shares add up to {sum(shares):.3g}"
    if not all(0.0 <= share <= 1.0 + ROUNDING for share in shares):
        yield "a share is not between 0 and 1"


def _figures(answer: Diagnosis) -> Iterator[str]:
    fit, rest = answer.fit, answer.unexplained
    more = bool(rest.depends_on) or rest.share_of_mismatch > ROUNDING
    if more and not fit.rms_after_m > fit.noise_floor_m:
        yield "more than noise is left, and the residual is not above the noise floor"
    if not more and not at_floor(fit):
        yield "what is left is noise, and the residual is above the noise floor"


def _sizes(finding: Finding) -> Iterator[str]:
    name = f"{finding.effect} at {finding.component}"
    values = [value for size in finding.parameters.values() for value, _, _ in size.components]
    if has(finding.effect, Trait.WHOLE_STEPS) and "steps" in finding.parameters:
        ((steps, _, _),) = finding.parameters["steps"].components
        if abs(steps) < VERDICT.least_steps:
            yield f"{name}: less than one step"
    if values and not any(values):
        yield f"{name}: no size"
    for parameter, size in finding.parameters.items():
        for value, low, high in size.components:
            if math.isinf(value):
                continue
            if not low < high:
                yield f"{name}: an interval of no width for {parameter}"
            elif not low <= value <= high:
                yield f"{name}: {parameter} lies outside its interval"
            elif value != 0.0 and value in (low, high):
                yield f"{name}: {parameter} sits at its bound"


def _probabilities(answer: Diagnosis) -> Iterator[str]:
    found = [one.probability for one in answer.findings]
    others = [
        alternative.probability
        for finding in answer.findings
        for alternative in finding.alternatives
    ]
    given = [answer.probability_nothing_missing, *found, *others]
    stated = [p for p in given if p is not None]
    if not all(0.0 <= p <= 1.0 for p in stated):
        yield "a probability is not between 0 and 1"
    empty = answer.probability_nothing_missing
    if empty is None:
        return
    if answer.verdict == "nothing_missing" and empty < VERDICT.even:
        yield f"nothing is missing, with a probability of {empty:.2g}"
    most = max((f.probability or 0.0 for f in answer.findings), default=0.0)
    if empty + most > 1.0 + ROUNDING:
        yield "a finding and that nothing is missing are together more than certain"


def _sentences(answer: Diagnosis) -> Iterator[str]:
    said = any(NOTHING_MISSING in line.lower() for line in answer.says)
    if said and answer.verdict != "nothing_missing":
        yield "a sentence says that nothing is missing, the verdict does not"
