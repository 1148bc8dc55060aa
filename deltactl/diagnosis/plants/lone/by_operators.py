"""Effects of a single axis that are fitted by their operators alone, as their cards say.

A column 'machine/effect' of such a card is no shape: the operator changes what passes along the
chain, and one nonlinear size moves its main parameter (or the reciprocal of it).
"""

from __future__ import annotations

from collections.abc import Iterable

import numpy as np

from deltactl.diagnosis.observations.readings import FloatArray
from deltactl.diagnosis.plants.lone.options import LONE
from deltactl.diagnosis.plants.regression import Regressor, Shown, Size, Sizes, named
from deltactl.models.chain.active import activate
from deltactl.models.effects import CARDS
from deltactl.models.effects.card import ByOperator
from deltactl.models.effects.flow import Flow
from deltactl.models.effects.kind import EffectKind, Parameter
from deltactl.models.effects.lone_axis import COMPONENT
from deltactl.models.robot import EffectEntry

MOVED = "moved"


class ByOperators:
    """Those of one kind of axis, `command` or `effort`."""

    def __init__(self, machine: str, kinds: dict[str, EffectKind], flow: Flow):
        """kinds: of the axis, in its units. flow: what comes to the operators by the robot file."""
        self._kinds = {
            name: kinds[name]
            for name, card in CARDS.items()
            if machine in card.by_operator and name in kinds
        }
        self._machine = machine
        self._scales = {key: self._fit(key).scale(flow) for key in self._kinds}
        self.keys = tuple(
            sorted(
                (key for key in self._kinds if self._scales[key] > 0.0),
                key=lambda key: (self._kinds[key].port, self._kinds[key].order),
            )
        )
        """In the order in which they act."""

    def regressors(self, saturated: bool) -> list[Regressor]:
        """One for each. saturated: see `Regressor`."""
        found = []
        for key in self.keys:
            fit = self._fit(key)
            size = Size(MOVED, "flat", fit.starts[-1], fit.low, fit.high, 1e-3)
            found.append(
                named(f"{self._machine}/{key}", sizes=(size,), alone=False, saturated=saturated)
            )
        return found

    def entry(self, key: str, sizes: Sizes) -> EffectEntry:
        """The effect as a robot file has it, at a size of the fit."""
        value = float(self._value(key, np.asarray(sizes[f"{key}.{MOVED}"])))
        return EffectEntry(
            effect=key, component=COMPONENT, parameters={self._main(key).name: value}
        )

    def starts(self, key: str) -> list[dict[str, float]]:
        """Of the fit."""
        return [{f"{key}.{MOVED}": start} for start in self._fit(key).starts]

    def shown(self, key: str) -> list[Shown]:
        """The main parameter."""
        kind = self._kinds[key]
        return [
            Shown(kind.main.name, kind.main.unit, lambda v: self._value(key, v[MOVED]),
                  kind.nothing)
        ]  # fmt: skip

    def impossible(self, keys: Iterable[str], sizes: Sizes) -> bool:
        """Whether one of a set is at an end of what was looked for."""
        near = LONE.near_bound
        return any(
            not (1.0 + near) * self._fit(key).low
            < sizes[f"{key}.{MOVED}"]
            < (1.0 - near) * self._fit(key).high
            for key in {*keys} & {*self.keys}
        )

    def operate(self, key: str, flow: Flow, sizes: Sizes) -> None:
        """Change a flow in place as the effect does at a size of the fit."""
        entry = self.entry(key, sizes)
        activate(self._kinds[key], entry.component, entry.parameters).act(flow)

    def _value(self, key: str, moved: FloatArray) -> FloatArray:
        scale = self._scales[key]
        return scale / moved if self._main(key).reciprocal else scale * moved

    def _fit(self, key: str) -> ByOperator:
        return CARDS[key].by_operator[self._machine]

    def _main(self, key: str) -> Parameter:
        return self._kinds[key].main
