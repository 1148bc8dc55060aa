"""A distance sensor's error grows with the square of the distance (light from the cover glass)."""

from __future__ import annotations

from deltactl.models.effects.card import Compensated, Drawing, EffectCard, Rule, Trait, Words
from deltactl.models.effects.flow import Flow
from deltactl.models.effects.kind import RANGES, EffectKind, Memory, Parameter, Port, Values, scalar


def _operate(flow: Flow, index: int, values: Values, memory: Memory) -> None:
    distance = flow.ranges_m[:, index]
    flow.ranges_m[:, index] = distance + scalar(values, "curvature") * distance**2


EFFECT = EffectKind(
    name="sensor_crosstalk",
    port=Port.SENSOR,
    components=RANGES,
    parameters=(Parameter("curvature", "1/m", -2.0, 2.0, typical=0.03),),
    operate=_operate,
    says=lambda component, v: (
        f"{component} reads {'long' if v['curvature'] > 0.0 else 'short'} by"
        f" {10.0 * abs(v['curvature']):.2g} mm at 100 mm, and by four times that at twice the"
        " distance"
    ),
    # where a motion tells neither from an offset, the offset is likelier
    penalty=1.5,
    pose_alone=True,
)

CARD = EffectCard(
    name=EFFECT.name,
    kind=EFFECT,
    listed=2,
    on={"range": EFFECT},
    log_odds={
        # needs a cover glass, or a cone that meets more than its target
        "range/crosstalk": -2.5,
    },
    words=Words(
        noun="an error of {part} that grows with the distance squared",
        several="errors of {part} that grow with the distance squared",
        regime="with the square of the distance",
        axis_regime="with the square of the distance",
        axis_part="the sensor",
    ),
    remedies={
        "": "clean the window of {part}, or move it: its error grows with distance",
        "sensor/": (
            "look for what {part} sees beside its target (a dirty window, reflections): its error "
            "grows with the distance squared"
        ),
    },
    drawing=Drawing(axis=("sensor",)),
    traits=frozenset({Trait.BY_DISTANCE, Trait.READING, Trait.SIGNED, Trait.WARMS}),
    rule=Rule.SUM,
    compensated=Compensated.IN_READINGS,
)
