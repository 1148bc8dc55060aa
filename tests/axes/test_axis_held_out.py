"""Held-out figures and the alarm of a lone machine, by what is known of them beforehand."""

from __future__ import annotations

from types import SimpleNamespace
from typing import Any, ClassVar

import numpy as np
import pytest
from scipy.stats import f

from deltactl.diagnosis.assessment.options import ASSESSMENT
from deltactl.diagnosis.assessment.regression_holdout import beyond_noise, on_blocks, on_other_runs
from deltactl.diagnosis.assessment.significance import chance
from deltactl.diagnosis.evidence.effective_size import TemperedNoise
from deltactl.diagnosis.evidence.laplace import Laplace
from deltactl.diagnosis.plants.regression import RegressionPlant
from deltactl.diagnosis.plants.regressor import Columns, Regressor

COUNT = 500


class Slope(RegressionPlant):
    """A plant of one linear regressor, and of a jump in the middle that does not come back."""

    unit = "m"
    rounding = 0.0
    averages = False

    covariates: ClassVar[dict[str, np.ndarray]] = {}

    def __init__(self, seed: int, size: float):
        rng = np.random.default_rng(seed)
        self.t_s = np.arange(COUNT) / 50.0
        self.shapes = np.stack([rng.standard_normal(COUNT), self.t_s > 5.0], axis=1)
        self.observed = size * self.shapes[:, 0] + 0.01 * rng.standard_normal(COUNT)
        self.rows = np.arange(COUNT)
        self.groups = self.kinds = np.zeros(COUNT, dtype=np.intp)
        self.regressors = (
            Regressor("a", "gear_ratio", -1.0),
            Regressor("jump", "lost_steps", -1.0),
        )

    def base(self, keys: frozenset[str], sizes: dict[str, float]) -> np.ndarray:
        return np.zeros(COUNT)

    def columns(self, key: str, base: np.ndarray, sizes: dict[str, float]) -> Columns:
        one = self.shapes[:, [("a", "jump").index(key)]]
        return Columns(one, np.array([10.0]), (key,))

    def free(self) -> Columns:
        return Columns(np.zeros((COUNT, 0)), np.zeros(0))

    def begins(self, keys: frozenset[str]) -> list[str]:
        return []

    def starts(self, key: str, residual: np.ndarray) -> list[dict[str, float]]:
        return [{}]

    def impossible(self, *_: object) -> bool:
        return False

    def further_odds(self, *_: object) -> float:
        return 0.0

    def without_noise(self, *_: object) -> None:
        return None

    def adopt(self, other: Slope) -> None:
        """Nothing of the other run is needed here."""


def chosen(plant: Slope, keys: tuple[str, ...]) -> Any:
    ones = np.ones(COUNT)
    noise = TemperedNoise(plant.rows, ones / 0.01, 0.01 * ones, 1.0, float(COUNT))
    evidence = Laplace(plant, noise)  # type: ignore[arg-type]
    return SimpleNamespace(plant=plant, evidence=evidence, noise=noise, best=evidence(keys))


def test_a_block_takes_no_part_in_the_fit_that_it_is_held_against() -> None:
    """Another slope in one block: the others say what they say, and that block is off by all."""
    plant = Slope(1, 0.0)
    last = np.arange(COUNT) * ASSESSMENT.folds // COUNT == ASSESSMENT.folds - 1
    plant.observed[last] += 5.0 * plant.shapes[last, 0]
    after = on_blocks(chosen(plant, ("a",))).after
    per_block = []
    for block in range(ASSESSMENT.folds):
        held = np.arange(COUNT) * ASSESSMENT.folds // COUNT == block
        x, y = plant.shapes[:, 0], plant.observed
        size = (x[~held] @ y[~held]) / (x[~held] @ x[~held])
        per_block.append(np.mean((y[held] - size * x[held]) ** 2))
    assert after == pytest.approx(np.sqrt(np.mean(per_block)), rel=1e-3)


def test_before_is_without_what_was_found() -> None:
    plant = Slope(2, 1.0)
    blocks = on_blocks(chosen(plant, ("a",)))
    before, after = blocks.before, blocks.after
    assert before == pytest.approx(np.sqrt(np.mean(plant.observed**2)), rel=1e-6)
    assert after == pytest.approx(0.01, rel=0.1)


def test_an_event_is_not_carried_to_another_run_and_the_rest_is() -> None:
    plant, other = Slope(3, 1.0), Slope(4, 1.0)
    plant.observed[plant.t_s > 5.0] += 3.0
    selected = chosen(plant, ("a", "jump"))
    before, after = on_other_runs(selected, [other])  # type: ignore[list-item]
    assert before == pytest.approx(np.sqrt(np.mean(other.observed**2)), rel=1e-6)
    assert after == pytest.approx(0.01, rel=0.1)


class Follows(Slope):
    """Beside the slope, a curve of the place that has no name."""

    def __init__(self, seed: int, size: float):
        super().__init__(seed, size)
        self.place = np.random.default_rng(seed + 100).uniform(-1.0, 1.0, COUNT)
        self.shapes[:, 1] = self.place**2
        self.observed = self.observed + 3.0 * self.place**2
        self.regressors = (*self.regressors[:1], Regressor("unknown place", "unknown", -1.0))

    def columns(self, key: str, base: np.ndarray, sizes: dict[str, float]) -> Columns:
        return super().columns("a" if key == "a" else "jump", base, sizes)

    def followed(self, key: str) -> np.ndarray:
        return self.place

    def detail(self, key: str) -> int:
        return 0


