"""The answer of the diagnosis: what `contracts/diagnosis.md` fixes as JSON, as typed records.

`Diagnosis.to_json()` is the contract's object. Other parts of the program (report, command
line) read these records; the `Picture` is for drawings only and not part of the JSON.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import Annotated, Any, Literal

import numpy as np
from pydantic import BaseModel, BeforeValidator, ConfigDict, Field

HUGE = 1e100
"""No machine has a size beyond this: it stands for one that does not exist."""


def _existing(value: Any) -> Any:
    """None for what is infinite or stands for it, which JSON has no number for."""
    if isinstance(value, int | float) and not abs(value) < HUGE and not math.isnan(value):
        return None
    return value


Verdict = Literal["nothing_missing", "explained", "partly_explained", "unexplained"]
End = Annotated[float | None, BeforeValidator(_existing)]
"""A number; None where it does not exist (an interval without an end, an infinite stiffness)."""
Number = Annotated[float | list[float] | None, BeforeValidator(_existing)]
FloatArray = np.ndarray[Any, np.dtype[np.float64]]
BoolArray = np.ndarray[Any, np.dtype[np.bool_]]


class _Record(BaseModel):
    model_config = ConfigDict(extra="forbid", arbitrary_types_allowed=True)


class ParameterResult(_Record):
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


class Where(_Record):
    """Where a finding shows: observation columns, stretches of time, and in which regime.

    recordings: for each stretch the number of the recording it lies in (1 is the first given),
    whose own times `times_s` are.
    """

    axes: list[str]
    times_s: list[tuple[float, float]]
    regime: str = ""
    """In words; the report writes it."""
    recordings: list[int] = Field(default_factory=list)


class Evidence(_Record):
    """What the data lose without the finding, all else refitted, and its calibrated p."""

    delta_chi2: float
    p: float


class Alternative(_Record):
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


class Table(_Record):
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


class Finding(_Record):
    """One effect. `unknown` is in no vocabulary: `depends_on` says what it follows."""

    effect: str
    component: str
    says: str = ""
    """One sentence with the size; the report writes it."""
    parameters: dict[str, ParameterResult]
    where: Where
    evidence: Evidence
    share_of_mismatch: float
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
    """Of an unknown that follows one quantity."""


class Fit(_Record):
    """Mismatch in the unit of the position (m for a delta, else `unit`)."""

    rms_before_m: float
    rms_after_m: float
    noise_floor_m: float
    holdout_rms_before_m: float
    holdout_rms_after_m: float
    unit: str = "m"
    left_by_known_m: float = 0.0
    """What effects that the robot file has from earlier diagnoses may leave, as no drive or bearing
    is as simple as they describe it. It is part of the noise floor where no test sees the rest."""
    scatter_within_m: float | None = None
    """Of a lone machine: what readings scatter around their mean while it stays at one place."""
    left_correlation: float | None = None
    """Of what is left, from one reading that was used to the next; None where these are few."""
    left_apart_s: float | None = None
    """How far apart such readings are."""
    left_lasts_s: float | None = None
    """Time after which that correlation is below 1/e."""
    holdout: str = "blocks"
    """'run': another recording, of which nothing was known before. 'blocks': blocks of time of the
    recording itself, left out of the last fit only: they took part in choosing what is fitted.
    Before and after are of the same fit, without and with the findings, nuisances fitted in both.
    """


class Unexplained(_Record):
    """What no finding explains: nothing where the residual is consistent with noise."""

    share_of_mismatch: float
    depends_on: list[str] = Field(default_factory=list)
    component: str = ""
    """Where what is left enters."""
    p: float | None = None
    """Calibrated p of its being noise."""
    says: str = ""


class NextExperiment(_Record):
    """The safe job that would best separate the explanations."""

    job: dict[str, Any]
    tells_apart: list[str]
    expected_delta_chi2: float
    minutes: float


class OpenTie(_Record):
    """Two explanations that no safe run separates, or only if the first of them is true.

    Each is a list of "effect component" names.
    """

    one: list[str]
    other: list[str]
    minutes: float | None = None
    """Length of the longest run that was considered, where none helps."""
    needs_drive: bool = False
    """No run could be made: the robot file does not say how the motors are driven."""


class NotTestable(_Record):
    """An effect that could not have been seen in this recording."""

    effect: str
    component: str
    why: str


class SmallestDetectable(_Record):
    """The size at which the alarm is raised in four of five recordings like this one.

    To name the effect may take more: `benchmarks/proofs/detection_limit.py` counts both.
    """

    effect: str
    component: str
    parameter: str
    value: float
    unit: str


class Agreement(_Record):
    """One size of a finding in each recording by itself, and whether they are the same."""

    effect: str
    component: str
    parameter: str
    sizes: list[ParameterResult]
    """In the order of the recordings."""
    chi2: float
    """Of the sizes about their weighted mean; one degree of freedom fewer than recordings."""
    p: float
    """Chance of a chi-square as large, were the machine the same in all recordings."""


class PriorSensitivity(_Record):
    """Probability of an effect under priors of size three times narrower and three times wider."""

    effect: str
    component: str
    probability: float
    narrower: float
    wider: float


class Channel(_Record):
    """One observation channel for drawings; arrays of shape (n,), NaN where nothing is valid."""

    name: str
    unit: str
    observed: FloatArray
    before: FloatArray
    """Prediction of the robot file as it stands."""
    after: FloatArray
    """Prediction with all findings."""
    noise: float
    """Standard deviation of the readings' noise."""
    counted: BoolArray | None = None
    """Which readings the figures of the fit are of; None: all that are valid."""


