"""What the engine needs of a machine whose model error is a sum of known shapes of unknown size.

A single axis, a range sensor or a joint of a servo robot says what it observed, which regressors
may explain it, and how sizes that are not linear (a lag, a width of play, a period) change its
prediction. The engine (`evidence.laplace`, `selection.model_posterior`) is written on this alone.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from functools import cached_property
from typing import Any, Literal

import numpy as np

from deltactl.diagnosis.answer.finding import IN_ALL, Finding, ParameterResult
from deltactl.diagnosis.answer.picture import Picture
from deltactl.diagnosis.answer.records import NotTestable
from deltactl.diagnosis.answer.verdict import Rest
from deltactl.diagnosis.observations.largest_noise import (
    Bound,
    NoiseBounds,
    remembering,
    segment_for,
    spectrum,
)
from deltactl.diagnosis.observations.readings import BoolArray, FloatArray, IntArray, Readings
from deltactl.diagnosis.observations.stale_readings import Stale
from deltactl.models.effects import column_of, stand_ins

Sizes = Mapping[str, float]
"""Nonlinear sizes by `regressor.size`, in SI units."""
Prior = Literal["half", "flat"]


@dataclass(frozen=True, slots=True)
class Size:
    """A size in which the prediction is not linear.

    half: half-normal prior of this spread from zero on. flat: any value from low to high alike.
    step: for numerical derivatives. smooth False: a place in time; its derivative says nothing,
    and `choices` is how many there were to choose from.
    """

    name: str
    prior: Prior
    spread: float
    low: float
    high: float
    step: float
    smooth: bool = True
    choices: float = 1.0
    within: tuple[float, float] = (-math.inf, math.inf)
    """At these ends and beyond, a size sits at its bound and was not found."""


@dataclass(frozen=True, slots=True)
class Equivalent:
    """Another effect that is the same operator in this recording, with its odds against this."""

    effect: str
    log_odds: float
    only_if_zero: str = ""
    """The equivalent applies only while this size of the regressor is (nearly) zero."""


@dataclass(frozen=True, slots=True)
class Regressor:
    """One way in which a machine may differ from its robot file.

    log_odds: natural logarithm of the prior odds that a machine has it (source at the plant).
    beside: regressors of which one must be in the set as well. knows: what an unknown follows.
    """

    key: str
    effect: str
    log_odds: float
    component: str = "axis"
    members: tuple[str, ...] = ()
    """Components at which it acts alike, where they are several."""
    sizes: tuple[Size, ...] = ()
    equivalents: tuple[Equivalent, ...] = ()
    beside: tuple[str, ...] = ()
    follows: tuple[str, ...] = ()
    apart_from: tuple[str, ...] = ()
    """Regressors that it must be distinguished from to be seen as what it is: of a ratio the
    offset, which shows as the same over a short stroke far from zero."""
    alone: bool = True
    """Whether it is tried with any other as a pair from the start."""
    saturated: bool = True
    """Whether it is part of the saturated set that shows the noise."""
    constant: bool = False
    """This motion makes it a constant: weighed against a zero, it shows no size of its own."""
    positive: tuple[str, ...] = ()
    """Linear sizes that no machine has below zero."""
    as_built: float = 0.0
    """Size up to which any machine is off, so that it is no finding."""
    built_so: float = 0.0
    """Size up to which it says how the machine was built beside what does not, and is no finding
    there."""
    takes_over: str = ""
    """Name of the free column that is a tolerance of the same quantity."""
    measured_by: str = ""
    """Size of another regressor, by its full name, that `shown` needs where a set has it."""
    mapped: bool = False
    """A map of the position in detail has it as well: beside one it must be distinct."""
    left_over: bool = False
    """A spline term that is only looked for in what the named effects leave."""
    places: float | None = None
    """Independent moments or periods that were searched for it; None where it has no such place."""
    above: float = -math.inf
    """What its first linear size is larger than on every machine."""
    starts: tuple[tuple[float, ...], ...] = ((),)
    """Values of `sizes` from which fits begin."""

    @property
    def unknown(self) -> bool:
        """Whether it is a shape that no effect of the vocabulary has."""
        return self.effect == "unknown"


def named(place: str, **more: Any) -> Regressor:
    """The regressor 'machine/column' of the effect on whose card that column is."""
    effect, log_odds = column_of(place)
    return Regressor(place.partition("/")[2], effect, log_odds, **more)


def instead(place: str, effect: str = "") -> tuple[Equivalent, ...]:
    """What a column 'machine/column' may be instead, by the cards; effect: what it goes by."""
    effect = effect or column_of(place)[0]
    others = stand_ins(place, effect)
    return tuple(Equivalent(name, one.log_odds, one.only_if_zero) for name, one in others)


@dataclass(frozen=True, slots=True, eq=False)
class Columns:
    """Shapes (n, k) of one regressor, prior spread (k,) of each, and the names of their sizes."""

    values: FloatArray
    spread: FloatArray
    names: tuple[str, ...] = ()
    lasts: bool = True
    """Whether the sizes hold in another recording; how a stretch began does not."""

    @property
    def sizes(self) -> Sequence[str]:
        """Names of the sizes, numbers where they have none."""
        return self.names or [str(number) for number in range(self.values.shape[1])]

    @classmethod
    def of(cls, shape: FloatArray, spread: float, *names: str) -> Columns:
        """One shape (n,)."""
        return cls(shape[:, None], np.array([spread]), names)

    @classmethod
    def none(cls, rows: int) -> Columns:
        """No shape."""
        return cls(np.zeros((rows, 0)), np.zeros(0))


Draws = Mapping[str, FloatArray]
"""Sizes of one regressor by their own names: one value, or many draws, of each."""


@dataclass(frozen=True, slots=True)
class Shown:
    """One parameter of the answer, from the sizes of a regressor."""

    name: str
    unit: str
    of: Callable[[Draws], FloatArray]
    nothing: float = 0.0
    """Value with which the effect vanishes."""
    as_without: float | None = None
    """Value that says the same as no such parameter, and is left out."""


DELAY = (
    Shown("time", "s", lambda v: v["time"]),
    Shown("dead_time", "s", lambda v: v["dead_time"]),
    Shown(IN_ALL, "s", lambda v: v["time"] + v["dead_time"]),
)
"""What the answer says of a delay of first order behind a dead time."""


class RegressionPlant:
    """A machine with its recording, for the evidence of sets of regressors.

    What a machine does not say for itself is that of one whose readings are all alike. Spline
    terms, kept in `_unknown`, give way to the shapes of a chosen set.
    """

    regressors: tuple[Regressor, ...]
    observed: FloatArray
    """(n,) what is to be explained, in `unit`."""
    unit: str
    channel: str
    """Name of what was observed, for drawings."""
    readings: Readings
    rows: IntArray
    """Rows that count: valid, and thinned to what can tell anything."""
    kinds: IntArray
    """(n,) small numbers: rows of one kind are like one another (at rest, in motion, a joint)."""
    rounding = 0.0
    """Standard deviation of the rounding of a reading, in `unit`."""
    messy = False
    """Whether effects may leave some of the shapes of others, see `charged`."""
    averages = False
    """Whether noise of neighbouring readings is alike: a sensor that averages over time."""
    nuisances = 0
    """How many of the first free columns are of the recording; the others are tolerances."""
    at_once = math.inf
    """Regressors that are added near one point: of more, some make up for what is not linear."""
    own_noise: Any = None
    """The noise under which a plant that is linear near a point only was made."""
    stale: Sequence[Stale] = ()
    """Stretches in which a sensor repeated an old value."""
    left_by_known: Sequence[tuple[float, FloatArray]] = ()
    """For each effect that the robot file has from an earlier diagnosis, the share of its power
    that it may leave, and what it does (n,)."""
    held: IntArray = np.zeros(0, dtype=np.intp)
    """Free columns of what the file has from an earlier diagnosis: at nothing it is as there."""
    done_by_known: FloatArray | None = None
    """What all of them do (n,); None where the file has none."""

    @cached_property
    def t_s(self) -> FloatArray:
        """(n,) [s] in which noise is remembered; recordings and columns are end to end."""
        return self.readings.t_s

    @cached_property
    def groups(self) -> IntArray:
        """(n,) number of the stretch, place or joint of a row: noise is of one kind within."""
        return np.cumsum(self.readings.fresh).astype(np.intp)

    @cached_property
    def beside(self) -> FloatArray:
        """Shapes (n, j) of a chosen set: none yet."""
        return np.zeros((len(self.t_s), 0))

    @cached_property
    def drawn_on(self) -> FloatArray:
        """(n,) what drawings add to `observed` and to every prediction of it."""
        return np.zeros(len(self.t_s))

    @property
    def noises(self) -> IntArray:
        """(n,) small numbers: rows of one number share one noise; as `kinds`, or coarser."""
        return self.kinds

    @cached_property
    def counts(self) -> FloatArray:
        """(n,) weight of a reading in figures of the model error: 0 where its unit is another."""
        return np.ones(len(self.t_s))

    @property
    def stays(self) -> IntArray:
        """Number (n,) of the stay at one place that a row belongs to; -1 in motion."""
        return np.full(len(self.groups), -1, dtype=np.intp)

    @property
    def usual(self) -> FloatArray | None:
        """(n,) how large readings like each are; None where all are of one size."""
        return None

    @property
    def unsampled(self) -> FloatArray | None:
        """(n,) standard deviation of a prediction by the course of a command between samples."""
        return None

    def base(self, keys: frozenset[str], sizes: Sizes) -> FloatArray:
        """Prediction (n,) with the nonlinear sizes of these regressors."""
        return np.zeros(len(self.groups))

    def begins(self, keys: frozenset[str]) -> list[str]:
        """Sizes of regressors, from -1 to 1, of how a recording begins, not of the machine."""
        return []

    def columns(self, key: str, base: FloatArray, sizes: Sizes) -> Columns:
        """Shapes that a regressor adds to the prediction, around `base`."""
        raise NotImplementedError

    def free(self) -> Columns:
        """Shapes that are always fitted and never a finding."""
        return Columns.none(len(self.t_s))

    @property
    def covariates(self) -> dict[str, FloatArray]:
        """What a model error may follow, name -> (n,)."""
        raise NotImplementedError

    def shown(self, key: str) -> Sequence[Shown]:
        """What the answer says of the sizes of a regressor, the main parameter first."""
        raise NotImplementedError

    def not_testable(self) -> list[NotTestable]:
        """Effects of which such a recording can tell nothing, and why."""
        return []

    def noise_bounds(self, left: FloatArray) -> NoiseBounds | None:
        """What bounds the noise in a residual (n,), where every row is read like its neighbours;
        None where too little was read in a row.
        """
        read = np.flatnonzero(self.readings.valid[:, 0])  # also rows that are thinned out
        seen = spectrum(left[read], self.groups[read], segment_for(len(read)))
        if seen is None:
            return None
        shapes = remembering(seen.angle)
        return NoiseBounds([Bound(seen, shapes)], np.ones(shapes.shape[1]))

    def keep_beside(self, shapes: FloatArray) -> None:
        """Spline terms must not take the place of these shapes (n, j) either."""
        self.beside = shapes
        self.__dict__.pop("_unknown", None)

    def map_finely(self, keys: frozenset[str], sizes: Sizes, left: FloatArray) -> bool:
        """Make the spline term over position as detailed as what a set leaves (n,) repeats there.

        Returns whether anything changed.
        """
        return False

    def followed(self, key: str) -> FloatArray:
        """Covariate (n,) that an unknown follows; NaN where it does not act."""
        raise NotImplementedError

    def detail(self, key: str) -> int:
        """Pieces of the spline term of an unknown; 0 of one that has no number of its own."""
        return 0

    @property
    def variant(self) -> RegressionPlant | None:
        """The same recording prepared another way that is as good; None where there is one way."""
        return None

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

    def built(self) -> Sequence[tuple[float, RegressionPlant]]:
        """The same as if it had been built with other care, each with its log prior odds."""
        return [(0.0, self)]

    @property
    def odds_of_care(self) -> float:
        """Log prior odds that a machine is built with as much care as this one is taken for."""
        return 0.0

    def carefully(self) -> RegressionPlant | None:
        """The same, built as its file says whatever is chosen; None where it is so already."""
        return None

    def is_far(self, before: float, after: float) -> bool:
        """Whether so much was explained near a point that what is left may be what is not linear.

        before, after: chi-square for each reading, above that of noise.
        """
        return False

    def holds_at(self, best: Any) -> bool:
        """Whether columns made here still hold at what an explanation adds without a name."""
        return True

    def moved_to(self, best: Any) -> RegressionPlant:
        """The same with columns made at the sizes of an explanation, fitted to their end."""
        return self

    def shown_on(self, change: FloatArray) -> list[str]:
        """Channels on which a change of the readings (n,) shows."""
        return [self.channel]

    def parameters(
        self, key: str, sizes: FloatArray, covariance: FloatArray
    ) -> dict[str, ParameterResult] | None:
        """Parameters of the answer by all sizes (k,); None where `shown` has them."""
        return None

    def spread(self, key: str, sizes: FloatArray, covariance: FloatArray) -> dict[str, list[float]]:
        """See `Finding.spread`, by all sizes of a regressor (k,)."""
        return {}

    def described(
        self, finding: Finding, keys: Sequence[str], best: Any, without: Any
    ) -> dict[str, Any]:
        """Fields of the finding of these regressors that their columns do not tell.

        without: the explanation less all of them.
        """
        return {}

    def drawn(self, picture: Picture) -> Picture:
        """A picture with a channel for each that was laid end to end."""
        return picture

    def rest(self, best: Any, charged: float) -> Rest | None:
        """What an explanation leaves, by shapes of no spline term; None where there are none.

        charged: chi-square that effects of the file may leave.
        """
        return None

    def remarks(self, best: Any, covariance: FloatArray) -> dict[str, Any]:
        """Further fields of the answer, by the best explanation and the covariance of its sizes."""
        return {}

    def adopt(self, trained: Any) -> None:
        """Take over what shapes were made with, so that sizes of another recording hold here."""

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

    def without_noise(self, keys: frozenset[str], sizes: Sizes) -> BoolArray | None:
        """Rows (n,) that the prediction leaves no noise of, as it takes them from what was read."""
        return None

    def starts(self, key: str, residual: FloatArray) -> Sequence[dict[str, float]]:
        """Where to start the nonlinear sizes of a regressor, given what is left without it (n,)."""
        own = next(one for one in self.regressors if one.key == key)
        names = [f"{key}.{size.name}" for size in own.sizes]
        return [dict(zip(names, start, strict=True)) for start in own.starts]
