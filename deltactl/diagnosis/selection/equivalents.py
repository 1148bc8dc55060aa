"""Effects that do exactly the same to everything that is observed, and how to convert one."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np

from deltactl.diagnosis.plants.candidate import Candidate, Term
from deltactl.models.effects import card_of
from deltactl.models.effects.card import Equal, Sizes


def equivalents_of(terms: Sequence[Term], candidates: Sequence[Candidate]) -> list[Term]:
    """The candidates where they do what the terms do together, as their card has it (`equals`)."""
    effects = {term.candidate.effect for term in terms}
    if len(effects) != 1:
        return []
    equals = {one.other: one for one in card_of(effects.pop()).equals}
    return [
        Term(other, at)
        for other in candidates
        if (equal := equals.get(other.effect)) and _in_place(equal, terms, other)
        for at in _sizes(equal, terms, other)
    ]


def _in_place(equal: Equal, terms: Sequence[Term], other: Candidate) -> bool:
    if equal.common:
        return bool(other.members) or len(terms) > 1
    return len(terms) == 1 and other.component == terms[0].candidate.component


def _sizes(equal: Equal, terms: Sequence[Term], other: Candidate) -> list[np.ndarray[Any, Any]]:
    """Coordinates of the other; of several terms the mean. None where it has others, or no size."""
    every = [
        equal.sizes(_numbers(term.candidate.values(term.at)), _numbers(other.fixed))
        for term in terms
    ]
    names = [coordinate.parameter for coordinate in other.coordinates]
    if any(set(sizes) != {*names} for sizes in every[0]):
        return []
    at = np.mean([[[sizes[name] for name in names] for sizes in sets] for sets in every], axis=0)
    return list(at) if np.any(at) else []


def _numbers(values: Mapping[str, Any]) -> Sizes:
    return {name: float(x) for name, x in values.items() if np.ndim(x) == 0}
