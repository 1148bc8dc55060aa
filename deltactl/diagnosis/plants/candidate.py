"""An effect on a component as the fit sees it: coordinates it moves in, and where to start."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

import numpy as np

from deltactl.diagnosis.observations.readings import FloatArray
from deltactl.models.chain import Active
from deltactl.models.effects import EffectKind
from deltactl.models.effects.card import Coordinate, Shape


@dataclass(frozen=True, slots=True, eq=False)
class Candidate:
    """One effect on one component."""

    kind: EffectKind
    component: str
    coordinates: tuple[Coordinate, ...]
    shapes: tuple[Shape, ...]
    fixed: Mapping[str, Any]
    members: tuple[str, ...] = ()
    """Components that act together, for a group (`shared_parameters`)."""

    @property
    def effect(self) -> str:
        """Name in the vocabulary."""
        return self.kind.name

    @property
    def key(self) -> tuple[str, str]:
        """What tells it from other candidates."""
        return (self.effect, self.component)

    @property
    def in_group(self) -> set[tuple[str, str]]:
        """Effects and components that a group is made of; none of a single one."""
        return {(self.effect, member) for member in self.members}

    @property
    def moved(self) -> list[int]:
        """Numbers of the coordinates the fit moves."""
        return [i for i, c in enumerate(self.coordinates) if c.how != "frozen"]

    def values(self, at: FloatArray) -> dict[str, FloatArray]:
        """Parameters in SI units at coordinates `at`."""
        values: dict[str, Any] = {name: np.asarray(value) for name, value in self.fixed.items()}
        sizes = {p.name: p.size for p in self.kind.parameters}
        waves: dict[str, float] = {}
        for coordinate, x in zip(self.coordinates, at, strict=True):
            name = coordinate.parameter
            if coordinate.how in ("sine", "cosine"):
                waves[coordinate.how] = float(x)
            elif coordinate.how == "reciprocal":
                values[name] = np.asarray(1.0 / x if x else np.inf)
            elif coordinate.how == "log":
                values[name] = np.asarray(np.exp(x))
            elif sizes[name] > 1:
                values.setdefault(name, np.zeros(sizes[name]))
                values[name] = values[name].copy()
                values[name][coordinate.part] = x
            else:
                values[name] = np.asarray(x)
        if waves:
            values["amplitude"] = np.asarray(np.hypot(waves["sine"], waves["cosine"]))
            values["phase"] = np.asarray(np.arctan2(waves["cosine"], waves["sine"]))
        return values

    def active(self, at: FloatArray) -> Active:
        """The effect at coordinates `at`, ready for the chain."""
        return Active(self.kind, self.component, self.values(at))


@dataclass(frozen=True, slots=True, eq=False)
class Term:
    """A candidate at coordinates."""

    candidate: Candidate
    at: FloatArray

    def moved_to(self, at: FloatArray) -> Term:
        """The same candidate elsewhere, within its bounds."""
        low = np.array([c.low for c in self.candidate.coordinates])
        high = np.array([c.high for c in self.candidate.coordinates])
        return Term(self.candidate, np.clip(at, low, high))

    @property
    def active(self) -> Active:
        """Ready for the chain."""
        return self.candidate.active(self.at)
