"""The answer of the diagnosis: what `contracts/diagnosis.md` fixes as JSON, as typed records.

`Diagnosis.to_json()` is the contract's object. Other parts of the program (report, command
line) read these records; the `Picture` is for drawings only and not part of the JSON.
"""

from __future__ import annotations

from typing import Any, Literal

from pydantic import Field

from deltactl.diagnosis.answer.finding import Alternative as Alternative
from deltactl.diagnosis.answer.finding import Evidence as Evidence
from deltactl.diagnosis.answer.finding import Finding as Finding
from deltactl.diagnosis.answer.finding import ParameterResult as ParameterResult
from deltactl.diagnosis.answer.finding import Record
from deltactl.diagnosis.answer.finding import Table as Table
from deltactl.diagnosis.answer.finding import Where as Where
from deltactl.diagnosis.answer.picture import Channel as Channel
from deltactl.diagnosis.answer.picture import Picture as Picture

Verdict = Literal["nothing_missing", "explained", "partly_explained", "unexplained"]


class AtRest(Record):
    """What remains of an axis, in the unit of the fit, while its command is constant and in motion.

    Both root mean square, over the rows that count.
    """

    left_m: float
    left_in_motion_m: float
    rests: int
    """Rests that last long enough to tell whether the axis moved in them."""
    moved: int
    """Those in which it moved by more than its readings scatter."""
    moved_by_m: float
    """By how much at most."""
    load_known: bool = False
    """Whether the recording or the robot file says what pulls at it."""


class Fit(Record):
    """Model error in the unit of the position (m for a delta, else `unit`)."""

    rms_before_m: float
    rms_after_m: float
    noise_floor_m: float
    holdout_rms_before_m: float
    holdout_rms_after_m: float
    unit: str = "m"
    left_by_known_m: float = 0.0
    """What effects that the robot file has from earlier diagnoses may leave, as no drive or bearing
    is as simple as they describe it. It is part of the noise floor where no test sees the rest."""
    done_by_known_m: float = 0.0
    """For a single axis or sensor: size of what those effects do, root mean square."""
    scatter_within_m: float | None = None
    """For a single axis or sensor: scatter of readings around their mean while it stays at one
    place."""
    sensor_noise: bool = True
    """Whether the noise floor is known to be that of the sensors: of a single axis or sensor only
    where its readings at one place scatter by as much."""
    at_rest: AtRest | None = None
    """For an axis that follows commands, and both rests and moves."""
    left_correlation: float | None = None
    """Correlation of the residual from one used reading to the next; None where these are few."""
    left_apart_s: float | None = None
    """How far apart such readings are."""
    left_lasts_s: float | None = None
    """Time after which that correlation is below 1/e."""
    holdout: str = "blocks"
    """'run': another recording, of which nothing was known before. 'blocks': blocks of time of the
    recording itself, left out of the last fit only: they took part in choosing what is fitted.
    Before and after are of the same fit, without and with the findings, nuisances fitted in both.
    """


class Unexplained(Record):
    """What no finding explains: nothing where the residual is consistent with noise."""

    share_of_mismatch: float
    depends_on: list[str] = Field(default_factory=list)
    component: str = ""
    """Where what is left enters."""
    p: float | None = None
    """Calibrated p of its being noise."""
    says: str = ""


class AllowedFor(Record):
    """A small error that was fitted beside the findings and clearly shows, yet is no finding."""

    effect: str
    component: str
    parameters: dict[str, ParameterResult]
    usual: float
    """How far off a machine built with care may be, in the unit of the first parameter."""
    times_usual: float
    """How many times as far off it is."""


class NextExperiment(Record):
    """The safe job that would best separate the explanations."""

    job: dict[str, Any]
    tells_apart: list[str]
    expected_delta_chi2: float
    minutes: float


