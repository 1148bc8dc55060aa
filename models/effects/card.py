"""The card of an effect: all that is known about it beside its operator, in parts.

Each file of this folder has the cards of its effects, and whoever needs to know something about an
effect asks its card. `{part}` is the component in words everywhere.
"""

from __future__ import annotations

import math
import re
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field
from enum import Enum, auto
from typing import Literal

from deltactl.models.effects.kind import EffectKind

How = Literal["plain", "reciprocal", "log", "sine", "cosine", "frozen"]


@dataclass(frozen=True, slots=True)
class Coordinate:
    """One number the fit moves. frozen: set by a search, not by the fit."""

    parameter: str
    how: How = "plain"
    step: float = 1e-4
    low: float = -math.inf
    high: float = math.inf
    part: int = 0
    """Component of a vector parameter."""


@dataclass(frozen=True, slots=True)
class Shape:
    """A point to start from: coordinates at which nothing happens (`origin`), and unit columns.

    Columns of the score are regressors from origin along the linear coordinates, `reach` long.
    """

    origin: tuple[float, ...]
    linear: tuple[int, ...] = (0,)
    reach: float = 1e-4


class Search(Enum):
    """What finds an effect that no table of starting points does."""

    MOMENT = "a scan over the moments of the recording"
    REPEATS = "stretches of one repeated reading"
    HEIGHTS = "heights that the platform was sent to"
    CLOCK = "the clock of the sensors"


@dataclass(frozen=True, slots=True)
class Fit:
    """Coordinates, starting points and fixed parameters.

    searched: by what it is found instead of by a row of starting points for each component.
    """

    coordinates: tuple[Coordinate, ...] = ()
    shapes: tuple[Shape, ...] = ()
    fixed: Mapping[str, float] = field(default_factory=dict)
    searched: Search | None = None


LAYER = "/"


class Trait(Enum):
    """What several effects have in common, where others ask for it."""

    HYSTERESIS = auto()
    """Shows where the motion turns back, and holds its two directions apart."""
    DELAY = auto()
    """Makes readings come late, by its parameters in seconds."""
    DRIVE_DELAY = auto()
    """A delay that the drive makes."""
    BY_DISTANCE = auto()
    """An error of what a sensor reads, by the distance it reads."""
    READING = auto()
    """Only in what sensors read: expected there, and the motion needs nothing."""
    LENGTH = auto()
    """A length of the linkage, of which arm angles show nothing."""
    ENTERED = auto()
    """The person who remedies it may as well enter it in the robot file."""
    FORCE = auto()
    """A force that is one number, and need not be the same at every speed."""
    CONSTANT_FORCE = auto()
    """A force that is there whichever way the machine moves."""
    BEARING = auto()
    """Friction of bearings, said in one phrase where two parts of it are found."""
    UNDER_LOAD = auto()
    """Changes with the load: another load at the same place rules it out."""
    BEHIND_READING = auto()
    """Lies behind the place at which a drive reads its position."""
    ZERO = auto()
    """The zero of what is commanded."""
    RATIO = auto()
    """The ratio between what is commanded and what moves."""
    SIGNED = auto()
    """Corrects a figure of the robot file, up or down."""
    RINGING = auto()
    """A spring and a mass that swing after moves."""
    WHOLE_STEPS = auto()
    """Its size is a whole number of steps."""
    SCALES_FORCES = auto()
    """All forces that are found beside it are in proportion to it: it is corrected first."""
    IN_THE_WAY = auto()
    """Stops the platform at a height, its main parameter."""
    WARMS = auto()
    """Comes and goes with the temperature, too, or as the machine warms up."""


class Rule(Enum):
    """What the main parameter of two findings together is."""

    NEWEST = "newest"
    """They do not add up: what was found last is kept."""
    SUM = "sum"
    """Widths of play and of wound-up shafts in series add up exactly (Brokate and Sprekels 1996,
    stop and play operators), lags and small rotations to first order."""
    EACH = "each"
    """Each parameter adds up: small shifts and turns of one frame."""
    PRODUCT = "product"
    SERIES = "series"
    """1 / k = 1 / k1 + 1 / k2, as springs one behind the other."""
    PHASOR = "phasor"
    """Sine waves of one period; of two periods both stay."""
    RATE = "rate"
    """Size per stiffness adds up, at the accepted stiffness."""
    TABLE = "table"
    """Tables over one quantity add up; beyond its ends a table is constant."""


