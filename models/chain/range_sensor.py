"""A range sensor by itself: true distance in, reading out."""

from __future__ import annotations

from collections.abc import Iterable, Sequence

import numpy as np

from deltactl.models.chain.active import Active, at
from deltactl.models.chain.axis import entries_of
from deltactl.models.chain.commands import BoolArray
from deltactl.models.effects.flow import Flow, Load
from deltactl.models.effects.lone_axis import sensor_effects
from deltactl.models.effects.port import Port
from deltactl.models.robot import EffectEntry, FloatArray


class SensorChain:
    """The last links of the delta's chain, for one sensor."""

    def __init__(self, believed: Sequence[EffectEntry] = ()):
        self.kinds = sensor_effects()
        self._believed = tuple(believed)
        entries_of(self._believed, self.kinds)

    def simulate(
        self,
        t_s: FloatArray,
        distance_m: FloatArray,
        fresh: BoolArray,
        effects: Iterable[Active] = (),
    ) -> FloatArray:
        """What the sensor reports, shape (n,)."""
        nothing = np.zeros((len(t_s), 1))
        flow = Flow(t_s, fresh, float(t_s[0]), nothing, lambda: Load(nothing, nothing))
        flow.ranges_m = np.array(distance_m)[:, None]
        active = [*entries_of(self._believed, self.kinds), *effects]
        for effect in at(active, Port.SENSOR):
            effect.act(flow)
        flow.measured_rad = flow.ranges_m
        for effect in at(active, Port.ENCODER):
            effect.act(flow)
        return flow.measured_rad[:, 0]