class OpenTie(Record):
    """Two explanations that no safe run separates, or only if the first of them is true.

    Each is a list of "effect component" names.
    """

    one: list[str]
    other: list[str]
    minutes: float | None = None
    """Length of the longest run that was considered, where none helps."""
    needs_drive: bool = False
    """No run could be made: the robot file does not say how the motors are driven."""


class NotTestable(Record):
    """An effect that could not have been seen in this recording."""

    effect: str
    component: str
    why: str

    @classmethod
    def of(cls, effect: str, component: str, why: str) -> NotTestable:
        """One that a recording tells nothing of."""
        return cls(effect=effect, component=component, why=why)


class SmallestDetectable(Record):
    """The size at which the alarm is raised in four of five recordings like this one.

    To name the effect may take more: `benchmarks/proofs/detection_limit.py` counts both.
    """

    effect: str
    component: str
    parameter: str
    value: float
    unit: str


class Agreement(Record):
    """One size of a finding in each recording by itself, and whether they are the same."""

    effect: str
    component: str
    parameter: str
    sizes: list[ParameterResult]
    """In the order of the recordings."""
    chi2: float
    """Chi-square of the sizes about their weighted mean; one degree of freedom fewer than
    recordings."""
    p: float
    """Chance of a chi-square as large, were the machine the same in all recordings."""


class PriorSensitivity(Record):
    """Probability of an effect under priors of size three times narrower and three times wider."""

    effect: str
    component: str
    probability: float
    narrower: float
    wider: float


class Thinned(Record):
    """A recording too long to be used whole, and how much of it was used."""

    recording: int
    """Its number, from 1."""
    rows_used: int
    rows: int
    """Rows in it; approximate where it was not read whole."""
    stretches: int
    """Stretches that the rows lie in, spread over all of it."""
    span_s: float


class Known(Record):
    """An effect that the robot file has from an earlier diagnosis."""

    effect: str
    component: str
    probability: float | None
    """That it acts, as that diagnosis had it; None where it was not worked out."""
    from_these_recordings: bool
    """Whether it was found in a recording of the same name as one of these."""


class Diagnosis(Record):
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
    allowed_for: list[AllowedFor] = Field(default_factory=list)
    """Those of them that the recording clearly shows, the one farthest off first."""
    thinned: list[Thinned] = Field(default_factory=list)
    """Recordings of which only stretches were used."""
    not_read: list[str] = Field(default_factory=list)
    """Why parts of the recording (torques) were left aside."""
    left_out: list[str] = Field(default_factory=list)
    """Why recordings of several were left aside: damaged, each with its name."""
    not_held_out: list[str] = Field(default_factory=list)
    """Why held-out recordings say nothing of the answer: too short, or still."""
    doubts: list[str] = Field(default_factory=list)
    """What of the recording looks like another unit than the one it was read in."""
    known: list[Known] = Field(default_factory=list)
    """What the robot file has from earlier diagnoses."""
    pull_said: bool = False
    """Whether the robot file says what pulls at a single axis, or has no entry for it."""
    next_experiment: NextExperiment | None = None
    open_ties: list[OpenTie] = Field(default_factory=list)
    not_testable: list[NotTestable] = Field(default_factory=list)
    smallest_detectable: list[SmallestDetectable] = Field(default_factory=list)
    agreement: list[Agreement] = Field(default_factory=list)
    """For several recordings of a single axis or sensor: every size in each of them."""
    prior_sensitivity: list[PriorSensitivity] = Field(default_factory=list)
    """Effects whose probability depends on how wide the priors of sizes are."""
    says: list[str] = Field(default_factory=list)
    """The summary in plain sentences; the report writes it."""
    version: str = ""
    """That of deltactl, which made the answer."""
    robot: str = ""
    recordings: list[str] = Field(default_factory=list)
    units: dict[str, str] = Field(default_factory=dict)
    """Those of their columns where a table says them; texts say sizes in the fine ones."""
    picture: Picture | None = Field(default=None, exclude=True)

    def to_json(self) -> dict[str, Any]:
        """The contract's JSON object."""
        return self.model_dump(mode="json")
