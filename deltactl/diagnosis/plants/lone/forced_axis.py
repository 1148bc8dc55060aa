"""An axis driven by effort, by its inverse dynamic model: effort less what the motion needs.

gain * effort + load - inertia * acceleration - gravity = friction + offset + what is missing,
linear in the sizes; both sides pass the same low-pass, whose edge is where the position's spectrum
meets its noise (IDIM: Gautier 1997; Janot, Gautier and Vandanjon 2013, IEEE Trans. Control Syst.
Technol. 21, 428-444).
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import replace
from functools import cached_property, lru_cache

import numpy as np

from deltactl.diagnosis.answer.records import NotTestable
from deltactl.diagnosis.evidence.options import EVIDENCE
from deltactl.diagnosis.observations.ahead_in_time import AheadInTime
from deltactl.diagnosis.observations.inverse_dynamics import Motion, motion_of
from deltactl.diagnosis.observations.largest_noise import NoiseBounds
from deltactl.diagnosis.observations.log_errors import sampling_times
from deltactl.diagnosis.observations.outliers import without_gross
from deltactl.diagnosis.observations.readings import (
    BoolArray,
    FloatArray,
    IntArray,
    Readings,
    gather,
    known_loads,
    smoothly_bridged,
)
from deltactl.diagnosis.plants.left_over import UNKNOWN, LeftOver, Way
from deltactl.diagnosis.plants.lone.clear_motion import (
    alike,
    clocks_apart_s,
    direction_of,
    in_clear_motion,
    rests_of,
    rows_apart,
)
from deltactl.diagnosis.plants.lone.drive_by_effort import EffortLimit, late_sizes
from deltactl.diagnosis.plants.lone.effort_noise import EffortNoise, between_samples
from deltactl.diagnosis.plants.lone.force_shapes import ForceShapes
from deltactl.diagnosis.plants.lone.options import FORCED_AXIS, LONE
from deltactl.diagnosis.plants.regressor import (
    DELAY,
    Columns,
    Draws,
    Regressor,
    Shown,
    Sizes,
    instead,
    named,
)
from deltactl.models.chain.axis import Driven, EffortChain, gravity_pull
from deltactl.models.effects import Trait, column_of, with_trait
from deltactl.models.effects.following_lag import STARTS_S
from deltactl.models.robot import ServoAxis
from deltactl.recording.column_measures import first_of
from deltactl.recording.tables.flat import FlatRecording

MEASURED = ("position", "theta_1", "velocity", "effort")
GAIN = "gain.scale"
FEWEST_IN_MOTION = FORCED_AXIS.fewest_forced_rows // 2
"""Samples in clear motion, below which `admission` refuses a recording."""


def prepared(recordings: Sequence[FlatRecording]) -> list[FlatRecording]:
    """Without single readings that are none."""
    return [without_gross(one, MEASURED) for one in recordings]


class ForcedAxis(LeftOver):
    """A single axis by its effort; `observed` is effort that the robot file does not explain."""

    channel = "effort"
    maps_places = True

    def __init__(
        self, robot: ServoAxis, recordings: Sequence[FlatRecording], narrower: float = 1.0
    ):
        """narrower: the low-pass ends at this share of where the position meets its noise."""
        self.robot, self.source = robot, recordings[0].source
        assert robot.inertia is not None
        recordings = prepared(recordings)
        self._recordings = tuple(recordings)
        self.inertia = robot.inertia
        self.unit = "N" if robot.motion == "linear" else "N m"
        name = first_of(recordings[0], ("position", "theta_1")) or "position"
        unit = {name: "m" if robot.motion == "linear" else "rad"}
        self.readings: Readings = gather(recordings, [name], unit)
        self.position = np.concatenate([smoothly_bridged(r, name) for r in recordings])
        self.t_s = sampling_times(self.readings.t_s, self.readings.fresh, self.position)
        self.force = robot.force_per_effort * np.concatenate(
            [smoothly_bridged(r, "effort") for r in recordings]
        )
        self._in_time = AheadInTime(self.t_s, self.readings.fresh)
        # As many as there are regressors: those of one delay.
        self._curves = lru_cache(maxsize=12)(lambda one: self._in_time.curves(one.values))
        self._ahead = lru_cache(maxsize=12)(self._led)
        self.let_go = not float(np.ptp(self.force)) > 0.0
        for wider in FORCED_AXIS.wider:  # a steady motion alone has a spectrum that ends early
            self._low_passed(recordings, narrower * wider)
            if len(self.rows) >= FEWEST_IN_MOTION:
                break
        self.kinds = alike(self.motion.velocity, self._changing, self.rows, self._period)
        enough = len(self.rows) >= FEWEST_IN_MOTION
        self.regressors = tuple(self._regressors()) if enough else ()

    def _low_passed(self, recordings: Sequence[FlatRecording], narrower: float) -> None:
        """Motion and forces behind a low-pass, and the samples that count of them."""
        for name in ("_rests", "unsampled"):
            self.__dict__.pop(name, None)
        self.motion = self._motion(recordings, narrower)
        self.filtered_force = self.motion.low_passed(self.force)
        self._direction = direction_of(self.motion)
        self.observed = self._not_explained(recordings)
        self.drawn_on = self.filtered_force - self.observed
        self.rows = self._rows()

    @cached_property
    def unsampled(self) -> FloatArray:
        """An effort that changes within a sample, as far as the low-pass keeps it, (n,)."""
        return between_samples(self.motion, self.force)

    def _motion(self, recordings: Sequence[FlatRecording], narrower: float) -> Motion:
        velocity = None
        if all(first_of(r, ["velocity"]) for r in recordings):
            velocity = np.concatenate([smoothly_bridged(r, "velocity") for r in recordings])
        return motion_of(self.t_s, self.readings.fresh, self.position, velocity, narrower)

    def _not_explained(self, recordings: Sequence[FlatRecording]) -> FloatArray:
        """Effort less what inertia, gravity, load and accepted effects need, low-passed, (n,)."""
        motion, robot = self.motion, self.robot
        load = known_loads(recordings)
        effort = self.force / robot.force_per_effort
        driven = Driven(
            t_s=self.t_s,
            fresh=self.readings.fresh,
            effort=effort,
            position=self.position,
            velocity=motion.velocity,
            direction=self._direction,
            at_rest=self._rests,
            load=load,
        )
        self.pulled = motion.low_passed(load + gravity_pull(robot.gravity, self.position))
        left = self._left(robot, driven)
        stated = tuple(one for one in robot.effects if one.found is None)
        if len(stated) < len(robot.effects):
            bare = robot.model_copy(update={"effects": stated})
            self.done_by_known = self._left(bare, driven) - left
        return left

    def _left(self, robot: ServoAxis, driven: Driven) -> FloatArray:
        """Effort that the motion does not need, low-passed, (n,)."""
        left, motion = EffortChain(robot).force(driven), self.motion
        return motion.low_passed(left.force) - left.inertia * motion.acceleration

    @cached_property
    def _rests(self) -> BoolArray:
        """Samples (n,) at which the axis rests."""
        return rests_of(self.motion, self._period)

    @property
    def _period(self) -> float:
        """Time between samples, in periods of the low-pass."""
        return self.motion.cut_off_hz * self.readings.period_s

    def _rows(self) -> IntArray:
        """Samples in clear motion away from the ends of a stretch, one a filter's memory apart."""
        self._counts = in_clear_motion(self.motion, self._period) & self.readings.valid[:, 0]
        return np.flatnonzero(self._counts)[:: rows_apart(self._period)]

    # ---- what may be missing -------------------------------------------------------------------

    @cached_property
    def _forces(self) -> ForceShapes:
        return ForceShapes(
            motion=self.motion,
            direction=self._direction,
            force=self.filtered_force,
            pulled=self.pulled,
            rows=self.rows,
            inertia=self.inertia,
            turns=self.robot.motion == "rotary",
        )

    def _regressors(self) -> list[Regressor]:
        found = [
            named("effort/friction", positive=("torque",), above=0.0, measured_by=GAIN),
            named("effort/viscous", positive=("coefficient",), above=0.0, measured_by=GAIN),
            named(
                "effort/inertia", as_built=FORCED_AXIS.as_stated * self.inertia,
                above=-self.inertia, measured_by=GAIN,
            ),
        ]  # fmt: skip
        if not self.let_go:
            late = late_sizes(LONE.lag_spread_s, self.readings.period_s)
            found += [
                named("effort/offset", equivalents=instead("effort/offset"), measured_by=GAIN),
                named("effort/gain", as_built=FORCED_AXIS.as_stated, above=-1.0),
                named("effort/spring", follows=("position",)),
                named(
                    "effort/lag", sizes=late, alone=False, takes_over="late",
                    as_built=EVIDENCE.tolerated * clocks_apart_s(self.readings.period_s),
                    equivalents=instead("effort/lag"), starts=STARTS_S,
                ),
                named("effort/stribeck", alone=False, **self._forces.slow.differs(GAIN)),
                named("effort/limit", alone=False, **self._limit.differs),
            ]  # fmt: skip
        return [*found, *self.unknowns()]

    def base(self, keys: frozenset[str], sizes: Sizes) -> FloatArray:
        """What a lag changes of the effort that the file explains, and a limit keeps back, (n,)."""
        found = np.zeros(len(self.t_s))
        if "lag" in keys:
            led = self._ahead(self._needed, sizes["lag.dead_time"], sizes["lag.time"])
            found += led.values[:, 0] - self.drawn_on
        return found + self._limit.kept_back(sizes["limit.limit"]) if "limit" in keys else found

    @cached_property
    def _limit(self) -> EffortLimit:
        shapes = np.stack([one.values[:, 0] for one in self._forces.linear.values()], axis=1)
        return EffortLimit(self.filtered_force, self.drawn_on, self.rows, self.observed, shapes)

    def without_noise(self, keys: frozenset[str], sizes: Sizes) -> BoolArray | None:
        """Samples (n,) whose effort is cut at a limit, and its noise with it."""
        if "limit" not in keys:
            return None
        return np.asarray(self._limit.kept_back(sizes["limit.limit"]) != 0.0)

    def _led(self, columns: Columns, dead_s: float, time_s: float) -> Columns:
        """Forces as an effort shows them whose motion comes late: ahead of the motion.

        The effort as read is left as it is. A lag that smoothed it would explain its noise.
        """
        values = self._in_time.later(self._curves(columns), dead_s, time_s)
        return replace(columns, values=values)

    @cached_property
    def _needed(self) -> Columns:
        return Columns.of(self.drawn_on, 1.0)

    def free(self) -> Columns:
        """Effort is held between samples and filtered before it is recorded: no finding."""
        if self.let_go:
            return super().free()
        return Columns.of(self._changing, clocks_apart_s(self.readings.period_s), "late")

    @cached_property
    def _changing(self) -> FloatArray:
        return self._in_time.curves(self.filtered_force).slopes

    def columns(self, key: str, base: FloatArray, sizes: Sizes) -> Columns:
        """Forces (n, k) of one regressor, low-passed like the effort."""
        if key in ("lag", "limit"):
            return Columns.none(len(self.t_s))
        columns = self.unknown(key) if key.startswith(UNKNOWN) else self._forces.of(key, sizes)
        if "lag.time" not in sizes:
            return columns
        return self._ahead(columns, sizes["lag.dead_time"], sizes["lag.time"])

    @cached_property
    def covariates(self) -> dict[str, FloatArray]:
        """What a force may follow, name -> (n,)."""
        found = {"position": self.motion.position, "velocity": self.motion.velocity}
        return found if self.let_go else {**found, "time": self.t_s}

    def spanned(self, name: str) -> FloatArray:
        """Named shapes (n, j) that no spline term may take the place of."""
        left_out = {"offset"} if self.let_go else set()
        named = [c.values[:, 0] for key, c in self._forces.linear.items() if key not in left_out]
        return np.stack(named, axis=1)

    def pieces(self, name: str) -> int:
        """The same over every covariate; fewer of a short motion."""
        stood_on = len(self.rows) // LONE.rows_a_piece
        return int(np.clip(stood_on, LONE.fewest_pieces, FORCED_AXIS.force_pieces))

    def noise_bounds(self, left: FloatArray) -> NoiseBounds | None:
        """Bounds of the noise: what passed the low-pass, and effort and position beyond it."""
        noise = EffortNoise(self.motion, self.inertia, self.readings.period_s, self.groups)
        return noise.bounds(left, self.force, self.position, self._counts)

    def ways(self) -> dict[str, Way]:
        """What happens between two samples may follow each: any axis has as much of it."""
        return {name: replace(way, as_built=self.between) for name, way in super().ways().items()}

    def spread_of(self, name: str, shapes: int) -> float:
        """A third of all forces."""
        return FORCED_AXIS.unknown_of_size * self._forces.size

    @cached_property
    def variant(self) -> ForcedAxis:
        """The same under a narrower low-pass: what differs between the two is no knowledge."""
        return ForcedAxis(self.robot, self._recordings, FORCED_AXIS.narrower)

    def not_testable(self) -> list[NotTestable]:
        """What lies behind the place at which the position is read, and the drive of free motion.

        A joint that yields or has play behind its encoder is a second mass; at the speeds that the
        low-pass leaves it moves with the first.
        """
        behind = "the position is read at one place: what yields behind it shows in neither column"
        gone = "the effort is zero throughout"
        reasons = dict.fromkeys(with_trait(Trait.BEHIND_READING), behind)
        if self.let_go:
            of_effort = ("effort/offset", "effort/gain", "effort/lag")
            reasons |= {column_of(place)[0]: gone for place in of_effort}
        return [NotTestable.of(name, "axis", why) for name, why in reasons.items()]

    def adopt(self, trained: ForcedAxis) -> None:
        """Spreads, speeds and map in detail of the recording that sizes were found on."""
        super().adopt(trained)
        own, other = self._forces, trained._forces
        own.size, own.slow.speeds, own.middle = other.size, other.slow.speeds, other.middle

    def shown(self, key: str) -> Sequence[Shown]:
        """Parameters of the contract's effects, in N or N m."""
        linear = self.unit == "N"
        viscous = "N s/m" if linear else "N m s/rad"
        kept = self.inertia

        def of(name: str) -> Callable[[Draws], FloatArray]:
            """A size that the effort shows times what the drive needs for its force."""
            return lambda v: np.asarray(v[name] / (1.0 + v.get(GAIN, 0.0)))

        moved = of("inertia")
        table = {
            "friction": [Shown("torque", self.unit, of("torque"))],
            "viscous": [Shown("coefficient", viscous, of("coefficient"))],
            "inertia": [
                Shown("inertia", "kg" if linear else "kg m2", lambda v: kept + moved(v), kept)
            ],
            "offset": [Shown("offset", self.unit, of("offset"))],
            "gain": [Shown("scale", "1", lambda v: 1.0 / (1.0 + v["scale"]), 1.0)],
            "lag": DELAY,
            "limit": [Shown("limit", self.unit, lambda v: v["limit"], nothing=np.inf)],
            "stribeck": [
                Shown("torque", self.unit, of("torque")),
                Shown("speed", "m/s" if linear else "rad/s", lambda v: v["speed"]),
            ],
        }
        return table.get(key, [])
