"""Selection where all is linear near a point only: choose there, fit to the end, columns anew.

A plant that is linear everywhere has one point. For any other, the chosen set is fitted to its end,
which is the next point; sets that were fitted to their end count by that fit.
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from deltactl.diagnosis.evidence.effective_size import TemperedNoise
from deltactl.diagnosis.evidence.laplace import Laplace
from deltactl.diagnosis.plants.regression import RegressionPlant
from deltactl.diagnosis.progress import Progress
from deltactl.diagnosis.selection.model_posterior import HillClimb, Posterior
from deltactl.diagnosis.selection.named_first import Selected
from deltactl.diagnosis.selection.options import SELECTION


def select_near(plant: RegressionPlant, progress: Progress) -> Selected:
    """The chosen explanation of a plant that is linear only near one."""
    progress("searching for what is missing")
    plant, evidence, found = chosen(plant, progress)
    chances = {r.key: found.probability(r.key) for r in plant.regressors}
    return Selected(plant, evidence, found, chances, found.nothing, found.best, {}, evidence)


Found = tuple[RegressionPlant, Laplace, Posterior]


def chosen(plant: RegressionPlant, progress: Progress) -> Found:
    """The plant near the best set, with the evidence there and the posterior.

    Names first; then what has no name competes with them, beside the names and in their place.
    """
    first = _as_built(plant)
    named = _as_careful(_settled(plant, first))
    progress("what the named effects leave")
    beside, opened = named[0].opened(), plant.opened() if named[0].point else None
    found = [named]
    if opened is not None and (beside is not None or _may_replace(opened, first, named)):
        instead = _in_place_of_names(opened)
        if instead is not None and _better([named, instead]) is instead:
            return instead
    if beside is not None:
        found.append(_settled(beside))
    return _better(found)


def _better(found: Sequence[Found]) -> Found:
    """The one whose best set has most evidence under one noise."""
    noise = found[-1][0].noise_over([plant for plant, *_ in found])
    return max(found, key=lambda one: _weighed(one, noise))


def _may_replace(opened: RegressionPlant, first: Found, named: Found) -> bool:
    """Whether what has no name may be in the place of names: of many, or of tolerances, or where
    something without a name explains by itself more than all of them.
    """
    many = max(len(first[2].best.keys), len(named[0].point)) >= SELECTION.many_names
    if many or first[0].odds_of_care < 0.0:
        return True
    evidence = Laplace(opened, first[1].noise)
    alone = [evidence([one.key]).log_evidence for one in opened.regressors if one.unknown]
    return max(alone) > first[2].best.log_evidence


def _in_place_of_names(opened: RegressionPlant) -> Found | None:
    """Chosen from nothing on, with what has no name; None where none of it is."""
    first = _as_built(opened)
    return _settled(opened, first) if _has_unknown(first) else None


def _has_unknown(found: Found) -> bool:
    plant, _, weighed = found
    return bool(weighed.best.keys - plant.fitted)


def _weighed(found: Found, noise: TemperedNoise) -> float:
    """Log evidence of the best set under a noise."""
    plant, _, weighed = found
    return Laplace(plant, noise)(weighed.best.keys).log_evidence + plant.odds_of_care


def _as_careful(found: Found) -> Found:
    """The same, or what is chosen if the machine is built as its file says, by the evidence.

    Where tolerances take part of an effect, its own best fit is not reached.
    """
    careful = found[0].carefully()
    if careful is None:
        return found
    return _better([_settled(careful), found])


def _settled(plant: RegressionPlant, first: Found | None = None) -> Found:
    """Chosen near a point, fitted to its end, and again near there until it stays.

    first: what was chosen near the point, where that is known.
    """
    visited: dict[frozenset[str], RegressionPlant] = {}
    for _ in range(SELECTION.most_points):
        plant, evidence, found = first or _as_built(plant)
        first = None
        named = found.best.keys & plant.fitted
        if named == plant.point and plant.holds_at(found.best):
            return plant, evidence, found
        if named in visited:
            break
        plant = plant.moved_to(found.best)
        visited[named] = plant
    noise = plant.noise_over(list(visited.values()))
    tried = []
    for one in visited.values():
        evidence = Laplace(one, noise)
        unfitted = sorted({r.key for r in one.regressors} - one.fitted | one.point)
        tried.append((one, evidence, HillClimb(evidence, among=unfitted).run()))
    return max(tried, key=lambda each: each[2].best.log_evidence)


def _as_built(plant: RegressionPlant) -> Found:
    """The best set under the tolerances that the evidence prefers."""
    tried: list[tuple[float, RegressionPlant, Laplace, Posterior]] = []
    start: frozenset[str] = frozenset()
    for odds, one in plant.built():
        if tried and len(tried[0][3].best.keys) < SELECTION.careless_names:
            break
        evidence = Laplace(one, plant.own_noise, alike=tried[0][2] if tried else None)
        so_far = max((each[0] for each in tried), default=-np.inf)
        found = HillClimb(evidence).run(start, so_far - odds)
        start = found.best.keys
        tried.append((odds + found.best.log_evidence, one, evidence, found))
    return max(tried, key=lambda each: each[0])[1:]
