"""Friction that falls with speed near standstill, beyond Coulomb's.

torque exp(-(v / speed)^2) against the motion (Stribeck 1902; Armstrong-Helouvry et al. 1994,
Automatica 30, equation 4 with exponent 2).
"""

from __future__ import annotations

import numpy as np

from deltactl.models.effects.card import Drawing, EffectCard, Words
from deltactl.models.effects.flow import Flow, effort_flow, rub
from deltactl.models.effects.kind import EffectKind, Memory, Parameter, Port, Values, scalar
from deltactl.models.robot import FloatArray

SPEEDS = (0.005, 0.6)
"""Shares of the top speed: below, nothing is read in motion; above, it is viscous friction."""
WITHIN = (0.006, 0.59)
"""Nearer to those ends a speed sits at its bound."""
STARTS = (0.02, 0.06, 0.2)
"""Speeds from which fits begin, as shares of the top speed, apart by a factor of three."""
KNOT = 0.2
"""Between two speeds of a table, in their logarithm: an error of 1e-4 (numerical)."""


def falls(velocity: FloatArray, speed: FloatArray | float) -> FloatArray:
    """Share of the friction at a standstill that is left at velocities."""
    return np.asarray(np.exp(-((velocity / speed) ** 2)))


class Falls:
    """The fall within any speed as a sum of falls within a few, by the logarithm of the speed.

    A low-pass at each speed of a fit takes ten times as long.
    """

    def __init__(self, slowest: float, fastest: float):
        from scipy.interpolate import CubicSpline  # takes 0.3 s to import

        knots = int(np.log(fastest / slowest) / KNOT) + 1
        at = np.linspace(np.log(slowest), np.log(fastest), knots)
        self.speeds = np.exp(at)
        self._spline = CubicSpline(at, np.eye(knots))

    def weights(self, speed: float) -> FloatArray:
        """Weight of each of the few."""
        return np.asarray(self._spline(np.log(speed)))


def _operate(flow: Flow, index: int, values: Values, memory: Memory) -> None:
    flow = effort_flow(flow)
    torque, speed = scalar(values, "torque"), max(scalar(values, "speed"), 1e-12)
    rub(flow, torque * falls(flow.velocity, speed) * flow.direction, torque)


EFFECT = EffectKind(
    name="stribeck_friction",
    port=Port.GEAR,
    components=("axis",),
    parameters=(
        Parameter("torque", "N m", 0.0, 1e5, step=1e-3),
        Parameter("speed", "rad/s", 1e-9, 1e3, step=1e-3),
    ),
    operate=_operate,
    says=lambda component, v: (
        f"friction is {v['torque']:.4g} N m higher near standstill and falls off within "
        f"{v['speed']:.3g} rad/s"
    ),
    order=4,
    smooth=False,
)

CARD = EffectCard(
    name="stribeck_friction",
    on={"effort": EFFECT},
    says={
        "": "friction is {torque} higher near standstill, falling off within {speed}",
    },
    log_odds={
        # every greased bearing has it, few recordings stay slow for long enough
        "effort/stribeck": -3.0,
    },
    words=Words(
        noun="friction in {part} that falls with speed near standstill",
        axis_regime="in slow motion",
        sizes={"width": "difference between the two directions"},
    ),
    remedies={
        "": "grease {part}: it sticks at low speed",
        "slide/": "grease the guides and the screw of {part}: it sticks at low speed",
    },
    drawing=Drawing(motor="gear", axis=("bearing",)),
    slide_names={"torque": "force"},
)
