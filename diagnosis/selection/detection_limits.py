"""What could not be tested in a recording, and the smallest effect that would have been seen."""

from __future__ import annotations

import numpy as np
from scipy.special import chdtri

from diagnosis.answer.records import NotTestable, SmallestDetectable
from diagnosis.answer.verdict import ALARM
from diagnosis.evidence.library import Entry
from diagnosis.observations.readings import FloatArray
from diagnosis.selection.stepwise import Search

POWER_SIGMA = 0.84
"""Further standard deviations for seeing it in four recordings out of five."""


def limits(search: Search) -> tuple[list[NotTestable], list[SmallestDetectable]]:
    """Both lists, by effect and component."""
    bank, scores = search.prepared.bank, search.scores_of_empty
    hidden = [
        NotTestable(
            effect=c.effect, component=c.component,
            why="nothing that was observed depends on it in this recording",
        )
        for c in bank.silent
        if not c.members
    ]  # fmt: skip
    tests = search.calibration.tests + search.event_tests
    sigma = float(np.sqrt(chdtri(1, ALARM / tests))) + POWER_SIGMA
    smallest: dict[tuple[str, ...], SmallestDetectable] = {}
    for number, entry in enumerate(bank.entries):
        if entry.candidate is None or entry.shape is None or not entry.shape.linear:
            continue
        if entry.candidate.members:
            continue
        size = _size(entry, scores.information[number], sigma)
        if size is None:
            hidden.append(
                NotTestable(
                    effect=entry.candidate.effect, component=entry.candidate.component,
                    why="what it would do cannot be told from what is always fitted",
                )
            )  # fmt: skip
            continue
        key = entry.key
        if key not in smallest or _better(entry, size, smallest[key].value):
            main = entry.candidate.kind.main
            smallest[key] = SmallestDetectable(
                effect=entry.candidate.effect, component=entry.candidate.component,
                parameter=main.name, value=size, unit=main.unit,
            )  # fmt: skip
    seen = {(s.effect, s.component) for s in smallest.values()}
    unique = {(h.effect, h.component): h for h in hidden if (h.effect, h.component) not in seen}
    return list(unique.values()), list(smallest.values())


def _size(entry: Entry, information: FloatArray, sigma: float) -> float | None:
    assert entry.candidate is not None
    assert entry.shape is not None
    number = entry.shape.linear[0]
    coordinate = entry.candidate.coordinates[number]
    inverse = np.linalg.pinv(information, rcond=1e-8, hermitian=True)
    if inverse[0, 0] <= 0.0:
        return None
    size = sigma * float(np.sqrt(inverse[0, 0]))
    if size > coordinate.high - coordinate.low:
        return None
    return 1.0 / size if coordinate.how == "reciprocal" else size


def _better(entry: Entry, size: float, than: float) -> bool:
    assert entry.candidate is not None
    reciprocal = entry.candidate.kind.main.reciprocal
    return size > than if reciprocal else size < than
