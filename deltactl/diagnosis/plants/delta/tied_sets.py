"""The run of a delta that distinguishes sets of effects which one recording leaves open."""

from __future__ import annotations

from collections.abc import Sequence
from functools import partial

import numpy as np
from scipy.linalg import block_diag

from deltactl.diagnosis.evidence.laplace import Explanation
from deltactl.diagnosis.experiment.design import EXPERIMENT
from deltactl.diagnosis.experiment.propose import Proposal, next_experiment
from deltactl.diagnosis.experiment.ties import Explanation as Tied
from deltactl.diagnosis.experiment.ties import Tie
from deltactl.diagnosis.plants.delta.beside_point import Absorbed
from deltactl.diagnosis.plants.delta.next_runs import next_runs
from deltactl.diagnosis.plants.delta.plant import DeltaPlant
from deltactl.diagnosis.plants.delta.safe_poses import MotionLimits


def next_run(
    plant: DeltaPlant, explanations: Sequence[Explanation], limits: MotionLimits | None
) -> Proposal:
    """explanations: of the posterior, the most probable first; limits: of the machine."""
    best, *others = explanations
    named = [one.keys & plant.fitted for one in (best, *others)]
    pairs = zip(others, named[1:], strict=True)
    open_ones = [one for one, keys in pairs if keys - named[0] and named[0] - keys]
    if not open_ones:
        return Proposal(None)
    first = fitted_set(plant, best)
    ties = [Tie.of(first, fitted_set(plant, one)) for one in open_ones[: EXPERIMENT.most_ties]]
    model = plant.recorded.model
    runs = partial(next_runs, model, limits)
    return next_experiment(model.readings, plant.own_noise.whitener, ties, runs)


def fitted_set(plant: DeltaPlant, explanation: Explanation) -> Tied:
    """A set at its end, with what the recording says of its sizes and of nuisances."""
    there, noise = plant.moved_to(explanation), plant.own_noise
    tolerances, nuisances = there.free(), there.recorded.free[3]
    slopes = [there.around.always_slopes(one) for one in there.around.always]
    slopes += [near.slopes for near in there.acting.values()]
    white = noise.whiten(np.concatenate([np.zeros((len(plant.observed), 0)), *slopes], axis=1))
    beside = noise.whiten((tolerances.values * tolerances.spread)[:, nuisances:])
    taken = Absorbed(beside)
    share = taken.share(white)
    gram = white.T @ white - share.T @ share
    known = [one.precision for one in there.recorded.model.nuisances]
    gram[:nuisances, :nuisances] += block_diag(*known)
    root = np.linalg.cholesky(gram + 1e-9 * np.diag(np.diag(gram) + 1e-300)).T
    left = noise.whiten(plant.observed - there.around.predicted)
    of_left = taken.share(left)
    cost = float(left @ left - of_left @ of_left)
    return Tied(tuple(there.at_work.values()), tuple(there.around.always), root, cost)
