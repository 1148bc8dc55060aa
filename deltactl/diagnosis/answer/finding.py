"""One finding: what it is, how large, where it shows, how sure, and what else it may be."""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import Annotated, Any

from pydantic import BaseModel, BeforeValidator, ConfigDict, Field

IN_ALL = "total"
"""Dead time and time constant together, beside them where their interval is known: no parameter of
a robot file."""
HUGE = 1e100
"""No machine has a size beyond this: it represents one that does not exist."""


def _existing(value: Any) -> Any:
    """None for what is infinite or represents it, which JSON has no number for."""
    if isinstance(value, int | float) and not abs(value) < HUGE and not math.isnan(value):
        return None
    return value


End = Annotated[float | None, BeforeValidator(_existing)]
"""A number; None where it does not exist (an interval without an end, an infinite stiffness)."""
Number = Annotated[float | list[float] | None, BeforeValidator(_existing)]


class Record(BaseModel):
    """A part of an answer: what it does not know is refused."""

    model_config = ConfigDict(extra="forbid", arbitrary_types_allowed=True)


class ParameterResult(Record):
    """A size with its 95 % interval; a vector has one interval a component.

    None: there is no such value. A stiffness of None is a part that does not yield, an end of None
    an interval without an end.
    """

    value: Number
    ci95: Sequence[End] | Sequence[Sequence[End]]
    unit: str

    @property
    def components(self) -> list[tuple[float, float, float]]:
        """Value, low and high end of each component; infinite where there is none, NaN where the
        answer gives no interval.
        """
        values = self.value if isinstance(self.value, list) else [self.value]
        ends: list[Any] = list(self.ci95)
        if not ends or not isinstance(ends[0], list | tuple):
            ends = [ends]
        found = []
        for number, value in enumerate(values):
            pair = ends[number] if number < len(ends) else []
            low, high = pair if len(pair) == 2 else (math.nan, math.nan)
            found.append(
                (
                    math.inf if value is None else value,
                    -math.inf if low is None else low,
                    math.inf if high is None else high,
                )
            )
        return found


class Where(Record):
    """Where a finding shows: observation columns, stretches of time, and in which regime.

    recordings: for each stretch the number of the recording it lies in (1 is the first given),
    whose own times `times_s` are.
    """

    axes: list[str]
    times_s: list[tuple[float, float]]
    regime: str = ""
    """In words; the report writes it."""
    recordings: list[int] = Field(default_factory=list)


class Evidence(Record):
    """What the data lose without the finding, all else refitted, and its calibrated p."""

    delta_chi2: float
    p: float


class Alternative(Record):
    """Something this recording cannot distinguish from the finding; delta_chi2: by how much it fits
    worse.

    together: one of several that are the alternative only all at once (equal homes of all motors),
    or an alternative to all findings of this effect at once.
    """

    effect: str
    component: str
    delta_chi2: float
    together: bool = False
    probability: float | None = None
    """Posterior that this acts instead; None where it was not computed."""


class Table(Record):
    """What was found of something without a name: a size over what it follows, in SI units.

    follows: the names in `depends_on` that the numbers were fitted over. lowest, highest: ends of
    evenly spaced places, as far as the recording went, in `follows_unit`. size: in `unit`, one
    number a place.
    """

    follows: str
    lowest: float
    highest: float
    follows_unit: str = ""
    size: list[float]
    unit: str = ""


class Finding(Record):
    """One effect. `unknown` is in no vocabulary: `depends_on` says what it follows."""

    effect: str
    component: str
    says: str = ""
    """One sentence with the size; the report writes it."""
    parameters: dict[str, ParameterResult]
    spread: dict[str, list[float]] = Field(default_factory=dict)
    """How far sizes may be off together, in their units: number k of each is the part of its
    standard deviation that moves along with number k of all sizes of the answer."""
    where: Where
    evidence: Evidence
    share_of_mismatch: float
    """How much of the model error's power that all findings take away comes back without it, with
    the others fitted again."""
    own_share: float | None = None
    """Power of what it does by itself, as a share of the model error's; the others may be able to
    take it over, or make up for it. None where it was not computed."""
    left_without_m: float | None = None
    """The model error (root mean square, in the unit of the fit) without it, with the others fitted
    again; None where it was not computed."""
    alone_m: float | None = None
    """The same with it corrected and nothing else; None where only a job shows that (`heal`)."""
    alone_ci95_m: tuple[float, float] | None = None
    """Between these, for sizes in the interval of the first parameter."""
    probability: float | None = None
    """Posterior that this effect acts at this component (unknown: that something outside the
    vocabulary does); None where it was not computed."""
    alternatives: list[Alternative] = Field(default_factory=list)
    depends_on: list[str] = Field(default_factory=list)
    """Covariates that it follows, including those that this recording cannot separate."""
    tied: list[str] = Field(default_factory=list)
    """Those of them that it may follow instead of the others."""
    has_memory: bool | None = None
    table: Table | None = None
    """For an unknown that follows one quantity."""
