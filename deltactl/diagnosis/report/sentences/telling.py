"""An answer put into words: every sentence of it is made here, from its fields."""

from __future__ import annotations

import math
from collections.abc import Mapping
from typing import Any

from deltactl.diagnosis.answer.options import VERDICT
from deltactl.diagnosis.answer.records import Diagnosis, Finding, Fit
from deltactl.diagnosis.answer.verdict import goes_on, seen
from deltactl.diagnosis.report.phrases import words
from deltactl.diagnosis.report.phrases.left_words import (
    doubtful_floor,
    moved_at_rest,
    moves_at_rest,
    persists,
    record_more,
    said_of_rest,
    scatter_within,
    where_left,
)
from deltactl.diagnosis.report.phrases.sizes import quantity
from deltactl.diagnosis.report.phrases.sureness import by_noise, late_in_all_s
from deltactl.diagnosis.report.sentences.summary import plain_lines
from deltactl.models.effects import VOCABULARY, Search, Trait, card_of, found_by, has
from deltactl.models.effects.kind import EffectKind

LEFT = "What is left"
BESIDE = "What is left beside all of these"
IS_NOISE = "is consistent with measurement noise."
NOISE = f"{LEFT} {IS_NOISE}"


def told(answer: Diagnosis, kinds: Mapping[str, EffectKind] = VOCABULARY) -> Diagnosis:
    """The same answer with its sentences: of each finding, of what is left, and as a whole.

    kinds: the effects of the machine by name, which know their own sentences. What has a sentence
    already keeps it.
    """
    several = answer.picture is not None and len(answer.picture.shift_s) > 1
    findings = [_told(finding, kinds, several) for finding in answer.findings]
    rest = answer.unexplained
    rest = rest.model_copy(update={"says": rest.says or unexplained(answer)})
    answer = answer.model_copy(update={"findings": findings, "unexplained": rest})
    return answer.model_copy(update={"says": answer.says or plain_lines(answer)})


def _told(finding: Finding, kinds: Mapping[str, EffectKind], several: bool) -> Finding:
    says = finding.says or sentence(finding, kinds)
    if several and len(finding.where.recordings) == 1 and not finding.says:
        says += f" (in recording {finding.where.recordings[0]})"
    where = finding.where
    where = where.model_copy(update={"regime": where.regime or regime(finding)})
    return finding.model_copy(update={"says": says, "where": where})


def sentence(finding: Finding, kinds: Mapping[str, EffectKind] = VOCABULARY) -> str:
    """A finding in one sentence, with its size."""
    part = words.part(finding.component)
    if finding.effect == "unknown":
        return _unknown(finding, part)
    if finding.effect == found_by(Search.REPEATS).name:
        begin, end = finding.where.times_s[0]
        return f"{part} repeats one value from {begin:.2f} s to {end:.2f} s"
    if (late_s := late_in_all_s(finding)) is not None:
        return f"{part} follows its command late, by {quantity(late_s, 's', digits=3)} in all"
    kind = kinds.get(finding.effect)
    if kind is None:
        return words.effect(finding.effect, finding.component)
    values: dict[str, Any] = {p.name: p.default for p in kind.parameters if p.default is not None}
    for name, size in finding.parameters.items():
        found = [value for value, _, _ in size.components]
        values[name] = found if isinstance(size.value, list) else found[0]
    return kind.sentence(part, values)


def _unknown(finding: Finding, part: str) -> str:
    covariates = [words.followed(name) for name in finding.depends_on if name not in finding.tied]
    tied = [words.followed(name) for name in finding.tied]
    which = words.listed(covariates)
    if tied:
        which += f" (or {', '.join(tied)}: this recording cannot tell which)"
    size = finding.parameters["size_rms"]
    ((value, _, _),) = size.components
    return (
        f"something at {part} that no known effect explains follows {which}, "
        f"with a size of {quantity(value, size.unit, digits=3)} (root mean square)"
    )


OR_NOT = "whether it is the noise of reading, no readings at one place tell"


def _like_noise(answer: Diagnosis) -> str:
    """What no test tells from noise; where readings at rest show how little noise they have, or
    neighbours how long it goes on, so."""
    within, left = answer.fit.scatter_within_m, answer.fit.rms_after_m
    nameless = any(one.effect == "unknown" for one in answer.findings)
    head = BESIDE if nameless else LEFT
    if moves_at_rest(answer.fit):
        found_play = any(has(one.effect, Trait.HYSTERESIS) for one in answer.findings)
        size = quantity(left, answer.fit.unit, digits=2)
        return moved_at_rest(answer.fit, f"{head} ({size})", found_play)
    if within is None or not said_of_rest(answer.fit) or _by_known(answer.fit):
        if goes_on(answer.fit):
            return _that_goes_on(answer, head)
        if answer.fit.sensor_noise:
            return f"{head} {IS_NOISE}"
        size = quantity(left, answer.fit.unit, digits=2)
        return f"{head} ({size}) follows nothing that a test sees; {OR_NOT}."
    left_m = quantity(left, answer.fit.unit, digits=2)
    return (
        f"What is left ({left_m}) follows nothing that a test sees. Readings at one place scatter "
        f"by {scatter_within(answer.fit, 2)}, so {where_left(answer.fit, 'it')}: it is more than"
        f" the noise of reading. {record_more(answer.fit)}"
    )


def _by_known(fit: Fit) -> bool:
    """Whether the effects of the file may leave most of what is left, and it goes on as theirs."""
    return goes_on(fit) and fit.left_by_known_m > VERDICT.most_of_rest * fit.rms_after_m


def _that_goes_on(answer: Diagnosis, head: str) -> str:
    """What no test sees, though it is much the same from one reading to the next."""
    fit = answer.fit
    size = quantity(fit.rms_after_m, fit.unit, digits=2)
    if _by_known(fit):
        lasts = quantity(fit.left_lasts_s or math.nan, "s", digits=2)
        return (
            f"{head} ({size}) goes on for about {lasts} at a time. That is what the effects in the"
            " robot file usually leave beyond their simple models, so nothing more is concluded"
            " from it."
        )
    return (
        f"{head} ({size}) follows nothing that a test sees, yet it is not the noise of a sensor,"
        f" which is new with each reading: {persists(fit)}. Something small that the model leaves"
        " out would look so, or readings that were smoothed by a filter."
    )


def unexplained(answer: Diagnosis) -> str:
    """What no finding explains, in one sentence."""
    rest, fit = answer.unexplained, answer.fit
    if not rest.depends_on and rest.share_of_mismatch <= 0.0:
        return _like_noise(answer)
    floor = fit.noise_floor_m
    times = fit.rms_after_m / floor if floor > 0.0 else math.inf
    how = [by_noise(rest.p)] if rest.p is not None and seen(rest.p) else []
    if times > VERDICT.at_floor and not doubtful_floor(fit):
        how.append(f"{times:.2g} times the noise floor")
    told_how = f" ({', '.join(how)})" if how else ""
    if not rest.depends_on:
        more = f"; {persists(fit)}" if goes_on(fit) else ""
        return (
            f"What is left is more than noise{told_how}, and no test tells what it follows{more}."
        )
    follows = words.listed([words.followed(name) for name in rest.depends_on])
    place = f" at {words.part(rest.component)}" if rest.component else ""
    return f"What is left is more than noise{told_how}; it follows {follows}{place}."


def regime(finding: Finding) -> str:
    """Where a finding shows."""
    if finding.effect == "unknown":
        return words.listed([f"with {words.followed(name)}" for name in finding.depends_on[:1]])
    return card_of(finding.effect).words.regime.format(part=words.part(finding.component))
