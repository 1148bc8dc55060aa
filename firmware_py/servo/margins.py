"""How far the control loop of one joint is from swinging by itself.

The loop as it runs: the law of `firmware_py.servo.law` at its period T, and a free joint of
inertia J behind a current held for T. With z = exp(j w T), a = 1 - exp(-g T) for each bandwidth:

    low-pass       Q(z) = a / (1 - (1 - a) / z)
    derivative     D(z) = a / T (1 - 1/z) / (1 - (1 - a) / z)          (of bandwidth g_v: V(z))
    from angle to current, broken at the current:
                   C(z) = (m / K) (kd V + kp + (D_d / a_d') V) / (1 - Q_d / z)
    joint          P(z) = K T^2 / (2 J) (1/z + 1/z^2) / (1 - 1/z)^2

with D_d V the disturbance observer's acceleration. The loop is L = C P.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np

from deltactl.firmware_py.servo.law import LawSettings
from deltactl.models.robot import FloatArray

ComplexArray = np.ndarray[Any, np.dtype[np.complex128]]
LOOKS = 200_000


@dataclass(frozen=True, slots=True)
class Margins:
    """What the loop's current may be multiplied by, and how much later it may come."""

    gain: float
    """Highest factor."""
    least_gain: float
    """Lowest factor; 0 where any will do."""
    phase_deg: float
    crossover_radps: float

    @property
    def delay_s(self) -> float:
        """Extra delay that would use the phase margin up [s]."""
        return float(np.deg2rad(self.phase_deg)) / self.crossover_radps


def loop_gain(
    settings: LawSettings,
    frequency_radps: FloatArray,
    inertia_kgm2: float,
    torque_constant_nmpa: float,
) -> ComplexArray:
    """L at frequencies (n,) for a joint that really has this inertia and torque constant."""
    period_s = settings.period_s
    back = np.exp(-1j * frequency_radps * period_s)  # 1 / z
    velocity = _derivative(settings.share(settings.velocity_bandwidth_radps), period_s, back)
    share = settings.share(settings.disturbance_bandwidth_radps)
    wanted = settings.velocity_gain_1ps * velocity + settings.position_gain_1ps2
    seen = 1.0 + 0.0j
    if settings.disturbance_observer:
        wanted = wanted + _derivative(share, period_s, back) * velocity
        seen = 1.0 - share / (1.0 - (1.0 - share) * back) * back
    controller = settings.amperes_per_radps2 * wanted / seen
    joint = torque_constant_nmpa * period_s**2 / (2.0 * inertia_kgm2)
    loop: ComplexArray = controller * joint * back * (1.0 + back) / (1.0 - back) ** 2
    return loop


def margins(settings: LawSettings, inertia_kgm2: float, torque_constant_nmpa: float) -> Margins:
    """Margins of the loop; every crossing up to half the loop's rate is looked at."""
    fastest = np.pi / settings.period_s
    frequency = np.geomspace(fastest * 1e-5, fastest * (1.0 - 1e-6), LOOKS)
    loop = loop_gain(settings, frequency, inertia_kgm2, torque_constant_nmpa)
    size, phase = np.abs(loop), np.unwrap(np.angle(loop))
    phase -= 2.0 * np.pi * np.round((phase[0] + np.pi) / (2.0 * np.pi))
    falls = np.flatnonzero((size[:-1] >= 1.0) & (size[1:] < 1.0))
    turns = np.flatnonzero(np.diff(np.sign(phase + np.pi)) != 0)
    above = [float(1.0 / size[one]) for one in turns if size[one] < 1.0]
    below = [float(1.0 / size[one]) for one in turns if size[one] >= 1.0]
    crossing = int(falls[-1])
    return Margins(
        gain=min(above, default=float("inf")),
        least_gain=max(below, default=0.0),
        phase_deg=float(np.rad2deg(phase[falls] + np.pi).min()),
        crossover_radps=float(frequency[crossing]),
    )


def _derivative(share: float, period_s: float, back: ComplexArray) -> ComplexArray:
    slope: ComplexArray = share / period_s * (1.0 - back) / (1.0 - (1.0 - share) * back)
    return slope
