"""A servo delta simulated forward in time: motors, gears, friction, linkage, gravity.

    (M + N^2 J_rotor) a'' + c + g + N^2 viscous a' + N coulomb sign(a') = N K i

with M, c, g of `models.dynamics.terms` at the arms' shafts, N the gear ratio. Semi-implicit Euler
at the control period. M, c and g change slowly: they are worked out every `REFRESH` periods. Dry
friction is the impulse that brings a joint to rest or, if that is more than it has, its whole: an
arm really sticks (Gauss and Seidel's iteration, one sweep a period, from where the last ended).

Does not model: play and compliance of the gears, torque ripple, the current loop's lag.
"""

from __future__ import annotations

from dataclasses import dataclass
from math import radians

from deltactl.foundation.errors import UnreachablePoint
from deltactl.models.dynamics.plain import PlainBody, Terms
from deltactl.models.linkage import Linkage
from deltactl.models.linkage.vectors import Vector
from deltactl.models.robot import Geometry, Masses
from deltactl.models.servo_drive import ServoDrive

REFRESH = 10
"""Periods between two looks at M, c and g: 1 ms of a 10 kHz loop, in which an arm at 3 rad/s
turns by 0.2 degrees."""


@dataclass(frozen=True, slots=True)
class PlantSettings:
    """What moves and what rubs; triples hold for the three joints, friction is at the rotors."""

    geometry: Geometry
    masses: Masses
    period_s: float
    gear_ratio: float
    rotor_inertia_kgm2: float
    torque_constants_nmpa: Vector
    coulomb_nm: Vector
    viscous_nmsprad: Vector
    payload_kg: float = 0.0
    stops_rad: tuple[float, float] = (-3.0, 3.0)
    """Where the arms meet their stops, without rebound."""

    @classmethod
    def of(
        cls,
        geometry: Geometry,
        masses: Masses,
        drive: ServoDrive,
        stops_deg: tuple[float, float] = (-170.0, 170.0),
    ) -> PlantSettings:
        """The plant of a robot file, just as the file has it."""
        return cls(
            geometry=geometry,
            masses=masses,
            period_s=drive.period_s,
            gear_ratio=drive.gear_ratio,
            rotor_inertia_kgm2=drive.rotor_inertia_kgm2,
            torque_constants_nmpa=(drive.torque_constant_nmpa,) * 3,
            coulomb_nm=(drive.coulomb_nm,) * 3,
            viscous_nmsprad=(drive.viscous_nmsprad,) * 3,
            stops_rad=(radians(stops_deg[0]), radians(stops_deg[1])),
        )


