"""The fit of a set less one regressor is no worse than where the larger set's fit ended."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from deltactl.diagnosis.evidence.effective_size import Rows, tempered
from deltactl.diagnosis.evidence.laplace import Laplace
from deltactl.diagnosis.observations.readings import FloatArray
from deltactl.diagnosis.plants.regression import RegressionPlant
from deltactl.diagnosis.plants.regressor import Columns, Regressor, Size, Sizes

TRUE_HZ, WRONG_HZ = 3.0, 4.6


class Wave(RegressionPlant):
    """A wave whose frequency starts in the wrong minimum, and a constant that is not there."""

    unit = "m"

    def __init__(self) -> None:
        rng = np.random.default_rng(7)
        self.t_s = np.arange(300) / 100.0
        self.observed = np.sin(2.0 * np.pi * TRUE_HZ * self.t_s) + 0.05 * rng.standard_normal(300)
        self.rows = np.arange(300)
        self.groups = self.kinds = np.zeros(300, dtype=np.intp)
        hertz = Size("hz", "flat", 10.0, 0.5, 10.0, 1e-3)
        self.regressors = (
            Regressor("wave", "resonance", -1.0, sizes=(hertz,)),
            Regressor("constant", "home_offset", -1.0),
        )

    def base(self, keys: frozenset[str], sizes: Sizes) -> FloatArray:
        if "wave" not in keys:
            return np.zeros(300)
        wave: FloatArray = np.sin(2.0 * np.pi * sizes["wave.hz"] * self.t_s)
        return wave

    def columns(self, key: str, base: FloatArray, sizes: Sizes) -> Columns:
        if key == "wave":
            return Columns(np.zeros((300, 0)), np.zeros(0))
        return Columns(np.ones((300, 1)), np.ones(1), ("size",))

    def starts(self, key: str, residual: FloatArray) -> list[dict[str, float]]:
        return [{"wave.hz": WRONG_HZ}] if key == "wave" else [{}]


@pytest.mark.parametrize("known", [False, True], ids=["new", "evaluated before"])
def test_a_smaller_set_starts_where_a_larger_one_ended(known: bool) -> None:
    plant = Wave()
    noise = tempered(
        0.05 * np.random.default_rng(1).standard_normal(300),
        Rows(plant.rows, plant.groups, plant.kinds, plant.noises, 1e-9),
    )
    evidence = Laplace(plant, noise)
    both = replace(evidence({"wave", "constant"}), sizes={"wave.hz": TRUE_HZ + 0.02})
    if known:
        assert evidence({"wave"}).sizes["wave.hz"] != pytest.approx(TRUE_HZ, abs=0.1)
    assert evidence({"wave"}, [both]).sizes["wave.hz"] == pytest.approx(TRUE_HZ, abs=0.01)
