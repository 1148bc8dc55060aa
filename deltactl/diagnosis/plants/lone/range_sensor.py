"""A range sensor by itself: what it read less the true distance, and what may be wrong with it."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import replace
from functools import cached_property, lru_cache
from operator import itemgetter

import numpy as np

from deltactl.diagnosis.observations.readings import (
    BoolArray,
    FloatArray,
    IntArray,
    Readings,
    bridged,
    gather,
)
from deltactl.diagnosis.plants.left_over import UNKNOWN, LeftOver
from deltactl.diagnosis.plants.lone.options import FILE_SPREADS, LONE, RANGE_SENSOR
from deltactl.diagnosis.plants.regressor import Columns, Regressor, Shown, Size, Sizes, named
from deltactl.foundation.scatter import MAD_TO_SIGMA
from deltactl.models.chain.axis import SensorChain
from deltactl.models.effects import sensor_drift
from deltactl.models.robot import RangeSensor
from deltactl.models.signals import late, slopes_of
from deltactl.recording.column_measures import step_of
from deltactl.recording.tables.flat import FlatRecording


class RangeSensorPlant(LeftOver):
    """A sensor and the distances it should have read."""

    unit = "m"
    averages = True

    def __init__(self, robot: RangeSensor, recordings: Sequence[FlatRecording]):
        self.robot = robot
        recordings = averaged(recordings)
        self._timed = all(recording.timed for recording in recordings)
        self.channel = "range"
        self.readings: Readings = gather(recordings, [self.channel], {self.channel: "m"})
        self.distance = np.concatenate([bridged(r, "distance") for r in recordings])
        self.observed = np.nan_to_num(self.readings.values[:, 0])
        self.nominal = self._nominal(recordings)
        self.rounding = step_of(self.readings.values[:, 0]) / float(np.sqrt(12.0))
        self.valid = self.readings.valid[:, 0] & ~_gross(
            self.observed - self.nominal, self.readings.valid[:, 0]
        )
        self.rows: IntArray = np.flatnonzero(self.valid)
        self.groups = self._places()
        self.kinds = np.zeros(len(self.t_s), dtype=np.intp)
        self.regressors = tuple(self._regressors()) if len(self.rows) else ()

    @property
    def stays(self) -> IntArray:
        """Its places."""
        return self.groups

    def _nominal(self, recordings: Sequence[FlatRecording]) -> FloatArray:
        chain, readings = SensorChain(self.robot.effects), self.readings
        parts = [readings.part == n for n in range(len(recordings))]
        return np.concatenate(
            [chain.simulate(readings.t_s[p], self.distance[p], readings.fresh[p]) for p in parts]
        )

    def _places(self) -> IntArray:
        """Number of the place each row was read at; readings at one place share their error."""
        if self.moves_all_the_time and self.in_time:
            return np.cumsum(self.readings.fresh).astype(np.intp)
        return np.cumsum(self.readings.fresh | self._new_distance).astype(np.intp)

    @cached_property
    def _new_distance(self) -> BoolArray:
        changed: BoolArray = np.diff(self.distance, prepend=self.distance[0]) != 0.0
        return changed

    @cached_property
    def moves_all_the_time(self) -> bool:
        """Whether the target moves rather than rests at places."""
        return float(self._new_distance[self.rows].mean()) > RANGE_SENSOR.moving_target

    @cached_property
    def passes_places(self) -> bool:
        """Whether enough rows are read on the way of the target to say how late a reading is."""
        new = self._new_distance
        passed = np.count_nonzero((new[1:] & new[:-1])[self.rows[self.rows > 0] - 1])
        return self.moves_all_the_time or passed >= RANGE_SENSOR.fewest_ranged_rows

    @cached_property
    def moves(self) -> bool:
        """Whether there is more than one distance."""
        return float(np.ptp(self.distance[self.rows])) > RANGE_SENSOR.least_travel_m

    @cached_property
    def in_time(self) -> bool:
        """Whether rows are in order of time: a table without times may be sorted by distance."""
        steps = np.diff(self.distance[self.rows])
        return self._timed or not self.moves or not ((steps >= 0.0).all() or (steps <= 0.0).all())

    @cached_property
    def mismatch(self) -> float:
        """How far readings and distances are apart."""
        left = (self.observed - self.nominal)[self.rows]
        return max(float(np.sqrt(np.mean(left**2))), 1e-9)

    def _regressors(self) -> list[Regressor]:
        found = [named("range/offset")]
        if self.moves:
            found += [named("range/scale"), named("range/crosstalk")]
        if self.passes_places and self.in_time:
            spread_s, step_s = RANGE_SENSOR.late_range_spread_s, 1e-3
            delay = Size("time", "half", spread_s, 0.0, LONE.longest_lag_s, step_s)
            found.append(named("range/late", sizes=(delay,), starts=((0.0,), (spread_s,))))
        if self.in_time:
            found.append(self._warming())
        return [*found, *self.unknowns()]

    def _warming(self) -> Regressor:
        span_s, near = self.readings.span_s, LONE.near_bound
        low = RANGE_SENSOR.warm_up_periods * self.readings.period_s
        high = RANGE_SENSOR.warm_up_spans * span_s
        within = ((1.0 + near) * low, (1.0 - near) * high)
        size = Size("time_constant", "flat", span_s, low, high, 1e-3 * span_s, within=within)
        slowest = sensor_drift.OF_SPAN * span_s
        likely = [s for s in sensor_drift.STARTS_S if s < slowest]
        likely = likely or [sensor_drift.ELSE * span_s]
        starts = tuple((s,) for s in (*likely, sensor_drift.ALSO * span_s))
        return named("range/drift", sizes=(size,), alone=False, starts=starts)

    def base(self, keys: frozenset[str], sizes: Sizes) -> FloatArray:
        """What the robot file says the sensor reads, as late as it is said, (n,)."""
        return self._late(sizes["late.time"])[0] if "late" in keys else self.nominal

    def columns(self, key: str, base: FloatArray, sizes: Sizes) -> Columns:
        """Errors (n, k) of one regressor."""
        if key.startswith(UNKNOWN):
            return self.unknown(key)
        if key == "drift":
            return self._drift(sizes["drift.time_constant"])
        return self._late(sizes.get("late.time", 0.0))[1].get(key, Columns.none(len(base)))

    @cached_property
    def _late(self) -> Callable[[float], tuple[FloatArray, dict[str, Columns]]]:
        """Nominal reading (n,) and errors of a distance so long before; the last are kept."""
        t_s, start_s, step_s = self.t_s, self.readings.stretch_start_s, self.readings.step_s
        courses = [(x, slopes_of(x, t_s, step_s)) for x in (self.nominal, self.distance)]

        def before(time_s: float) -> tuple[FloatArray, dict[str, Columns]]:
            nominal, distance = (late(*one, t_s, start_s, time_s, 0.0) for one in courses)
            return nominal, self._errors(distance)

        return lru_cache(maxsize=4)(before)

    def _errors(self, distance: FloatArray) -> dict[str, Columns]:
        usual = LONE.size_of_mismatch * self.mismatch
        far = max(float(np.max(np.abs(self.distance[self.rows]))), 1e-9)
        return {
            "offset": Columns.of(np.ones(len(self.t_s)), usual, "offset"),
            "scale": Columns.of(distance, FILE_SPREADS.range_scale_share, "scale"),
            "crosstalk": Columns.of(distance**2, usual / far**2, "curvature"),
        }

    def _drift(self, time_constant_s: float) -> Columns:
        """A sensor warms from the beginning of a recording on, whatever rows are missing in it."""
        first = np.searchsorted(self.readings.part, self.readings.part)
        share = -np.expm1((self.t_s[first] - self.t_s) / time_constant_s)
        return Columns.of(share, self.mismatch, "offset")

    @cached_property
    def covariates(self) -> dict[str, FloatArray]:
        """What an error may follow, name -> (n,)."""
        found = {"distance": self.distance} if self.moves else {}
        return {**found, "time": self.t_s} if self.in_time else found

    def spanned(self, name: str) -> FloatArray:
        """Named shapes (n, j) that no spline term may take the place of."""
        return np.ones((len(self.t_s), 1))

    def pieces(self, name: str) -> int:
        """The same over every covariate; fewer of few places, each of which errs as it does."""
        most = RANGE_SENSOR.range_pieces
        if self.moves_all_the_time and self.in_time:
            return most
        places = len(np.unique(self.groups[self.rows]))
        return int(np.clip(places // RANGE_SENSOR.places_a_piece, LONE.fewest_pieces, most))

    def spread_of(self, name: str, shapes: int) -> float:
        """Half of what readings and distances are apart."""
        return LONE.unknown_of_mismatch * self.mismatch

    def adopt(self, trained: RangeSensorPlant) -> None:
        """Spread of the recording that sizes were found on."""
        self.mismatch = trained.mismatch

    def shown(self, key: str) -> Sequence[Shown]:
        """Parameters of the contract's effects."""
        table = {
            "offset": [_plainly("offset", "m")],
            "scale": [Shown("scale", "1", lambda v: 1.0 + v["scale"], nothing=1.0)],
            "crosstalk": [_plainly("curvature", "1/m")],
            "late": [_plainly("time", "s")],
            "drift": [_plainly("offset", "m"), _plainly("time_constant", "s")],
        }
        return table.get(key, [])


