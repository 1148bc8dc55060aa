"""What the robot file has from earlier diagnoses, which an answer takes for granted."""

from __future__ import annotations

from collections.abc import Sequence

from deltactl.diagnosis.answer.records import Diagnosis, Known
from deltactl.diagnosis.report.phrases import words
from deltactl.diagnosis.report.phrases.percent import percent
from deltactl.diagnosis.report.phrases.sureness import SETTLED
from deltactl.models.effects.lone_axis import COMPONENT

TAKEN = "Taken as known, from the robot file: {names}."
NO_PROOF = "{start} found in {this}: that {fits} here proves nothing, check on another recording."
NOT_SURE = "When {it} found, it was not certain: {sure}."
SMALL = (
    "Small errors that an earlier answer allowed for, or left to be checked by hand, are in no"
    " robot file: they are part of what is left."
)


def known_line(diagnosis: Diagnosis) -> str:
    """What was found before, how sure it was, and whether in the same recordings; else empty."""
    known = diagnosis.known
    if not known:
        return ""
    said = [TAKEN.format(names=words.listed(_named(known)))]
    here = [one for one in known if one.from_these_recordings]
    if here:
        this = "these recordings" if len(diagnosis.recordings) > 1 else "this very recording"
        start, fits = ("It was", "it fits") if len(known) == 1 else ("They were", "they fit")
        if len(here) < len(known):
            were = "was" if len(here) == 1 else "were"
            fits = "it fits" if len(here) == 1 else "they fit"
            start = f"Of these, {words.listed(_named(here))} {were}"
        said.append(NO_PROOF.format(start=start, this=this, fits=fits))
    unsure = [one for one in known if one.probability is not None and one.probability < SETTLED]
    if unsure:
        sure = [f"{percent(one.probability or 0.0)} for {_name(one)}" for one in unsure]
        it = "it was" if len(known) == 1 else "they were"
        said.append(NOT_SURE.format(it=it, sure=words.listed(sure)))
    delta = any(one.component != COMPONENT for one in known)
    if delta and not diagnosis.loosely_built and diagnosis.verdict == "nothing_missing":
        said.append(SMALL)
    return " ".join(said)


def _named(known: Sequence[Known]) -> list[str]:
    """By effect, its places together."""
    effects = dict.fromkeys(one.effect for one in known)
    places = {name: [one.component for one in known if one.effect == name] for name in effects}
    return [words.effect(name, *dict.fromkeys(where)) for name, where in places.items()]


def _name(one: Known) -> str:
    return words.effect(one.effect, one.component)
