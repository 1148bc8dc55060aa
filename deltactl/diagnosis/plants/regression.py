"""What the engine needs of a machine whose model error is a sum of known shapes of unknown size.

A single axis, a range sensor, a delta near a point says what it observed, which regressors may
explain it, and how sizes that are not linear (a lag, a width of play, a period) change its
prediction. The engine (`evidence.laplace`, `selection.model_posterior`) is written on this alone.

The contract is `RegressionPlant`, at the end. What it inherits has defaults, which only some kinds
of machine replace: how rows were read (`as_read`), what the answer adds (`answered`), and the
classes below.
"""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from functools import cached_property
from typing import Any, Self

import numpy as np

from deltactl.diagnosis.observations.readings import FloatArray, IntArray, Readings
from deltactl.diagnosis.plants.answered import Answered
from deltactl.diagnosis.plants.as_read import AsRead
from deltactl.diagnosis.plants.regressor import Columns, Regressor, Shown, Sizes


class NearPoint:
    """A machine that is linear near a point only, and built with more or less care.

    By default it is linear everywhere, and there is one way to build it.
    """

    regressors: tuple[Regressor, ...]
    at_once = math.inf
    """Regressors that are added near one point: of more, some make up for what is not linear."""
    own_noise: Any = None
    """The noise under which a plant that is linear near a point only was made."""

    @property
    def point(self) -> frozenset[str]:
        """Regressors at whose sizes the columns were made, where they depend on sizes."""
        return frozenset()

    @property
    def fitted(self) -> frozenset[str]:
        """Regressors that can be at work at a point: those with a name."""
        return frozenset(one.key for one in self.regressors if not one.unknown)

    def opened(self) -> RegressionPlant | None:
        """The same with what has no name as well, where any of it may be; else None."""
        return None

    def noise_over(self, plants: Sequence[RegressionPlant]) -> Any:
        """Noise under which sets near the points of several plants are compared."""
        return self.own_noise

    def built(self) -> Sequence[tuple[float, Self]]:
        """The same as if it had been built with other care, each with its log prior odds."""
        return [(0.0, self)]

    @property
    def odds_of_care(self) -> float:
        """Log prior odds that a machine is built with as much care as this one is taken for."""
        return 0.0

    def is_far(self, before: float, after: float) -> bool:
        """Whether so much was explained near a point that the rest may come from its nonlinearity.

        before, after: chi-square for each reading, above that of noise.
        """
        return False

    def holds_at(self, best: Any) -> bool:
        """Whether columns made here still hold at what an explanation adds without a name."""
        return True

    def moved_to(self, best: Any) -> Self:
        """The same with columns made at the sizes of an explanation, fitted to their end."""
        return self


class Charged:
    """Effects that are messier than their operators, and those of the robot file: what they leave.

    By default they leave nothing.
    """

    messy = False
    """Whether effects may leave some of the shapes of others, see `charged`."""
    nuisances = 0
    """How many of the first free columns are of the recording; the others are tolerances."""
    left_by_known: Sequence[tuple[float, FloatArray]] = ()
    """For each effect that the robot file has from an earlier diagnosis, the share of its power
    that it may leave, and what it does (n,)."""
    done_by_known: FloatArray | None = None
    """What all of them do (n,); None where the file has none."""

    def is_messy(self, keys: frozenset[str]) -> bool:
        """Whether any of a set may leave some of the shapes of others, see `charged`."""
        return False

    @property
    def sizeless(self) -> frozenset[str]:
        """Regressors at work at the point that have no size which could be none."""
        return frozenset()

    def power(self, key: str) -> float:
        """Chi-square of what a regressor does by itself; 0 of what has no size of its own."""
        return 0.0

    def charged(self, gains: Mapping[str, float]) -> float:
        """Chi-square of a set that is no evidence for it.

        gains: what each regressor adds to the fit, and how much it does by itself; '' for what is
        always fitted.
        """
        return 0.0


