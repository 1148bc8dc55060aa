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
        self._ends = {key: CARDS[key].by_operator[machine].ends(flow) for key in self._kinds}
        able = [key for key in self._kinds if self._most(key) > 1.0 + LONE.least_by_operator]
        self.keys = tuple(
            sorted(able, key=lambda key: (self._kinds[key].port, self._kinds[key].order))
        )
        """In the order in which they act."""

    def regressors(self, saturated: bool) -> list[Regressor]:
        """One for each. saturated: see `Regressor`."""
        found = []
        for key in self.keys:
            most = self._most(key)
            size = Size(MOVED, "flat", most - 1.0, 1.0, most, 1e-3)
            place = f"{self._machine}/{key}"
            found.append(named(place, sizes=(size,), alone=False, saturated=saturated))
        return found

    def _most(self, key: str) -> float:
        """Of the size that a fit moves, which is 1 where nothing happens: parameter over its end
        there, or the reciprocal.
        """
        nothing, most = self._ends[key]
        over, under = (nothing, most) if self._main(key).reciprocal else (most, nothing)
        return over / under if over > 0.0 and under > 0.0 else 1.0

    def entry(self, key: str, sizes: Sizes) -> EffectEntry:
        """The effect as a robot file has it, at a size of the fit."""
        value = float(self._value(key, np.asarray(sizes[f"{key}.{MOVED}"])))
        return EffectEntry(
            effect=key, component=COMPONENT, parameters={self._main(key).name: value}
        )

    def starts(self, key: str) -> list[dict[str, float]]:
        """Of the fit."""
        shares = np.linspace(0.0, 1.0, LONE.starts_by_operator + 2)[1:-1]
        return [{f"{key}.{MOVED}": float(self._most(key) ** share)} for share in shares**2]

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
            not 1.0 + near < sizes[f"{key}.{MOVED}"] < (1.0 - near) * self._most(key)
            for key in {*keys} & {*self.keys}
        )

    def operate(self, key: str, flow: Flow, sizes: Sizes) -> None:
        """Change a flow in place as the effect does at a size of the fit."""
        entry = self.entry(key, sizes)
        activate(self._kinds[key], entry.component, entry.parameters).act(flow)

    def _value(self, key: str, moved: FloatArray) -> FloatArray:
        nothing, _ = self._ends[key]
        return nothing / moved if self._main(key).reciprocal else nothing * moved

    def _main(self, key: str) -> Parameter:
        return self._kinds[key].main