class Picture(_Record):
    """What a drawing needs; not in the JSON."""

    t_s: FloatArray
    channels: list[Channel]
    covariates: dict[str, FloatArray] = Field(default_factory=dict)
    """Interpretable quantities over time to draw the mismatch against, name (with unit) -> (n,)."""
    shift_s: tuple[float, ...] = (0.0,)
    """By how much the times of each recording were shifted to follow each other in `t_s`."""

    def shift_of(self, where: Where) -> float:
        """What to add to the times of a place that lies in one recording."""
        number = where.recordings[0] if where.recordings else 1
        return self.shift_s[number - 1] if number <= len(self.shift_s) else 0.0


class Thinned(_Record):
    """A recording too long to be used whole, and how much of it was used."""

    recording: int
    """Its number, from 1."""
    rows_used: int
    rows: int
    """Rows in it; approximate where it was not read whole."""
    stretches: int
    """Stretches that the rows lie in, spread over all of it."""
    span_s: float


class Diagnosis(_Record):
    """The whole answer."""

    verdict: Verdict
    false_alarm_p: float
    probability_nothing_missing: float | None = None
    """Posterior of the empty set of effects; None where it was not computed."""
    fit: Fit
    findings: list[Finding]
    unexplained: Unexplained
    loosely_built: bool = False
    """Build tolerances everywhere were fitted beside the findings."""
    ended_early: bool = False
    """The search reached its limit of work before everything was compared."""
    thinned: list[Thinned] = Field(default_factory=list)
    """Recordings of which only stretches were used."""
    not_read: list[str] = Field(default_factory=list)
    """Why parts of the recording (torques) were left aside."""
    doubts: list[str] = Field(default_factory=list)
    """What of the recording looks like another unit than the one it was read in."""
    next_experiment: NextExperiment | None = None
    open_ties: list[OpenTie] = Field(default_factory=list)
    not_testable: list[NotTestable] = Field(default_factory=list)
    smallest_detectable: list[SmallestDetectable] = Field(default_factory=list)
    agreement: list[Agreement] = Field(default_factory=list)
    """Of several recordings of a lone machine: every size in each of them."""
    prior_sensitivity: list[PriorSensitivity] = Field(default_factory=list)
    """Effects whose probability depends on how wide the priors of sizes are."""
    says: list[str] = Field(default_factory=list)
    """The summary in plain sentences; the report writes it."""
    robot: str = ""
    recordings: list[str] = Field(default_factory=list)
    picture: Picture | None = Field(default=None, exclude=True)

    def to_json(self) -> dict[str, Any]:
        """The contract's JSON object."""
        return self.model_dump(mode="json")