class WithoutName(AsRead):
    """What a model error without a name may follow; spline terms give way to a chosen set.

    They are kept in `_unknown`.
    """

    @cached_property
    def beside(self) -> FloatArray:
        """Shapes (n, j) of a chosen set: none yet."""
        return np.zeros((len(self.t_s), 0))

    @property
    def covariates(self) -> dict[str, FloatArray]:
        """What a model error may follow, name -> (n,)."""
        raise NotImplementedError

    def followed(self, key: str) -> FloatArray:
        """Covariate (n,) that an unknown follows; NaN where it does not act."""
        raise NotImplementedError

    def detail(self, key: str) -> int:
        """Pieces of the spline term of an unknown; 0 of one that has no number of its own."""
        return 0

    def keep_beside(self, shapes: FloatArray) -> None:
        """Spline terms must not take the place of these shapes (n, j) either."""
        self.beside = shapes
        self.__dict__.pop("_unknown", None)

    def map_finely(self, keys: frozenset[str], sizes: Sizes, left: FloatArray) -> bool:
        """Make the spline term over position as detailed as what a set leaves (n,) repeats there.

        Returns whether anything changed.
        """
        return False


class HeldOut:
    """Another recording or preparation, against which sizes of this one are held."""

    held: IntArray = np.zeros(0, dtype=np.intp)
    """Free columns of what the file has from an earlier diagnosis: at nothing it is as there."""

    def adopt(self, trained: Any) -> None:
        """Take over what shapes were made with, so that sizes of another recording hold here."""

    def begins(self, keys: frozenset[str]) -> list[str]:
        """Sizes of regressors, from -1 to 1, of how a recording begins, not of the machine."""
        return []

    @property
    def variant(self) -> RegressionPlant | None:
        """The same recording prepared another way that is as good; None where there is one way."""
        return None


class RegressionPlant(Answered, NearPoint, Charged, WithoutName, HeldOut):
    """A machine with its recording, for the evidence of sets of regressors.

    Every kind of machine says the five attributes, `columns`, `shown`, its `channel`, what a model
    error may follow (`covariates`), and which rows are alike (`kinds`).
    """

    regressors: tuple[Regressor, ...]
    observed: FloatArray
    """(n,) what is to be explained, in `unit`."""
    unit: str
    readings: Readings
    rows: IntArray
    """Rows that count: valid, and thinned to what can tell anything."""

    def base(self, keys: frozenset[str], sizes: Sizes) -> FloatArray:
        """Prediction (n,) with the nonlinear sizes of these regressors."""
        return np.zeros(len(self.groups))

    def free(self) -> Columns:
        """Shapes that are always fitted and never a finding."""
        return Columns.none(len(self.t_s))

    def columns(self, key: str, base: FloatArray, sizes: Sizes) -> Columns:
        """Shapes that a regressor adds to the prediction, around `base`."""
        raise NotImplementedError

    def shown(self, key: str) -> Sequence[Shown]:
        """What the answer says of the sizes of a regressor, the main parameter first."""
        raise NotImplementedError

    def starts(self, key: str, residual: FloatArray) -> Sequence[dict[str, float]]:
        """Where to start the nonlinear sizes of a regressor, given the residual without it (n,)."""
        own = next(one for one in self.regressors if one.key == key)
        names = [f"{key}.{size.name}" for size in own.sizes]
        return [dict(zip(names, start, strict=True)) for start in own.starts]

    def impossible(
        self, keys: frozenset[str], sizes: Sizes, linear: Mapping[str, FloatArray]
    ) -> bool:
        """Whether no machine has these sizes: one at a bound of its regressor, or beyond."""
        for one in self.regressors:
            if one.key not in keys:
                continue
            if one.above > -math.inf and linear[one.key][0] <= one.above:
                return True
            each = ((size.within, sizes[f"{one.key}.{size.name}"]) for size in one.sizes)
            if any(not low < value < high for (low, high), value in each):
                return True
        return False