def _plainly(name: str, unit: str) -> Shown:
    return Shown(name, unit, itemgetter(name))


def _gross(left: FloatArray, valid: BoolArray) -> BoolArray:
    """Readings so far off that they are no measurement, where they are few; (n,)."""
    if not valid.any():
        return np.zeros_like(valid)
    off = np.abs(left - np.median(left[valid]))
    usual = max(MAD_TO_SIGMA * float(np.median(off[valid])), 1e-9)
    gross: BoolArray = off > RANGE_SENSOR.gross_from_median * usual
    few = float(gross[valid].mean()) < RANGE_SENSOR.most_gross_ranges
    return gross if few else np.zeros_like(valid)


def averaged(recordings: Sequence[FlatRecording]) -> list[FlatRecording]:
    """With no more rows than are worked on."""
    return [_averaged(recording) for recording in recordings]


def _averaged(recording: FlatRecording) -> FlatRecording:
    """Means of rows that follow each other, where there are more than are of use."""
    count = -(-len(recording) // RANGE_SENSOR.most_ranged_rows)
    if count == 1:
        return recording
    rows = len(recording) // count * count

    def mean(values: FloatArray) -> FloatArray:
        averaged: FloatArray = values[:rows].reshape(-1, count).mean(axis=1)
        return averaged

    columns = {name: mean(recording.columns[name]) for name in ("distance", "range")}
    return replace(recording, t_s=mean(recording.t_s), columns=columns, extra={})
