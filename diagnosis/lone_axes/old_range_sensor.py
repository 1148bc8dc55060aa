"""A range sensor by itself and its recordings, as the engine sees them."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from diagnosis.observations.needed_columns import filled, needed, refuse_other_units, refuse_still
from diagnosis.observations.readings import FloatArray, Readings, gather
from diagnosis.plants import axis_candidates as moves
from diagnosis.plants.candidate import Candidate, Term
from diagnosis.plants.nuisance import Nuisance
from models.chain.range_sensor import SensorChain
from models.effects.lone_axis import COMPONENT
from models.robot import RangeSensor
from recording.flat import FlatRecording

MOST_ROWS = 40_000
FEWEST = 20
"""A calibration table is short, and each of its rows may be the mean of many readings."""


class RangeSensorModel:
    """Predictions of one sensor's reading from the true distance."""

    def __init__(self, robot: RangeSensor, recordings: Sequence[FlatRecording]):
        self.robot = robot
        self.unit = "m"
        self.chain = SensorChain(robot.effects)
        for recording in recordings:
            needed(recording, ("distance",), "distance")
            needed(recording, ("range",), "range")
        recordings = [_averaged(recording) for recording in recordings]
        self.readings: Readings = gather(recordings, ["range"], {"range": "m"}, FEWEST)
        self.distance_m = np.concatenate([filled(r, "distance") for r in recordings])
        source = recordings[0].source
        refuse_still(self.readings.values[:, 0], "range", source)
        refuse_other_units(
            self.distance_m, self.readings.values[:, 0], "range and distance", source
        )
        self._parts = [self.readings.part == n for n in range(len(recordings))]
        self.nuisances: list[Nuisance] = []
        self.tolerances: list[Nuisance] = []
        self.candidates = self._candidates()
        self.groups: list[Candidate] = []

    @property
    def _moves(self) -> bool:
        return float(np.ptp(self.distance_m)) > 1e-6

    def _candidates(self) -> list[Candidate]:
        kinds = self.chain.kinds
        found = [
            moves.simple(kinds["sensor_offset"], 1e-4),
            moves.drift(kinds["sensor_drift"], self.readings.span_s),
        ]
        if self._moves:
            found += [
                moves.simple(kinds["sensor_scale"], 1e-4),
                moves.simple(kinds["sensor_crosstalk"], 1e-4),
                moves.latency(kinds["sensor_latency"], self.readings.period_s),
            ]
        return found

    def predict(self, terms: Sequence[Term]) -> FloatArray:
        """The reading without noise, (n, 1)."""
        readings, active = self.readings, [term.active for term in terms]
        parts = [
            self.chain.simulate(
                readings.t_s[rows], self.distance_m[rows], readings.fresh[rows], active
            )
            for rows in self._parts
        ]
        return np.concatenate(parts)[:, None]

    def drivers(self) -> dict[str, FloatArray]:
        """Distance and time; a table sorted by distance has no time of its own."""
        drivers = {"distance": self.distance_m}
        steps = np.diff(self.distance_m)
        if not self._moves or not ((steps >= 0.0).all() or (steps <= 0.0).all()):
            drivers["time"] = self.readings.t_s
        return drivers

    def ports(self) -> dict[str, FloatArray]:
        """The sensor itself."""
        return {COMPONENT: np.ones((len(self.readings.t_s), 1))}


def _averaged(recording: FlatRecording) -> FlatRecording:
    """Means of rows that follow each other, where there are more than are of use."""
    count = -(-len(recording) // MOST_ROWS)
    if count == 1:
        return recording
    rows = len(recording) // count * count

    def mean(values: FloatArray) -> FloatArray:
        averaged: FloatArray = values[:rows].reshape(-1, count).mean(axis=1)
        return averaged

    columns = {name: mean(recording.columns[name]) for name in ("distance", "range")}
    return FlatRecording(mean(recording.t_s), columns, {}, recording.source)
