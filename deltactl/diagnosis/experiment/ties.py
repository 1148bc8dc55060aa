"""Explanations that one recording leaves tied, and how firmly it holds their parameters."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property

import numpy as np

from deltactl.diagnosis.observations.readings import FloatArray
from deltactl.diagnosis.plants.candidate import Term

Key = tuple[str, str]
Sides = tuple[list[str], list[str]]
"""`effect component` of what differs, on either side."""


@dataclass(frozen=True, eq=False)
class Explanation:
    """A fitted set of terms; what the recording says of their coordinates is `root`.

    always: nuisances beside them, whose coordinates come first. root: (p, p): |root (x - at)|^2 is
    what the recording's chi-square grows by away from `at`, with tolerances fitted along.
    """

    terms: tuple[Term, ...]
    always: tuple[Term, ...]
    root: FloatArray
    cost: float

    @property
    def everything(self) -> tuple[Term, ...]:
        """Nuisances, then terms: the order of the coordinates."""
        return (*self.always, *self.terms)

    @cached_property
    def at(self) -> FloatArray:
        """The moved coordinates, (p,)."""
        return np.array([t.at[i] for t in self.everything for i in t.candidate.moved])

    def moved_to(self, at: FloatArray) -> tuple[Term, ...]:
        """Everything at other coordinates (p,), within bounds."""
        moved, first = [], 0
        for term in self.everything:
            numbers = term.candidate.moved
            there = term.at.copy()
            there[numbers] = at[first : first + len(numbers)]
            first += len(numbers)
            moved.append(term.moved_to(there))
        return tuple(moved)


@dataclass(frozen=True, eq=False)
class Tie:
    """Two explanations; delta_chi2: how much worse the second one fits so far."""

    first: Explanation
    second: Explanation
    delta_chi2: float

    @classmethod
    def of(cls, first: Explanation, second: Explanation) -> Tie:
        """Tie of two explanations of the same recording."""
        return cls(first, second, second.cost - first.cost)

    @cached_property
    def only_first(self) -> tuple[Term, ...]:
        """What only the first explanation has."""
        return _without(self.first, self.second)

    @cached_property
    def only_second(self) -> tuple[Term, ...]:
        """What only the second explanation has."""
        return _without(self.second, self.first)

    @property
    def names(self) -> Sides:
        """What differs."""
        return _names(self.only_first), _names(self.only_second)

    @property
    def components(self) -> set[str]:
        """Those that the tie is about."""
        return {t.candidate.component for t in (*self.only_first, *self.only_second)}


def _without(one: Explanation, other: Explanation) -> tuple[Term, ...]:
    taken = {t.candidate.key for t in other.terms}
    return tuple(t for t in one.terms if t.candidate.key not in taken)


def _names(terms: tuple[Term, ...]) -> list[str]:
    parts = [(t.candidate, t.candidate.members or (t.candidate.component,)) for t in terms]
    return [f"{one.effect} {component}" for one, members in parts for component in members]
