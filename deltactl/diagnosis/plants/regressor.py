"""One way in which a machine may differ from its robot file: its sizes, its shapes, its words."""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from typing import Any, Literal

import numpy as np

from deltactl.diagnosis.answer.finding import IN_ALL
from deltactl.diagnosis.observations.readings import FloatArray
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
