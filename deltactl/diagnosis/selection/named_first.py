"""Named effects first, unknown physics is what they leave, then what was open is asked again.

An unknown that follows position could take the place of a ratio, an offset, a scale. So named
regressors are chosen under a noise in which smooth discrepancy counts as noise; spline terms, made
orthogonal to the named ones, are looked for in what is left; and where one is found, the named
regressors that are neither sure nor out of the question are chosen once more beside it.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

from deltactl.diagnosis.evidence.effective_size import TemperedNoise
from deltactl.diagnosis.evidence.explanation import Explanation
from deltactl.diagnosis.evidence.laplace import Laplace
from deltactl.diagnosis.evidence.tempering import noise_beyond, saturated_noise
from deltactl.diagnosis.observations.readings import FloatArray
from deltactl.diagnosis.plants.regression import RegressionPlant
from deltactl.diagnosis.plants.regressor import Sizes
from deltactl.diagnosis.progress import Progress
from deltactl.diagnosis.selection.model_posterior import HillClimb, Posterior, posterior
from deltactl.diagnosis.selection.options import SELECTION


@dataclass(frozen=True, slots=True, eq=False)
class Selected:
    """The chosen explanation, the evidence it was chosen by, and how probable its parts are."""

    plant: RegressionPlant
    evidence: Laplace
    posterior: Posterior
    probability: dict[str, float]
    """Probability of every regressor that was tried."""
    nothing: float
    """Probability that nothing is missing."""
    named: Explanation
    """The named regressors alone: what spline terms are orthogonal to."""
    shift: dict[str, float]
    """How far each size of the best set moves under another preparation, in SI units."""
    left_over: Laplace
    """The evidence of spline terms in what the explanation leaves."""

    @property
    def best(self) -> Explanation:
        """The chosen explanation."""
        return self.posterior.best

    @property
    def empty(self) -> Explanation:
        """Explanation by the robot file, and what is off on any machine, under the same noise."""
        return self.evidence(self.best.keys - self.best.found, [self.best])

    @property
    def noise(self) -> TemperedNoise:
        """The noise under which it was chosen."""
        return self.evidence.noise


def select(plant: RegressionPlant, progress: Progress) -> Selected:
    """Named regressors, what they leave, and both together where that is unknown physics."""
    progress("noise of the readings")
    noise = saturated_noise(plant)
    progress("searching for what is missing")
    evidence = Laplace(plant, noise)
    named = HillClimb(evidence).run()
    for _ in range(SELECTION.naming_rounds - 1):
        evidence = Laplace(plant, noise_beyond(plant, named.best), evidence)
        again = HillClimb(evidence).run()
        settled, named = again.best.keys == named.best.keys, again
        if settled:
            break
    progress("what the named effects leave")
    plant.keep_beside(shapes_of(plant, named.best.keys, named.best.sizes))
    free, left = _left_over(plant, named.best)
    if plant.map_finely(named.best.keys, named.best.sizes, left.best.residual):
        named, free, left = _beside_map(plant, evidence, named)
    chances = {r.key: (left if r.left_over else named).probability(r.key) for r in plant.regressors}
    nothing = named.nothing * left.without([r.key for r in plant.regressors if r.left_over])
    beyond = left.best.keys - named.best.keys
    unknown = frozenset(key for key in beyond if left.probability(key) > SELECTION.likely)
    if not unknown:
        shift = _shift(plant, named.best)
        return Selected(plant, evidence, named, chances, nothing, named.best, shift, free)
    return _beside(plant, free, unknown, named, chances, nothing)


def _left_over(plant: RegressionPlant, named: Explanation) -> tuple[Laplace, Posterior]:
    """Spline terms in what the named effects leave.

    Under the noise of that search the sizes of named effects may be such as no machine has (play
    below a step of the reading): nothing can be weighed beside them then.
    """
    free = Laplace(plant, noise_beyond(plant, named, left_over=True))
    if not np.isfinite(free(named.keys, [named]).log_evidence):
        return free, Posterior([named], [1.0])
    return free, HillClimb(free, named.keys, left_over=True).run()


def _beside_map(
    plant: RegressionPlant, evidence: Laplace, named: Posterior
) -> tuple[Posterior, Laplace, Posterior]:
    """The same once the spline term over position is a map in detail.

    A wave is a part of any map, and fits of the largest of its waves would call each map a gear's
    error. It is named beside one only if it is most of it.
    """
    waves = {r.key for r in plant.regressors if r.mapped}
    if named.best.keys & waves:
        fewer = posterior(one for one in evidence.evaluated if not one.keys & waves)
        plant.keep_beside(shapes_of(plant, fewer.best.keys, fewer.best.sizes))
        free, left = _left_over(plant, fewer.best)
        without, wave, mapped = (
            float(np.sum(one.residual[plant.rows] ** 2))
            for one in (fewer.best, named.best, left.best)
        )
        if without - wave < SELECTION.most_of_map * (without - mapped):
            return fewer, free, left
        plant.keep_beside(shapes_of(plant, named.best.keys, named.best.sizes))
    return named, *_left_over(plant, named.best)


def _beside(
    plant: RegressionPlant,
    free: Laplace,
    unknown: frozenset[str],
    named: Posterior,
    chances: dict[str, float],
    nothing: float,
) -> Selected:
    """Choose among what was open, or is needless beside the unknown, beside what is sure.

    The unknown gives way to what is sure. What was searched for at many places never is: one of
    them may imitate an unknown.
    """
    placed = {r.key for r in plant.regressors if r.places is not None}
    sure = frozenset(k for k in named.best.keys - placed if chances[k] > SELECTION.sure)
    sizes = {k: v for k, v in named.best.sizes.items() if k.rpartition(".")[0] in sure}
    plant.keep_beside(shapes_of(plant, sure, sizes))
    free = Laplace(plant, free.noise)
    likely = {key for key, p in chances.items() if p > SELECTION.open}
    opened = sorted(likely | sure | unknown)
    climb = HillClimb(free, among=opened)
    climb.climbed(sure | unknown)
    both = climb.posterior()
    found = {**chances, **{key: both.probability(key) for key in opened}}
    return Selected(plant, free, both, found, nothing, named.best, _shift(plant, both.best), free)


def shapes_of(plant: RegressionPlant, keys: frozenset[str], sizes: Sizes) -> FloatArray:
    """What small changes of all sizes of a set look like in the prediction, (n, j)."""
    by_key = {r.key: r for r in plant.regressors}
    base = plant.base(keys, sizes)
    shapes = [plant.columns(key, base, sizes).values for key in sorted(keys)]
    for key in sorted(keys):
        for size in by_key[key].sizes:
            name = f"{key}.{size.name}"
            if size.smooth and name in sizes:
                moved = plant.base(keys, {**sizes, name: sizes[name] + size.step})
                shapes.append(((moved - base) / size.step)[:, None])
    return np.concatenate([np.zeros((len(base), 0)), *shapes], axis=1)


def _shift(plant: RegressionPlant, best: Explanation) -> dict[str, float]:
    """Model discrepancy of the sizes: their change under another preparation of the recording, and
    the tolerance that a size takes the place of.
    """
    other = plant.variant
    if other is None or not best.keys:
        return {}
    free = plant.free()
    tolerances = dict(zip(free.names, map(float, free.spread), strict=False))
    within = {
        f"{r.key}.{r.sizes[-1].name}": tolerances[r.takes_over]
        for r in plant.regressors
        if r.sizes and r.key in best.keys and r.takes_over in tolerances
    }
    keys = frozenset(key for key in best.keys if not key.startswith("unknown "))
    again = named_sizes(Laplace(other, saturated_noise(other))(keys, [best]))
    return {
        name: math.hypot(abs(again[name] - size), within.get(name, 0.0))
        for name, size in named_sizes(best).items()
        if name in again
    }


def named_sizes(explanation: Explanation) -> dict[str, float]:
    """All sizes of an explanation by `key.size`, linear and other."""
    linear = [x for key in ("", *sorted(explanation.keys)) for x in explanation.linear[key]]
    names = [name for name in explanation.names if name not in explanation.sizes]
    return {**dict(zip(names, map(float, linear), strict=True)), **explanation.sizes}
