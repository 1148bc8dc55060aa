"""How much readings scatter, also where a busy computer brings them late."""

from __future__ import annotations

from collections.abc import Callable
from types import SimpleNamespace
from typing import Any, cast

import numpy as np
import pytest

from deltactl.firmware_py.controller.sensing.verify import EVERY_S, LONGER
from deltactl.foundation.errors import NotReady
from deltactl.repair.patients import LOOK_S, Controlled, noise_m

SIGMA_M = 1.5e-3
AXES = "xyz"


class Sensors:
    """Answers of a controller; good: whether the reading of an axis is, at a time [s]."""

    def __init__(self, good: Callable[[str, float], bool], simulated: bool = True):
        self._good, self._simulated, self.t_s = good, simulated, 0.0
        self._rng = np.random.default_rng(1)

    def sleep(self, seconds: float) -> None:
        self.t_s += seconds

    def status(self) -> Any:
        sensors = [
            SimpleNamespace(
                axis=axis,
                age_s=0.0,
                gate="good" if self._good(axis, self.t_s) else "late",
                distance_m=0.5 + SIGMA_M * self._rng.standard_normal(),
            )
            for axis in AXES
        ]
        return SimpleNamespace(sensors=sensors, simulated=self._simulated)


def noise_of(sensors: Sensors) -> float:
    return noise_m(cast(Controlled, sensors), sensors.sleep)


def test_readings_that_are_there_are_looked_at_for_two_seconds() -> None:
    sensors = Sensors(lambda axis, t_s: True)
    assert noise_of(sensors) == pytest.approx(SIGMA_M, rel=0.4)
    assert sensors.t_s == pytest.approx(LOOK_S, abs=2.0 * EVERY_S)


def test_late_readings_are_waited_for() -> None:
    sensors = Sensors(lambda axis, t_s: axis == "z" or t_s > LOOK_S)
    assert noise_of(sensors) == pytest.approx(SIGMA_M, rel=0.6)
    assert LOOK_S < sensors.t_s < LONGER * LOOK_S


@pytest.mark.parametrize("simulated", [True, False])
def test_blind_sensors_are_named(simulated: bool) -> None:
    """That the computer is busy is said of a simulated robot alone."""
    with pytest.raises(NotReady, match="of sensors x, y;") as raised:
        noise_of(Sensors(lambda axis, t_s: axis == "z", simulated))
    assert ("busy computer" in str(raised.value)) == simulated
