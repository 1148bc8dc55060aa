"""A distance sensor reports a constant offset."""

from __future__ import annotations

from deltactl.models.effects.card import (
    ByHand,
    Compensated,
    Confusion,
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
    adds,
)

EFFECT = EffectKind(
    name="sensor_offset",
    port=Port.SENSOR,
    components=RANGES,
    parameters=(Parameter("offset", "m", -0.5, 0.5, typical=0.005),),
    operate=adds("ranges_m", "offset"),
    says=lambda component, v: f"{component} reads {1e3 * v['offset']:+.2f} mm off, everywhere",
    order=2,
    pose_alone=True,
)

CARD = EffectCard(
    name=EFFECT.name,
    kind=EFFECT,
    listed=0,
    on={"range": EFFECT},
    says={"": "the sensor reads {size} {sign:too far|short}"},
    log_odds={
        # wears or is set by hand
        "range/offset": -1.0,
    },
    words=Words(
        noun="a constant error of {part}",
        several="constant errors of {part}",
        axis_part="the sensor",
    ),
    remedies={
        "": (
            "set {part} to zero ('deltactl status sensors --calibrate'): it reads {size} {sign:too "
            "far|short}"
        ),
        "sensor/": (
            "{sign:take|add} {size} {sign:off|to} what {part} reads: it reads that much {sign:too "
            "far|short}"
        ),
    },
    drawing=Drawing(axis=("sensor",)),
    traits=frozenset({Trait.BY_DISTANCE, Trait.READING, Trait.SIGNED, Trait.WARMS}),
    rule=Rule.SUM,
    compensated=Compensated.IN_READINGS,
    confusions=(
        Confusion(
            "sensor_scale",
            axis="record again over a wider span of distances, near ones and far ones",
        ),
        Confusion(
            "sensor_drift",
            axis="record again from switching on, for longer",
        ),
    ),
    by_hand=ByHand("measure one distance of a sensor with a gauge", 8),
    build_spread=0.0015,  # m: a board held by two screws, and the sensor's own offset
)