class DeltaPlant:
    """Implements `deltactl.drivers.current_drives.Plant`: currents in, arm angles out."""

    def __init__(self, settings: PlantSettings, angles_rad: Vector):
        self.settings = settings
        self._body = PlainBody(Linkage.of(settings.geometry), settings.masses, settings.payload_kg)
        gear = settings.gear_ratio
        self._rotor = settings.rotor_inertia_kgm2 * gear**2
        first, second, third = (gear * constant for constant in settings.torque_constants_nmpa)
        self._torques = (first, second, third)
        first, second, third = (gear * size for size in settings.coulomb_nm)
        self._dry = (first, second, third)
        first, second, third = (gear**2 * size for size in settings.viscous_nmsprad)
        self._wet = (first, second, third)
        self.place(angles_rad)

    def place(self, angles_rad: Vector) -> None:
        """Put the arms at these true angles, at rest. Raises UnreachablePoint."""
        self._angles = self._sound = angles_rad
        self._speeds: Vector = (0.0, 0.0, 0.0)
        self._rub: Vector = (0.0, 0.0, 0.0)
        self._due = 0
        self._refresh()

    def angles_rad(self) -> Vector:
        """True arm angles [rad]."""
        return self._angles

    def speeds_radps(self) -> Vector:
        """True arm speeds [rad/s]."""
        return self._speeds

    def hold(self) -> None:
        """One period with the brakes on: nothing moves."""
        self._speeds = (0.0, 0.0, 0.0)

    def terms(self) -> Terms:
        """M, c + g here and now, without the rotors."""
        return self._body.terms(self._angles, self._speeds)

    def advance(self, first: float, second: float, third: float) -> None:
        """One period with these motor currents [A]."""
        if self._due == 0:
            self._refresh()
        self._due -= 1
        n11, n22, n33, n12, n13, n23 = self._mobility
        v1, v2, v3 = self._speeds
        k1, k2, k3 = self._torques
        l1, l2, l3 = self._load
        w1, w2, w3 = self._wet
        f1, f2, f3 = self._rub
        t1 = k1 * first - l1 - w1 * v1 - f1
        t2 = k2 * second - l2 - w2 * v2 - f2
        t3 = k3 * third - l3 - w3 * v3 - f3
        v1 += n11 * t1 + n12 * t2 + n13 * t3
        v2 += n12 * t1 + n22 * t2 + n23 * t3
        v3 += n13 * t1 + n23 * t2 + n33 * t3

        d1, d2, d3 = self._dry
        was, f1 = f1, f1 + v1 / n11
        f1 = d1 if f1 > d1 else -d1 if f1 < -d1 else f1
        more = f1 - was
        v1 -= n11 * more
        v2 -= n12 * more
        v3 -= n13 * more
        was, f2 = f2, f2 + v2 / n22
        f2 = d2 if f2 > d2 else -d2 if f2 < -d2 else f2
        more = f2 - was
        v1 -= n12 * more
        v2 -= n22 * more
        v3 -= n23 * more
        was, f3 = f3, f3 + v3 / n33
        f3 = d3 if f3 > d3 else -d3 if f3 < -d3 else f3
        more = f3 - was
        v1 -= n13 * more
        v2 -= n23 * more
        v3 -= n33 * more

        self._rub = (f1, f2, f3)
        self._speeds = (v1, v2, v3)
        a1, a2, a3 = self._angles
        period_s = self.settings.period_s
        self._angles = (a1 + v1 * period_s, a2 + v2 * period_s, a3 + v3 * period_s)

    def _refresh(self) -> None:
        """Work out the load, and how a torque over one period changes the speeds."""
        self._due = REFRESH
        self._meet_stops()
        m11, m22, m33, m12, m13, m23, self._load = self._terms_or_jam()
        m11, m22, m33 = m11 + self._rotor, m22 + self._rotor, m33 + self._rotor
        c11, c12, c13 = m22 * m33 - m23 * m23, m13 * m23 - m12 * m33, m12 * m23 - m13 * m22
        scale = self.settings.period_s / (m11 * c11 + m12 * c12 + m13 * c13)
        self._mobility = (
            c11 * scale,
            (m11 * m33 - m13 * m13) * scale,
            (m11 * m22 - m12 * m12) * scale,
            c12 * scale,
            c13 * scale,
            (m12 * m13 - m11 * m23) * scale,
        )

    def _terms_or_jam(self) -> Terms:
        """The terms; where the linkage would come apart it jams in its last pose instead."""
        try:
            terms = self._body.terms(self._angles, self._speeds)
        except UnreachablePoint:
            self._angles, self._speeds = self._sound, (0.0, 0.0, 0.0)
            terms = self._body.terms(self._angles, self._speeds)
        self._sound = self._angles
        return terms

    def _meet_stops(self) -> None:
        low, high = self.settings.stops_rad
        angles, speeds = list(self._angles), list(self._speeds)
        for joint, angle in enumerate(angles):
            if not low <= angle <= high:
                angles[joint] = low if angle < low else high
                inwards = speeds[joint] > 0.0 if angle < low else speeds[joint] < 0.0
                speeds[joint] = speeds[joint] if inwards else 0.0
        self._angles = (angles[0], angles[1], angles[2])
        self._speeds = (speeds[0], speeds[1], speeds[2])
