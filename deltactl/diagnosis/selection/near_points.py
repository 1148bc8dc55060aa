"""Selection where all is linear near a point only: choose there, fit to the end, columns anew.

A plant that is linear everywhere has one point. Of another, the chosen set is fitted to its end,
which is the next point; sets that were fitted to their end count by that fit.
"""

from __future__ import annotations

from deltactl.diagnosis.evidence.detection import Progress
from deltactl.diagnosis.evidence.laplace import Laplace
from deltactl.diagnosis.plants.regression import RegressionPlant
from deltactl.diagnosis.selection.model_posterior import HillClimb, Posterior
from deltactl.diagnosis.selection.named_first import Selected
from deltactl.diagnosis.selection.options import SELECTION


def select_near(plant: RegressionPlant, progress: Progress) -> Selected:
    """The chosen explanation of a plant that is linear only near one."""
    progress("searching for what is missing")
    plant, evidence, found = chosen(plant, progress)
    chances = {r.key: found.probability(r.key) for r in plant.regressors}
    return Selected(plant, evidence, found, chances, found.nothing, found.best, {}, evidence)


def chosen(
    plant: RegressionPlant, progress: Progress
) -> tuple[RegressionPlant, Laplace, Posterior]:
    """The plant near the best set, with the evidence there and the posterior."""
    visited: dict[frozenset[str], RegressionPlant] = {}
    for _ in range(SELECTION.points):
        plant, evidence, found = _as_built(plant)
        if found.best.keys == plant.point:
            return plant, evidence, found
        if found.best.keys in visited:
            break
        plant = plant.moved_to(found.best)
        visited[found.best.keys] = plant
    noise = plant.own_noise
    each = {keys: Laplace(one, noise)(keys).log_evidence for keys, one in visited.items()}
    best = visited[max(each, key=lambda keys: each[keys])]
    evidence = Laplace(best, noise)
    return best, evidence, HillClimb(evidence, among=sorted(best.point)).run()


def _as_built(plant: RegressionPlant) -> tuple[RegressionPlant, Laplace, Posterior]:
    """The best set under the tolerances that the evidence prefers."""
    tried = []
    for odds, one in plant.built():
        evidence = Laplace(one, plant.own_noise)
        found = HillClimb(evidence).run()
        tried.append((odds + found.best.log_evidence, one, evidence, found))
    return max(tried, key=lambda each: each[0])[1:]
