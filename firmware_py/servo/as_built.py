"""How a simulated servo robot differs from its file: what the control law does not know."""

from __future__ import annotations

from math import inf
from typing import Annotated, Literal

from pydantic import Field

from deltactl.drivers.fakes.current_drives import PlannedFault
from deltactl.foundation.strict_yaml import StrictModel

Scale = Annotated[float, Field(ge=0.1, le=10.0, description="1 is as in the file")]
PerJoint = tuple[Scale, Scale, Scale]


class FaultAt(StrictModel):
    """A fault of a simulated drive that comes by itself."""

    kind: Literal["encoder_lost", "over_current"]
    """The encoder gives no signal, or the drive trips."""
    joint: Annotated[int, Field(ge=1, le=3, description="a delta has three joints")]
    at_s: Annotated[float, Field(ge=0.0, le=1e6, description="seconds since the simulation began")]

    lasts_s: Annotated[float, Field(gt=0.0, le=1e6, description="seconds")] | None = None
    """Absent: until the simulation ends."""

    def planned(self) -> PlannedFault:
        """For the fake drives."""
        lasts_s = inf if self.lasts_s is None else self.lasts_s
        return PlannedFault(self.kind, self.joint, self.at_s, lasts_s)


class AsBuiltServo(StrictModel):
    """True values over those of the file, joint by joint; a payload; faults to come."""

    coulomb_scale: PerJoint = (1.0, 1.0, 1.0)
    viscous_scale: PerJoint = (1.0, 1.0, 1.0)
    torque_constant_scale: PerJoint = (1.0, 1.0, 1.0)
    rotor_inertia_scale: Scale = 1.0
    mass_scale: Scale = 1.0
    """Factor of every moving mass."""
    payload_kg: Annotated[float, Field(ge=0.0, le=100.0, description="kilograms")] = 0.0
    faults: tuple[FaultAt, ...] = ()
