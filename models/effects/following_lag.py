"""The drive follows late: a pure delay, then a first-order lag."""

from __future__ import annotations

from deltactl.models.effects.flow import Flow
from deltactl.models.effects.kind import (
    MOTORS,
    Discrepancy,
    EffectKind,
    Memory,
    Parameter,
    Values,
    joints,
    scalar,
)
from deltactl.models.effects.port import Port


def _operate(flow: Flow, index: int, values: Values, memory: Memory) -> None:
    part = joints(index)
    dead_s, lag_s = scalar(values, "dead_time"), scalar(values, "time")
    flow.angles_rad[:, part] = flow.behind(flow.angles_rad[:, part], dead_s, lag_s, memory)
    if flow.smooth:
        flow.late_s += lag_s


EFFECT = EffectKind(
    name="following_lag",
    port=Port.MOTOR,
    components=MOTORS,
    parameters=(
        Parameter("time", "s", 0.0, 2.0, starts=(0.02,), step=1e-3, typical=0.05),
        Parameter("dead_time", "s", 0.0, 2.0, starts=(0.0,), step=1e-3, default=0.0, typical=0.05),
    ),
    operate=_operate,
    says=lambda component, v: (
        f"{component} follows its command late, with a time constant of {1e3 * v['time']:.3g} ms"
        + (f" after a dead time of {1e3 * v['dead_time']:.3g} ms" if v["dead_time"] else "")
    ),
    # a drive is not of first order
    discrepancy=Discrepancy(0.001, 0.003),
)
