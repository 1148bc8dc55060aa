"""Which tests make sense on a delta: by the names of its motors, sensors and covariates."""

from __future__ import annotations

from collections.abc import Iterable
from functools import partial

from diagnosis.plants.delta.candidates import TOLERANCES, lost_steps
from diagnosis.plants.traits import Traits

MOTOR, SENSOR = "motor", "range_"


def delta_traits(ports: Iterable[str], channels: Iterable[str]) -> Traits:
    """Of a delta with these input locations and channels."""
    ports = list(ports)
    motors = [port for port in ports if port.startswith(MOTOR)]
    return Traits(
        events={port: partial(lost_steps, port) for port in motors},
        repeating=tuple(name for name in channels if name.startswith(SENSOR)),
        own_place={port: port.replace(MOTOR, "theta_") for port in ports},
        sensible=sensible,
        units={port: "rad" if port in motors else "m" for port in ports},
        build_effects=frozenset(TOLERANCES),
    )


def sensible(port: str, driver: str, coarse: bool) -> bool:
    """A joint's own motion, a sensor's all: what else is tried with few knots only, or never."""
    elsewhere = driver[-1] != port[-1]
    if port.startswith(MOTOR):
        if driver.startswith("speed_range") or "," in driver:
            return False
        neighbour = driver.startswith("theta") and coarse
        return neighbour or not (driver[-1] in "123" and elsewhere)
    if port.startswith(SENSOR):
        if driver.startswith("speed_range"):
            return coarse and not elsewhere
        return not driver.startswith(("speed", "torque")) and (coarse or "," not in driver)
    return True
