"""The upper arms grow while they warm up, from the start of the recording.

The motors' heat flows into the upper arms; the forearm rods hang behind two joints and stay cold.
"""

from __future__ import annotations

import numpy as np

from deltactl.models.effects.card import (
    Compensated,
    Coordinate,
    EffectCard,
    Fit,
    Rule,
    Trait,
    Words,
)
from deltactl.models.effects.flow import Flow
from deltactl.models.effects.kind import (
    Discrepancy,
    EffectKind,
    Memory,
    Parameter,
    Port,
    Values,
    scalar,
)

PHYSICAL_STRAIN = 0.012
"""Polyamide by 100 K (120e-6 per K; ABS 100e-6, PLA 70e-6, aluminium 23e-6, steel 12e-6; tables of
linear expansion): no arm grows more."""
MOST_STRAIN = 0.1
"""How far a fit may go. A bound at the physical figure would cut off the profile of the interval
where a recording is shorter than the warming takes."""


def _operate(flow: Flow, index: int, values: Values, memory: Memory) -> None:
    warm = -np.expm1(-flow.since_s / scalar(values, "time_constant"))
    growth = 1.0 + scalar(values, "strain") * warm[:, None]
    flow.linkage["upper_arm_m"] = flow.linkage["upper_arm_m"] * growth


EFFECT = EffectKind(
    name="thermal_expansion",
    port=Port.LINKAGE,
    components=("arms",),
    parameters=(
        Parameter("strain", "1", -MOST_STRAIN, MOST_STRAIN, typical=0.0005),
        Parameter("time_constant", "s", 1.0, 1e5, starts=(15.0, 60.0, 200.0), step=2.0, spread=1),
    ),
    operate=_operate,
    says=lambda component, v: (
        f"the upper arms change their length by {100 * v['strain']:+.3f} % while warming up, "
        f"with a time constant of {v['time_constant']:.0f} s"
    ),
    order=1,
    smooth=False,
    # one time constant of several
    discrepancy=Discrepancy(0.003, 0.003),
    physical=PHYSICAL_STRAIN,
)

CARD = EffectCard(
    name=EFFECT.name,
    kind=EFFECT,
    listed=4,
    words=Words(
        noun="arms that grow while they warm up",
        regime="growing since the start of the recording",
    ),
    remedies={
        "": "let the arms warm up before exact work: they {sign:grow|shrink} by {size}",
    },
    rule=Rule.SUM,
    traits=frozenset({Trait.WARMS}),
    compensated=Compensated.WARMING,
    fit=Fit(
        coordinates=(
            Coordinate("strain", step=1e-4, low=-MOST_STRAIN, high=MOST_STRAIN),
            Coordinate("time_constant", "log", step=0.05, low=0.0, high=np.log(1e5)),
        ),
    ),
)