def test_an_unknown_that_follows_the_place_is_carried_to_another_run() -> None:
    """Where the place was seen; beyond that nothing is said of it."""
    plant, other = Follows(5, 1.0), Follows(6, 1.0)
    selected = chosen(plant, ("a", "unknown place"))
    other.place *= 0.98
    other.observed += 3.0 * (0.98**2 - 1.0) * other.shapes[:, 1]
    before, after = on_other_runs(selected, [other])  # type: ignore[list-item]
    assert before > 1.0
    assert after == pytest.approx(0.01, rel=0.1)
    other.place[:100] = np.nan  # there it does not act
    other.observed[:100] = other.shapes[:100, 0]
    _, after = on_other_runs(selected, [other])  # type: ignore[list-item]
    assert after == pytest.approx(0.009, rel=0.1)


def test_what_another_run_counts_from_is_taken_over() -> None:
    """Its file may say nothing of the zero that the first run was held against."""

    class Zeroed(Slope):
        zero = 0.0

        def base(self, keys: frozenset[str], sizes: dict[str, float]) -> np.ndarray:
            return np.full(COUNT, self.zero)

        def adopt(self, other: Slope) -> None:
            self.zero = other.zero  # type: ignore[attr-defined]

    plant, other = Zeroed(7, 1.0), Zeroed(8, 1.0)
    plant.zero = 5.0
    for one in (plant, other):
        one.observed += 5.0
    assert on_other_runs(chosen(plant, ("a",)), [other])[1] == pytest.approx(0.01, rel=0.1)  # type: ignore[list-item]


@pytest.mark.parametrize(
    ("order", "foretold"), [("rises", True), ("falls", True), ("to and fro", False)]
)
def test_of_a_table_sorted_by_distance_each_block_is_spread_over_the_range(
    order: str, foretold: bool
) -> None:
    """What acts only far away is foretold from what stands beside it, not from what is near."""
    plant = Slope(9, 0.0)
    far = np.arange(COUNT) >= 4 * COUNT // ASSESSMENT.folds
    plant.shapes[:, 0] *= far
    plant.observed += 2.0 * plant.shapes[:, 0]
    distance = np.arange(COUNT) // 2 / 100.0  # two rows at each
    if order == "falls":
        distance = -distance
    if order == "to and fro":
        distance[::2] = 0.0
    plant.covariates = {"distance": distance}  # type: ignore[misc]
    assert (on_blocks(chosen(plant, ("a",))).after < 0.02) == foretold


def test_a_size_that_differs_from_part_to_part_is_known_no_better_than_that() -> None:
    """The jackknife over fifths, less what is noise; one that does not differ is left as it is."""
    plant, steady = Slope(10, 1.0), Slope(11, 1.0)
    fold = np.arange(COUNT) * ASSESSMENT.folds // COUNT
    x = plant.shapes[:, 0]
    plant.observed += 0.002 * np.array([1.0, -1.0, 1.2, -1.2, 0.0])[fold] * x
    without = [x[fold != k] @ plant.observed[fold != k] / (x[fold != k] @ x[fold != k])
               for k in range(ASSESSMENT.folds)]  # fmt: skip
    jackknife, noise = (ASSESSMENT.folds - 1) * np.var(without), 0.01**2 / (x @ x)
    selected = chosen(plant, ("a",))
    (found,) = beyond_noise(selected.best, on_blocks(selected)).values()
    assert found == pytest.approx(np.sqrt(jackknife - noise), rel=1e-3)
    assert found > 1.2 * np.sqrt(noise)
    even = chosen(steady, ("a",))
    assert beyond_noise(even.best, on_blocks(even)) == {}


def _fit(chi2: float, sizes: int) -> Any:
    """An explanation with so many sizes and no tolerances."""
    free, spreads = {"": np.zeros(0)}, np.ones(sizes)
    tangent = np.zeros((9, sizes))
    return SimpleNamespace(chi2=chi2, tangent=tangent, linear=free, spreads=spreads, charged=0.0)


@pytest.mark.parametrize(
    ("places", "tried"),
    [([None], 3.0), ([None] * 7, 21.0), ([None, 50.0, None], 56.0)],
)
def test_every_regressor_and_place_that_was_tried_counts_in_the_alarm(
    places: list[float | None], tried: float
) -> None:
    """Sidak to first order of an F test with as many readings as there are effectively."""
    regressors = [Regressor(str(n), "unknown", 0.0, places=one) for n, one in enumerate(places)]
    selected: Any = SimpleNamespace(
        noise=SimpleNamespace(effective=100.0), plant=SimpleNamespace(regressors=regressors)
    )
    better: Any = _fit(98.0, 2)
    worse: Any = _fit(118.0, 1)
    assert chance(selected, better, worse) == pytest.approx(tried * f.sf(20.0, 1, 98.0), rel=1e-6)
    noisy: Any = _fit(196.0, 2)
    more: Any = _fit(216.0, 1)
    assert chance(selected, noisy, more) == pytest.approx(
        min(1.0, tried * f.sf(10.0, 1, 98.0)), rel=1e-6
    )
    assert chance(selected, worse, worse) == 1.0
