"""How fast a job is: all motors at one step period, or each as fast as its limits allow."""

from __future__ import annotations

from typing import Annotated, Any, Literal

from pydantic import Discriminator, Field, Tag

from deltactl.foundation.strict_yaml import RuledModel, StrictModel, rule

SLOWEST_MPS, FASTEST_MPS = 1e-6, 10.0


class Together(StrictModel):
    """All motors step together, one tick every T_PWM, as in Zhao 2023. There are no ramps."""

    mode: Literal["together"] = "together"
    t_pwm_s: Annotated[
        float, Field(ge=50e-6, le=10.0, description="the pulse process is good for 50 us and up")
    ]


class Accelerated(RuledModel):
    """Every motor keeps its own speed and acceleration limit; the path slows down where it must."""

    mode: Literal["accelerated"]
    speed_mps: (
        Annotated[float, Field(ge=SLOWEST_MPS, le=FASTEST_MPS, description="m/s; 1 um/s to 10 m/s")]
        | None
    ) = None
    """Speed of the platform along the path wherever the limits allow it."""
    duration_s: (
        Annotated[float, Field(ge=0.01, le=86400.0, description="seconds; a day at most")] | None
    ) = None
    """In place of a speed: how long each repeat takes from leaving the first target, with the
    rests at the others and the way back to its start. Refused, with the shortest time there is,
    where the limits do not allow it."""
    joint_speed_radps: (
        Annotated[float, Field(ge=1e-5, le=1e3, description="rad/s, a turn a week to 160 a second")]
        | None
    ) = None
    """Not above the robot file's limit; absent for that limit. So too the acceleration."""
    joint_acceleration_radps2: (
        Annotated[float, Field(ge=1e-4, le=1e5, description="rad/s2; beyond is a blow")] | None
    ) = None

    @rule("speed_mps", "duration_s")
    def _either(self) -> None:
        if (self.speed_mps is None) == (self.duration_s is None):
            raise ValueError("give either 'speed_mps' or 'duration_s'")


def mode(timing: Any) -> Any:
    """The mode that a `timing` section asks for; without one all motors step together."""
    if isinstance(timing, dict):
        return timing.get("mode", "together")
    return getattr(timing, "mode", "together")


Timing = Annotated[
    Annotated[Together, Tag("together")] | Annotated[Accelerated, Tag("accelerated")],
    Discriminator(mode),
]