class Compensated(Enum):
    """How a job takes a known effect into account, in words for the user."""

    INVERSE = "in the inverse kinematics"
    """Every commanded angle has one true angle, and every pose one position."""
    AHEAD = "commanded ahead of time"
    """Drives that follow late."""
    AT_REVERSALS = "taken up where the arm turns round"
    """Play and wound-up shafts."""
    WARMING = "followed as the arms warm up"
    """Growth, with its time constant."""
    SHAPED = "moved so that it does not ring, where the drives can follow"
    IN_READINGS = "expected in the readings; the motion needs nothing"
    NOT = ""


@dataclass(frozen=True, slots=True)
class Words:
    """What it is called, as noun phrases with {part}; what is empty is called as the ones before.

    noun: of a delta, and wherever nothing else is said. axis: of a single axis, where nothing need
    turn and no gear be. effort: where an effort moves the axis, and no command. several: of several
    parts. further: beyond what the robot file has of it. regime, axis_regime: where it shows.
    axis_part: what the part is called on a single machine. gap: what holds two directions apart.
    sizes: what its parameters are called here, where they have no name that is right for all.
    """

    noun: str = ""
    axis: str = ""
    effort: str = ""
    several: str = ""
    further: str = ""
    regime: str = "everywhere"
    axis_regime: str = "everywhere"
    axis_part: str = ""
    gap: str = ""
    sizes: Mapping[str, str] = field(default_factory=dict)

    def of_one(self, name: str, alone: bool) -> str:
        """The phrase for one part; name: of the effect. alone: of a single axis."""
        return (alone and self.axis) or self.noun or f"{name.replace('_', ' ')} at {{part}}"

    def without_place(self, name: str, alone: bool, by_effort: bool) -> str:
        """The same for a table, which has the part in another column; no article either."""
        return _PLACE.sub("", (by_effort and self.effort) or self.of_one(name, alone))


_PLACE = re.compile(r"^an? | (?:(?:of|at|in|on|by) )?\{part\}")


@dataclass(frozen=True, slots=True)
class Drawing:
    """Which parts of a drawing it means.

    motor, rod: of a delta, the part that is marked where it acts at a motor or in an arm.
    everywhere: parts that are marked wherever it acts. axis: parts of a single axis or sensor.
    """

    motor: str = "motor"
    rod: str = "upper_arm"
    everywhere: tuple[str, ...] = ()
    axis: tuple[str, ...] = ("motor", "gear", "load")


Sizes = Mapping[str, float]
"""Parameter -> number in SI units."""


@dataclass(frozen=True, slots=True)
class Equal:
    """Another effect that does exactly the same to all that is observed, where it is as large.

    sizes: of the other, by those of this one and by what is fixed of the other; several sets where
    several do. common: it is so where all arms have the one alike and the other is everywhere;
    else at one component.
    """

    other: str
    sizes: Callable[[Sizes, Sizes], Sequence[Sizes]]
    common: bool = False


@dataclass(frozen=True, slots=True)
class StandIn:
    """Log odds of another name of one operator, against the name it goes by.

    only_if_zero: only while this size of the column is (nearly) zero.
    """

    log_odds: float
    only_if_zero: str = ""


@dataclass(frozen=True, slots=True)
class Confusion:
    """Another effect that may look the same, and what separates the two.

    axis: a motion or measurement of a single axis, with {or_effort} and {say_what_pulls}. delta: a
    sentence. by_hand: a measurement where no safe motion helps; those with the lowest `effort` are
    proposed first. called: this other one as an alternative, with {phrase} for its own. exactly: it
    can be the other on every motion, at the same component. exactly_together_at: at all components
    at once it can be the other at this one. stands_in: by column of single machines (`log_odds`),
    where one of both is that column and the other may be it as well.
    """

    other: str
    axis: str = ""
    delta: str = ""
    by_hand: str = ""
    effort: int = 0
    stands_in: Mapping[str, StandIn] = field(default_factory=dict)
    called: str = ""
    exactly: bool = False
    exactly_together_at: str = ""


