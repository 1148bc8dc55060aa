"""Stability margins: against closed forms, and against the loop itself at and beyond them.

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

from dataclasses import dataclass, replace
from typing import Any

import numpy as np
import pytest

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
    above = [float(1.0 / size[turn]) for turn in turns if size[turn] < 1.0]
    below = [float(1.0 / size[turn]) for turn in turns if size[turn] >= 1.0]
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


def of(settings, drive, factor: float = 1.0):
    return margins(settings, factor * drive.nominal_inertia_kgm2, drive.torque_constant_nmpa)


def test_the_shipped_loop_s_margins(drive) -> None:
    """What docs/decisions/acceleration-control.md says."""
    found = of(LawSettings.of(drive), drive)
    assert found.phase_deg == pytest.approx(45.0, abs=0.1)
    assert found.gain == pytest.approx(6.4, abs=0.05)
    assert found.crossover_radps == pytest.approx(2476, abs=5)
    # Half the inertia that the law believes in doubles the loop's gain.
    assert of(LawSettings.of(drive), drive, 0.5).phase_deg > 25.0
    assert of(LawSettings.of(drive), drive, 2.0).phase_deg > found.phase_deg


def test_without_observer_and_filters_it_is_the_textbook_loop(drive) -> None:
    """kd / s + kp / s^2 crosses 1 where w^4 = kd^2 w^2 + kp^2, with margin atan(kd w / kp)."""
    ideal = replace(
        LawSettings.of(drive),
        period_s=1e-6,
        velocity_bandwidth_radps=1e6,
        disturbance_observer=False,
    )
    found = of(ideal, drive)
    kd, kp = 100.0, 1000.0
    crossing = np.sqrt((kd**2 + np.sqrt(kd**4 + 4 * kp**2)) / 2)
    assert found.crossover_radps == pytest.approx(crossing, rel=1e-3)
    assert found.phase_deg == pytest.approx(np.rad2deg(np.arctan(kd * crossing / kp)), abs=0.1)


def test_with_the_observer_it_is_the_continuous_loop_at_low_frequency(drive) -> None:
    """C = m/K (kd s + kp + g s^2/(s+g)) V/s (s+g)/s with V = g_v s/(s+g_v), P = K / (m s^2).

    The observer sees the current one period late, so that its g counts as (1 - exp(-g T)) / T.
    """
    law = LawSettings.of(drive)
    w = np.array([20.0, 60.0, 200.0, 500.0])
    s = 1j * w
    g = law.share(law.disturbance_bandwidth_radps) / law.period_s
    gv = law.velocity_bandwidth_radps
    speed = gv * s / (s + gv)
    wanted = 100.0 * speed + 1000.0 + g * s / (s + g) * speed
    continuous = wanted * (s + g) / s / s**2
    found = loop_gain(law, w, drive.nominal_inertia_kgm2, drive.torque_constant_nmpa)
    assert np.abs(found / continuous - 1.0).max() < 0.1
    assert np.abs(found / continuous - 1.0)[0] < 0.01


@pytest.mark.parametrize("velocity", [1500.0, 3000.0])
@pytest.mark.parametrize("disturbance", [500.0, 1500.0])
def test_the_gain_margin_is_where_the_loop_begins_to_swing(
    joint, fine, drive, velocity, disturbance
) -> None:
    law = replace(fine, velocity_bandwidth_radps=velocity, disturbance_bandwidth_radps=disturbance)
    highest = of(law, drive).gain
    for share, swings in ((0.95, False), (1.05, True)):
        # The observer must see the current as the joint does: gain by a lighter joint.
        lighter = drive.nominal_inertia_kgm2 / (share * highest)
        angle, _, _ = joint(law, start_rad=1e-3, inertia_kgm2=lighter).run(0.3, lambda t: 0.0)
        late, later = np.abs(angle[1000:1500]).max(), np.abs(angle[-500:]).max()
        assert (later > late) == swings, (share, late, later)
