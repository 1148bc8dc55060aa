"""A distance sensor reports a constant multiple of the distance."""

from __future__ import annotations

from deltactl.models.effects.card import (
    ByHand,
    Compensated,
    Confusion,
    Defect,
    Drawing,
    EffectCard,
    Rule,
    Trait,
    Words,
)
from deltactl.models.effects.kind import (
    RANGES,
    EffectKind,
    Parameter,
    Port,
    scales,
)

EFFECT = EffectKind(
    name="sensor_scale",
    port=Port.SENSOR,
    components=RANGES,
    parameters=(Parameter("scale", "1", 0.2, 5.0, starts=(1.0,), typical=0.005),),
    operate=scales("ranges_m", "scale"),
    says=lambda component, v: (
        f"{component} reads {100 * (v['scale'] - 1):+.2f} % of the distance too much"
    ),
    order=1,
    nothing=1.0,
    # where a motion tells neither from an offset, the offset is likelier
    penalty=0.5,
    pose_alone=True,
)

CARD = EffectCard(
    name=EFFECT.name,
    kind=EFFECT,
    listed=1,
    on={"range": EFFECT},
    says={
        "": "the sensor reads {scale} times the distance",
    },
    log_odds={
        # wears or is set by hand
        "range/scale": -1.0,
    },
    words=Words(
        noun="a wrong scale of {part}",
        several="wrong scales of {part}",
        regime="in proportion to the distance",
        axis_regime="in proportion to the distance",
        axis_part="the sensor",
    ),
    remedies={
        "": "have {part} calibrated: it reads {size} {sign:too far|short}",
        "sensor/": (
            "divide what {part} reads by {factor} (after taking off a constant error, if there is "
            "one): it reads {size} {sign:too far|short}"
        ),
    },
    drawing=Drawing(axis=("sensor",)),
    traits=frozenset({Trait.BY_DISTANCE, Trait.READING, Trait.SIGNED, Trait.WARMS}),
    rule=Rule.PRODUCT,
    compensated=Compensated.IN_READINGS,
    confusions=(
        Confusion(
            "sensor_crosstalk",
            axis="record again over a wider span of distances, near ones and far ones",
        ),
    ),
    by_hand=ByHand("measure two distances of a sensor with a gauge", 9),
    build_spread=0.002,  # 1: 1 mm in half a metre
    defect=Defect("the y sensor reads 3 % too far", "range_y", {"scale": 1.03}, 5),
)
