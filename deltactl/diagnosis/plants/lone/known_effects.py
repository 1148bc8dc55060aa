"""What a robot file knows of a single axis from earlier diagnoses, as one recording shows it.

A file says how wide play is, not on which flank the teeth last touched: that is another one each
time. Left at the middle it would be off by half the play until the first reversal, which the next
diagnosis would have to explain. A start that the file states is kept.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from typing import Any

import numpy as np

from deltactl.diagnosis.observations.readings import FloatArray, IntArray
from deltactl.diagnosis.plants.lone.options import COMMANDED_AXIS
from deltactl.models.effects import Trait, has
from deltactl.models.effects.lone_axis import forms_of
from deltactl.models.robot import EffectEntry

START = "start"
Known = Sequence[EffectEntry]
Foretold = Callable[[Known], FloatArray]


def begun(
    known: Known, foretold: Foretold, observed: FloatArray, stretches: IntArray, constant: bool
) -> list[Known]:
    """For each stretch the same effects, each play from where the readings of it fit best.

    foretold: readings (n,) by effects. observed: (n,), NaN where nothing was read. stretches: (n,)
    number of the stretch of a row, from 0 on. constant: whether a constant between both means
    nothing. Stretches beyond those that a fit begins for itself begin in the middle of a play.
    """
    chosen: list[Known] = [known] * (int(stretches.max()) + 1)
    places = sorted(np.linspace(-1.0, 1.0, COMMANDED_AXIS.known_starts), key=abs)
    for number, entry in enumerate(known):
        if not has(entry.effect, Trait.HYSTERESIS) or START in entry.parameters:
            continue
        tried = [[_with(one, number, float(start)) for one in chosen] for start in places]
        left = np.stack([observed - foretold_by(one, foretold, stretches) for one in tried])
        best = _best(left, stretches, constant)
        chosen = [tried[place][stretch] for stretch, place in enumerate(best)]
    return chosen


def foretold_by(chosen: Sequence[Known], foretold: Foretold, stretches: IntArray) -> FloatArray:
    """Readings (n,) by the effects of each stretch."""
    made = np.empty(len(stretches))
    alike: dict[tuple[Any, ...], list[int]] = {}
    for number, known in enumerate(chosen):
        alike.setdefault(tuple(one.parameters.get(START) for one in known), []).append(number)
    for numbers in alike.values():
        rows = np.isin(stretches, numbers)
        made[rows] = foretold(chosen[numbers[0]])[rows]
    return made


def _best(left: FloatArray, stretches: IntArray, constant: bool) -> list[int]:
    """Which of the places each stretch begins at, by what they leave (places, n).

    A constant is shared by all stretches: first all begin alike, then one after the other.
    """
    read = np.isfinite(left[0])
    count = int(stretches.max()) + 1
    rows = np.bincount(stretches[read], minlength=count)
    sums, squares = (
        np.stack([np.bincount(stretches[read], one[read] ** power, count) for one in left])
        for power in (1, 2)
    )

    def missed(places: Sequence[int]) -> float:
        at = (list(places), range(count))
        mean = float(sums[at].sum()) / max(int(rows.sum()), 1) if constant else 0.0
        return float(squares[at].sum()) - mean**2 * float(rows.sum())

    every = range(len(left))
    best = [min(every, key=lambda place: missed([place] * count))] * count
    best[COMMANDED_AXIS.most_begins :] = [0] * len(best[COMMANDED_AXIS.most_begins :])
    for stretch in range(min(count, COMMANDED_AXIS.most_begins)):
        tried = [[*best[:stretch], place, *best[stretch + 1 :]] for place in every]
        best = min(tried, key=missed)
    return best


def may_leave(
    chosen: Sequence[Known],
    whole: FloatArray,
    foretold: Foretold,
    stretches: IntArray,
    constant: bool,
) -> list[tuple[float, FloatArray]]:
    """For each effect that was measured, what it does (n,), and which share of its power it may
    leave (`EffectKind.discrepancy`).

    chosen: of each stretch. whole: readings (n,) by all of them.
    """
    found = []
    for number, entry in enumerate(chosen[0]):
        if entry.found is not None:
            others = [[*known[:number], *known[number + 1 :]] for known in chosen]
            alone = whole - foretold_by(others, foretold, stretches)
            share = max(kind.discrepancy.elsewhere for kind in forms_of(entry.effect))
            found.append((share, alone - alone.mean() if constant else alone))
    return found


def _with(known: Known, number: int, start: float) -> Known:
    """The same effects, one play of them from another place."""
    entry = known[number]
    begins = entry.model_copy(update={"parameters": {**entry.parameters, START: start}})
    return [*known[:number], begins, *known[number + 1 :]]
