"""Friction that falls with speed near standstill, beyond Coulomb's.

torque exp(-(v / speed)^2) against the motion (Stribeck 1902; Armstrong-Helouvry et al. 1994,
Automatica 30, equation 4 with exponent 2).
"""

from __future__ import annotations

import numpy as np

from deltactl.models.effects.card import Drawing, EffectCard, Words
from deltactl.models.effects.flow import Flow, effort_flow, rub
from deltactl.models.effects.kind import EffectKind, Memory, Parameter, Port, Values, scalar


def _operate(flow: Flow, index: int, values: Values, memory: Memory) -> None:
    flow = effort_flow(flow)
    torque, speed = scalar(values, "torque"), max(scalar(values, "speed"), 1e-12)
    fall = np.exp(-((flow.velocity / speed) ** 2))
    rub(flow, torque * fall * flow.direction, torque)


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
