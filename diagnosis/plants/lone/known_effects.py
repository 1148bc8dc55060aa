"""What a robot file knows of a lone axis from earlier diagnoses, as one recording shows it.

A file says how wide play is, not on which flank the teeth last touched: that is another one each
time. Left at the middle it would be off by half the play until the first reversal, which the next
diagnosis would have to explain. A start that the file states is kept.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence

import numpy as np

from diagnosis.observations.readings import FloatArray
from diagnosis.plants.lone.options import COMMANDED_AXIS
from models.effects.lone_axis import forms_of
from models.robot import EffectEntry

PLAYS = ("gear_backlash", "joint_friction")
START = "start"
Known = Sequence[EffectEntry]
Foretold = Callable[[Known], FloatArray]


def begun(known: Known, foretold: Foretold, observed: FloatArray, constant: bool) -> Known:
    """The same effects, each play from where the recording fits best.

    foretold: readings (n,) by effects. observed: (n,), NaN where nothing was read.
    constant: whether a constant between both means nothing.
    """

    def missed(tried: Known) -> float:
        left = observed - foretold(tried)
        return float(np.nanmean(np.square(left - np.nanmean(left) if constant else left)))

    for number, entry in enumerate(known):
        if entry.effect in PLAYS and START not in entry.parameters:
            places = sorted(np.linspace(-1.0, 1.0, COMMANDED_AXIS.known_starts), key=abs)
            tried = [
                [*known[:number], _from(entry, float(start)), *known[number + 1 :]]
                for start in places
            ]
            known = min(tried, key=missed)
    return known


def may_leave(
    known: Known, whole: FloatArray, foretold: Foretold, constant: bool
) -> list[tuple[float, FloatArray]]:
    """Of each effect that was measured, what it does (n,), and which share of its power it may
    leave (`EffectKind.discrepancy`).

    whole: readings (n,) by all of them.
    """
    found = []
    for number, entry in enumerate(known):
        if entry.found is not None:
            alone = whole - foretold([*known[:number], *known[number + 1 :]])
            share = max(kind.discrepancy.elsewhere for kind in forms_of(entry.effect))
            found.append((share, alone - alone.mean() if constant else alone))
    return found


def _from(entry: EffectEntry, start: float) -> EffectEntry:
    """The same play from another place."""
    return entry.model_copy(update={"parameters": {**entry.parameters, START: start}})
