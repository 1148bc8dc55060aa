"""When an event happened: readings show it late by what makes them late."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from deltactl.diagnosis.plants.candidate import Term
from deltactl.models.effects import Port, Trait, has

TIME = "time"


def seen_s(term: Term) -> float | None:
    """When the readings show a jump that was found by a scan of them; None for other effects."""
    names = [coordinate.parameter for coordinate in term.candidate.coordinates]
    if not has(term.candidate.effect, Trait.WHOLE_STEPS) or TIME not in names:
        return None
    return term.candidate.shapes[0].origin[names.index(TIME)]


def aligned(terms: Sequence[Term]) -> tuple[Term, ...]:
    """The terms with every jump so much before its show in the readings as these are late.

    The moment is found in the readings and stays there; how late they are is fitted beside it.
    """
    late_s = late_of(terms)
    return tuple(_moved_by(term, late_s) for term in terms)


def shown_later(term: Term, by_s: float) -> Term | None:
    """The same jump, shown by the readings so much later; None for other effects."""
    shown_s = seen_s(term)
    if shown_s is None:
        return None
    timed, shapes = [c.parameter == TIME for c in term.candidate.coordinates], []
    for shape in term.candidate.shapes:
        known = zip(timed, shape.origin, strict=True)
        origin = tuple(shown_s + by_s if is_time else x for is_time, x in known)
        shapes.append(replace(shape, origin=origin))
    return Term(replace(term.candidate, shapes=tuple(shapes)), term.at)


def late_of(terms: Sequence[Term]) -> float:
    """How late the readings are by the terms [s]."""
    late = [t.candidate.values(t.at)[TIME] for t in terms if t.candidate.kind.port is Port.CLOCK]
    return float(np.sum(late))


def _moved_by(term: Term, late_s: float) -> Term:
    shown_s = seen_s(term)
    if shown_s is None:
        return term
    at = term.at.copy()
    at[[c.parameter for c in term.candidate.coordinates].index(TIME)] = shown_s - late_s
    return Term(term.candidate, np.asarray(at))
