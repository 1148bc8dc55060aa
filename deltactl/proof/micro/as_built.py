"""Every figure of the simulated micro delta, with where it comes from.

The paper (Uzunovic et al. 2013) publishes lengths, motor and encoder. What it does not is worked
out from those dimensions or assumed; each field says which. Triples are joints 1 to 3.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np

FloatArray = np.ndarray[Any, np.dtype[np.float64]]
Three = tuple[float, float, float]


def each(value: float) -> Three:
    """The same for all three joints."""
    return (value, value, value)


def _array(values: Three) -> FloatArray:
    return np.asarray(values, dtype=np.float64)


@dataclass(frozen=True, slots=True)
class Body:
    """Lengths and masses of what moves."""

    base_radius_m: float = 0.040
    """R_A, section 2."""
    platform_radius_m: float = 0.030
    """R_B, section 2."""
    upper_arm_m: float = 0.040
    """L_A, section 2."""
    forearm_m: float = 0.068
    """L_B, section 2."""
    upper_arm_kg: float = 0.005
    """Assumed: an aluminium bar of 40 x 10 x 7 mm has 7.6 g, a third drilled away. Uniform and
    thin, no hub: its inertia is small against the rotor's, which the gear shows 196-fold."""
    forearm_kg: float = 0.003
    """Assumed, a pair: two carbon tubes of 68 mm and 2 mm have 0.5 g together, four ball joints
    of 6 mm some 0.6 g each. Taken as uniform and thin."""
    platform_kg: float = 0.006
    """Assumed: an aluminium disc of 60 mm and 1.5 mm thickness has 11.5 g, half drilled away."""
    payload_kg: float = 0.0
    """At the middle of the platform."""
    counterweight_nm: Three = (0.0, 0.0, 0.0)
    """Torque that weighs an arm down at angle 0, less at others by the cosine: an arm heavier
    than drawn, a cable (positive), a spring or counterweight (negative). No inertia goes with it.
    """


@dataclass(frozen=True, slots=True)
class Drives:
    """Motors, gearheads, bearings and encoders."""

    gear_ratio: float = 14.0
    """Assumed: planetary gearheads for this motor come with 3.7, 14, 43, 66, ...; the drive
    resolves about 3000 increments a motor turn, which 14 makes 0.0086 degrees at the shaft, and
    the paper says 0.01."""
    rotor_inertia_kgm2: Three = (5.4e-8, 5.4e-8, 5.4e-8)
    """Assumed: 0.54 g cm2, usual for a 16 mm rotor of this class."""
    torque_constant_nmpa: Three = (7.9e-3, 7.9e-3, 7.9e-3)
    """Assumed: 24 V over 29 000 turns a minute, the class of the Faulhaber 1628 024 B."""
    current_limit_a: float = 0.8
    """Assumed: twice what a motor of 2.6 mN m bears for ever."""
    rotor_coulomb_nm: Three = (9.0e-5, 9.0e-5, 9.0e-5)
    """Motor bearings and the gearhead's first stage. Assumed: 11 mA of current turn it idle."""
    rotor_viscous_nmsprad: Three = (8.0e-8, 8.0e-8, 8.0e-8)
    """Assumed: 0.08 mN m at 10 000 turns a minute."""
    bearing_coulomb_nm: Three = (9.8e-4, 9.8e-4, 9.8e-4)
    """At the arm: the gearhead's last stage and the shaft's bearings. Assumed; with the rotors'
    share 2.24 mN m in all, less than the 3 mN m that gravity pulls with: the arms can drop."""
    bearing_viscous_nmsprad: Three = (3.92e-6, 3.92e-6, 3.92e-6)
    """At the arm. Assumed; a fifth of all."""
    encoder_rad: float = float(np.radians(0.01))
    """Section 5: 0.01 degrees at the shaft."""

    def armature_kgm2(self) -> FloatArray:
        """The rotors as the arms feel them, (3,): the gear squared."""
        return self.gear_ratio**2 * _array(self.rotor_inertia_kgm2)

    def dry_nm(self) -> FloatArray:
        """Coulomb friction at the arms, all of it, (3,)."""
        rotors = self.gear_ratio * _array(self.rotor_coulomb_nm)
        return rotors + _array(self.bearing_coulomb_nm)

    def drag_nmsprad(self) -> FloatArray:
        """Viscous friction at the arms, all of it, (3,)."""
        rotors = self.gear_ratio**2 * _array(self.rotor_viscous_nmsprad)
        return rotors + _array(self.bearing_viscous_nmsprad)


@dataclass(frozen=True, slots=True)
class MicroDelta:
    """One built robot."""

    body: Body = Body()
    drives: Drives = Drives()
