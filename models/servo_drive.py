"""The `drive` section of a robot with current-commanded servo drives."""

from __future__ import annotations

from math import pi, radians
from typing import Annotated, Literal

from pydantic import Field

from deltactl.foundation.strict_yaml import RuledModel, rule

Bandwidth = Annotated[
    float, Field(gt=1.0, le=2e4, description="rad/s; a 10 kHz loop sees nothing faster")
]
TICKS_PER_BLOCK_HZ = 1000


class ServoDrive(RuledModel):
    """A motor with current command, its gear and its encoder; the same for all three joints.

    Torques, inertias and friction are those at the rotor. The control law is that of Uzunovic
    2013, equations 5 and 6, see docs/decisions/acceleration-control.md.
    """

    kind: Literal["servo"]
    gear_ratio: Annotated[float, Field(gt=0.0, le=1e4, description="rotor turns per arm turn")]
    torque_constant_nmpa: Annotated[
        float, Field(ge=1e-5, le=100.0, description="N m/A; without torque nothing moves")
    ]
    rotor_inertia_kgm2: Annotated[
        float, Field(ge=1e-10, le=1.0, description="kg m2; a rotor of 1 kg m2 is a flywheel")
    ]
    nominal_inertia_kgm2: Annotated[
        float, Field(ge=1e-10, le=10.0, description="kg m2 at the rotor, m_jjn of equation 4")
    ]
    """What the control law takes for the joint's inertia: rotor and arm, seen from the rotor."""
    coulomb_nm: Annotated[float, Field(ge=0.0, le=100.0, description="N m at the rotor")] = 0.0
    viscous_nmsprad: Annotated[
        float, Field(ge=0.0, le=10.0, description="N m s/rad at the rotor")
    ] = 0.0
    current_limit_a: Annotated[
        float, Field(ge=1e-3, le=1000.0, description="A; with less nothing moves")
    ]
    overload_s: Annotated[
        float, Field(ge=0.001, le=60.0, description="so long a winding bears its limit")
    ] = 0.5
    """At its current limit for longer, a joint counts as overloaded: safe stop."""
    encoder_deg: Annotated[
        float, Field(ge=1e-6, le=5.0, description="degrees of the arm per count")
    ]
    setpoint_deg: Annotated[
        float, Field(ge=1e-5, le=1.0, description="degrees; finer fills the memory, coarser jerks")
    ] = 0.001
    """Set-points are counted in these, as a stepper's are in microsteps."""
    loop_rate_hz: Annotated[
        int, Field(ge=1000, le=20_000, description="Hz; slower is no current loop")
    ] = 10_000
    reference_bandwidth_radps: Bandwidth = 1200.0
    """g of equation 6."""
    velocity_bandwidth_radps: Bandwidth
    """Bandwidth of the velocity observer."""
    disturbance_bandwidth_radps: Bandwidth
    """Bandwidth of the disturbance observer."""
    velocity_gain_1ps: Annotated[
        float, Field(gt=0.0, le=1e4, description="1/s, 100 in equation 5")
    ] = 100.0
    position_gain_1ps2: Annotated[
        float, Field(gt=0.0, le=1e7, description="1/s2, 1000 in equation 5")
    ] = 1000.0
    following_error_deg: Annotated[
        float, Field(gt=0.0, le=90.0, description="degrees of the arm; beyond, it follows nothing")
    ] = 2.0
    """An arm this far from its reference is stopped."""
    brake: Literal["holding", "none"] = "holding"
    """Whether brakes hold the arms while the drives give no current; without they may drop."""
    record_rate_hz: Annotated[
        int, Field(ge=1, le=1000, description="Hz; faster fills the card, not the knowledge")
    ] = 500
    """How often currents, angles and disturbances are recorded."""

    @property
    def rad_per_step(self) -> float:
        """Arm angle of one set-point count [rad]."""
        return radians(self.setpoint_deg)

    @property
    def rad_per_count(self) -> float:
        """Arm angle of one encoder count [rad]."""
        return radians(self.encoder_deg)

    @property
    def period_s(self) -> float:
        """One turn of the control loop [s]."""
        return 1.0 / self.loop_rate_hz

    @rule("loop_rate_hz")
    def _whole_blocks(self) -> None:
        if self.loop_rate_hz % TICKS_PER_BLOCK_HZ:
            raise ValueError("loop_rate_hz must be a whole number of kHz")

    @rule("nominal_inertia_kgm2", "rotor_inertia_kgm2")
    def _rotor_is_part(self) -> None:
        if self.nominal_inertia_kgm2 < self.rotor_inertia_kgm2:
            raise ValueError(
                "nominal_inertia_kgm2 must not be below rotor_inertia_kgm2, which is part of it"
            )

    @rule("disturbance_bandwidth_radps", "velocity_bandwidth_radps")
    def _observers_in_order(self) -> None:
        if self.disturbance_bandwidth_radps > self.velocity_bandwidth_radps:
            raise ValueError(
                "disturbance_bandwidth_radps must not exceed velocity_bandwidth_radps:"
                " one observer uses the other"
            )

    @rule("velocity_bandwidth_radps", "loop_rate_hz")
    def _loop_keeps_up(self) -> None:
        if self.velocity_bandwidth_radps > pi * self.loop_rate_hz / 4.0:
            raise ValueError("velocity_bandwidth_radps is too fast for loop_rate_hz")
