"""Selection where all is linear near a point only: choose there, fit to the end, columns anew.

A plant that is linear everywhere has one point. For any other, the chosen set is fitted to its end,
which is the next point; sets that were fitted to their end count by that fit.
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from deltactl.diagnosis.evidence.effective_size import TemperedNoise
from deltactl.diagnosis.evidence.explanation import Explanation
from deltactl.diagnosis.evidence.laplace import Laplace
from deltactl.diagnosis.plants.regression import RegressionPlant
from deltactl.diagnosis.progress import Progress
from deltactl.diagnosis.selection.model_posterior import HillClimb, Posterior, weighed
from deltactl.diagnosis.selection.named_first import Selected
from deltactl.diagnosis.selection.options import SELECTION


def select_near(plant: RegressionPlant, progress: Progress) -> Selected:
    """The chosen explanation of a plant that is linear only near one."""
    progress("searching for what is missing")
    points = NearPoints(plant)
    plant, climb, _ = chosen = points.chosen(progress)
    evidence, found = climb.evidence, points.posterior(chosen)
    chances = {r.key: found.probability(r.key) for r in plant.regressors}
    return Selected(plant, evidence, found, chances, found.nothing, found.best, {}, evidence)


Found = tuple[RegressionPlant, HillClimb, Explanation]
"""A plant near a point, the search there, and the set that it has chosen."""


class NearPoints:
    """Chooses near one point after another, and remembers which sets were fitted to their end."""

    def __init__(self, plant: RegressionPlant):
        self.plant = plant
        self._met: list[tuple[RegressionPlant, frozenset[str]]] = []

    def chosen(self, progress: Progress) -> Found:
        """The plant near the best set, with the search there and the set.

        Names first; then what has no name competes with them, beside the names and in their place.
        """
        first = self._as_built(self.plant)
        named = self._settled(self.plant, first)
        progress("what the named effects leave")
        beside, opened = named[0].opened(), self.plant.opened() if named[0].point else None
        found = [named]
        if opened is not None and (beside is not None or _may_replace(opened, first, named)):
            instead = self._in_place_of_names(opened)
            if instead is not None and _better([named, instead]) is instead:
                return instead
        if beside is not None:
            found.append(self._settled(beside))
        return _better(found)

    def posterior(self, chosen: Found) -> Posterior:
        """The sets near the chosen one, and each that was fitted to its own end by its evidence
        there.

        Near another point a set may look better than it is, so none counts more than the chosen.
        """
        plant, climb, best = chosen
        known = {r.key for r in plant.regressors}
        others = [(p, keys) for p, keys in self._met if keys <= known]
        noise = plant.noise_over([plant, *(p for p, _ in others)])
        level = _evidence(plant, best.keys, noise)
        ended: dict[frozenset[str], float] = {}
        for there, keys in others:
            behind = min(_evidence(there, keys, noise) - level, 0.0)
            ended[keys] = max(behind, ended.get(keys, -np.inf))
        own = best.keys & plant.fitted
        elsewhere = {keys & plant.fitted for keys in ended} - {own}
        near = [e for e in climb.posterior().explanations if e.keys & plant.fitted not in elsewhere]
        least = SELECTION.better_by
        apart = {e: min(e.log_evidence - best.log_evidence, -least) for e in near}
        apart |= {climb.evidence(keys): behind - least for keys, behind in ended.items()}
        apart[best] = 0.0
        return weighed(apart)

    def _in_place_of_names(self, opened: RegressionPlant) -> Found | None:
        """Chosen from nothing on, with what has no name; None where none of it is."""
        first = self._as_built(opened)
        return self._settled(opened, first) if first[2].keys - opened.fitted else None

    def _settled(self, plant: RegressionPlant, first: Found | None = None) -> Found:
        """Chosen near a point, fitted to its end, and again near there until it stays.

        first: what was chosen near the point, where that is known.
        """
        visited: dict[frozenset[str], tuple[RegressionPlant, frozenset[str]]] = {}
        for _ in range(SELECTION.most_points):
            plant, climb, best = first or self._as_built(plant)
            first = None
            named = best.keys & plant.fitted
            if named == plant.point and plant.holds_at(best):
                return plant, climb, best
            if named in visited:
                break
            plant = plant.moved_to(best)
            visited[named] = plant, plant.point | (best.keys - named)
            self._met.append(visited[named])
        noise = plant.noise_over([one for one, _ in visited.values()])
        plant, keys = max(visited.values(), key=lambda one: _evidence(one[0], one[1], noise))
        climb = HillClimb(Laplace(plant, noise))
        climb.looked_around(climb.evidence(keys))
        return plant, climb, climb.evidence(keys)

    def _as_built(self, plant: RegressionPlant) -> Found:
        """The best set under the tolerances that the evidence prefers."""
        tried: list[tuple[float, Found]] = []
        start: frozenset[str] = frozenset()
        for odds, one in plant.built():
            if tried and len(tried[0][1][2].keys) < SELECTION.careless_names:
                break
            alike = tried[0][1][1].evidence if tried else None
            climb = HillClimb(Laplace(one, plant.own_noise, alike=alike))
            so_far = max((each[0] for each in tried), default=-np.inf)
            best = climb.climbed(start, so_far - odds)
            start = best.keys
            tried.append((odds + best.log_evidence, (one, climb, best)))
            if best.keys & one.fitted == one.point:
                self._met.append((one, best.keys))
        return max(tried, key=lambda each: each[0])[1]


def _may_replace(opened: RegressionPlant, first: Found, named: Found) -> bool:
    """Whether what has no name may be in the place of names: of many, or of tolerances, or where
    something without a name explains by itself more than all of them.
    """
    many = max(len(first[2].keys), len(named[0].point)) >= SELECTION.many_names
    if many or first[0].odds_of_care < 0.0:
        return True
    evidence = Laplace(opened, first[1].evidence.noise)
    alone = [evidence([one.key]).log_evidence for one in opened.regressors if one.unknown]
    return max(alone) > first[2].log_evidence


def _better(found: Sequence[Found]) -> Found:
    """The one whose best set has most evidence under one noise; of equals the last."""
    noise = found[-1][0].noise_over([plant for plant, *_ in found])
    return max(reversed(found), key=lambda one: _evidence(one[0], one[2].keys, noise))


def _evidence(plant: RegressionPlant, keys: frozenset[str], noise: TemperedNoise) -> float:
    """Log evidence of a set near a point, under a noise."""
    return Laplace(plant, noise)(keys).log_evidence + plant.odds_of_care