@dataclass(frozen=True, slots=True)
class ByHand:
    """A measurement that settles whether it is this effect; the lowest `effort` comes first."""

    text: str
    effort: int


@dataclass(frozen=True, slots=True)
class Group:
    """An effect of one size at all arms: what they are called together, and the commonest first."""

    name: str
    order: int


@dataclass(frozen=True, slots=True)
class Defect:
    """What the page offers to hide in its simulated robot.

    Large enough to be named after one heart of the robot of Zhao 2023. parameters: of a `length`
    as shares of it. listed: where it comes among the defects.
    """

    text: str
    component: str
    parameters: Sizes
    listed: int


@dataclass(frozen=True, slots=True)
class EffectCard:
    """All that is known about an effect.

    on: its operators on single machines: of an axis that follows a `command` or is driven by
    `effort`, and of a `range` sensor. says: its sentence there with its parameters, {size} and
    {sign:above|below} in braces, and others beside an `effort` and of a `slide`; none where that of
    the operator is used.
    log_odds: natural logarithms of the prior odds that a single machine has it, by
    'machine/column' of the columns that show it there, and of a `joint` of a servo delta. Judged,
    not counted, so that only their order is sure: -1 is one machine in four, -2 one in eight, -3
    one in twenty, -4 one in 55, -6 one in 400.
    kind: its operator on a delta; None where it acts on other machines only. listed: where it comes
    among the effects of one port. remedies: what to do, by layer and row, 'layer/row' or 'row':
    layers are `servo_drive`, `axis`, `servo_axis`, `slide` and `sensor`, the nearest wins; rows are
    empty, the main parameter's name, `small` (below `small`), `beside` or what an unknown follows.
    left: what a person does where no command makes it better. also_added: a second parameter that
    adds up as well. group: of what all arms may have alike.
    build_spread: standard deviation of its size on a machine that was built with care, in SI units.
    length: the field of the robot file's geometry that it changes.
    runout_rad: the same of a periodic error once a turn of the motor.
    """

    name: str
    kind: EffectKind | None = None
    listed: int = 9
    on: Mapping[str, EffectKind] = field(default_factory=dict)
    says: Mapping[str, str] = field(default_factory=dict)
    words: Words = Words()
    log_odds: Mapping[str, float] = field(default_factory=dict)
    remedies: Mapping[str, str] = field(default_factory=dict)
    small: float = 0.0
    drawing: Drawing = Drawing()
    traits: frozenset[Trait] = frozenset()
    rule: Rule = Rule.NEWEST
    also_added: str = ""
    compensated: Compensated = Compensated.NOT
    left: str = "no command makes it better"
    confusions: tuple[Confusion, ...] = ()
    equals: tuple[Equal, ...] = ()
    by_hand: ByHand | None = None
    fit: Fit | None = None
    """How a fit moves in it and where it starts; None: in its main parameter, from nothing."""
    group: Group | None = None
    build_spread: float | None = None
    length: str = ""
    runout_rad: float | None = None
    slide_names: Mapping[str, str] = field(default_factory=dict)
    """Parameter -> its name in the file of an axis that slides: a shift is no angle there."""
    defect: Defect | None = None
    table: bool = False
    """An error without a name, which robot files hold and no diagnosis looks for."""

    def remedy(self, layers: tuple[str, ...], rows: tuple[str, ...]) -> str | None:
        """The text of the first row that there is, from the nearest layer that has it."""
        keys = (f"{layer}{LAYER}{row}" if layer else row for row in rows for layer in (*layers, ""))
        return next((self.remedies[key] for key in keys if key in self.remedies), None)

    def confusion(self, other: str) -> Confusion | None:
        """What this card knows of another effect beside it; None where it knows nothing."""
        return next((confusion for confusion in self.confusions if confusion.other == other), None)
