"""The drive pushes no harder than its limit, whatever effort is asked of it.

What is recorded is mostly the effort that the controller asks for; a saturated amplifier gives less
(Astrom and Hagglund 2006, Advanced PID Control, section 3.5).
"""

from __future__ import annotations

import numpy as np

from deltactl.models.effects.card import Drawing, EffectCard, Words
from deltactl.models.effects.flow import Flow
from deltactl.models.effects.kind import EffectKind, Memory, Parameter, Port, Values, scalar


def _operate(flow: Flow, index: int, values: Values, memory: Memory) -> None:
    limit = scalar(values, "limit")
    flow.angles_rad = np.clip(flow.angles_rad, -limit, limit)


EFFECT = EffectKind(
    name="effort_limit",
    port=Port.MOTOR,
    components=("axis",),
    parameters=(Parameter("limit", "N m", 1e-9, 1e6, step=1e-3),),
    operate=_operate,
    says=lambda component, v: f"the drive pushes with {v['limit']:.4g} N m at most",
    order=5,
    smooth=False,
)

CARD = EffectCard(
    name="effort_limit",
    on={"effort": EFFECT},
    says={"": "the drive pushes with {limit} at most, however much is asked of it"},
    log_odds={
        # drives are mostly sized for what is asked of them
        "effort/limit": -3.0,
    },
    words=Words(
        noun="a limit of the effort of {part}",
        axis_regime="where the effort is largest",
    ),
    remedies={
        "": (
            "ask less of {part} (slower ramps, a smaller load), or give it a stronger drive: it "
            "pushes with {size} at most"
        ),
    },
    drawing=Drawing(axis=("motor",)),
    slide_names={"torque": "force"},
)
