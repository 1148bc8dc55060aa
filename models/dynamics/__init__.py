"""How a delta moves under torque: Uzunovic 2013, equations 3 and 4.

`terms` is vectorised over poses, for analysis; `PlainBody` is the same one pose at a time in
plain floats, for `DeltaPlant`, which simulates a robot as fast as a control loop asks.
"""

from deltactl.models.dynamics.plain import PlainBody, Terms
from deltactl.models.dynamics.plant import DeltaPlant, PlantSettings
from deltactl.models.dynamics.terms import (
    kinetic_energy_j,
    mass_matrix_kgm2,
    potential_energy_j,
    velocity_torque_nm,
)

__all__ = [
    "DeltaPlant",
    "PlainBody",
    "PlantSettings",
    "Terms",
    "kinetic_energy_j",
    "mass_matrix_kgm2",
    "potential_energy_j",
    "velocity_torque_nm",
]
