"""The platform rings after moves like a mass on a damped spring, alike in all directions."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from deltactl.models.effects.card import (
    Compensated,
    Coordinate,
    Drawing,
    EffectCard,
    Fit,
    Shape,
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
from deltactl.models.linkage.vectors import cosine_and_sine
from deltactl.models.signals import linear

FASTEST_DECAY = 0.999


def _operate(flow: Flow, index: int, values: Values, memory: Memory) -> None:
    """One complex pole: y = x + Re(z), z' = pole z - share x'."""
    omega = 2.0 * np.pi * max(scalar(values, "frequency"), 1e-3)
    damping = float(np.clip(scalar(values, "damping"), 0.0, FASTEST_DECAY))
    pole = omega * complex(-damping, np.sqrt(1.0 - damping**2))
    # The error e = y - x obeys e'' + 2 d w e' + w^2 e = -x'' (the damper moves along with x).
    # Its answer to a unit of x' is -Re(share exp(pole t)); x' is constant between samples.
    share = 1.0 + 1j * damping / np.sqrt(1.0 - damping**2)
    x, step = flow.position_m, flow.step_s
    before = np.vstack([memory.get("x", x[0])[None, :], x[:-1]])
    cosine, sine = cosine_and_sine(pole.imag * step)
    decay = np.exp(pole.real * step) * (cosine + 1j * sine)
    kept = np.where(step > 0.0, (decay - 1.0) / (pole * np.maximum(step, 1e-12)), 0.0)
    moved = np.where((step > 0.0)[:, None], x - before, 0.0)
    gain = np.where(step > 0.0, decay, 0.0)
    state = linear(gain, -(share * kept)[:, None] * moved, memory.get("z", np.zeros(3, complex)))
    memory["x"], memory["z"] = x[-1].copy(), state[-1].copy()
    flow.position_m = x + state.real


EFFECT = EffectKind(
    name="resonance",
    port=Port.PLATFORM,
    components=("platform",),
    parameters=(
        Parameter("frequency", "Hz", 0.3, 40.0, starts=(1.5, 3.0, 6.0, 10.0), step=0.02, spread=1),
        Parameter("damping", "1", 0.005, 0.95, starts=(0.05, 0.2), step=0.01, spread=0.2),
    ),
    operate=_operate,
    says=lambda component, v: (
        f"the platform rings at {v['frequency']:.2f} Hz after moves, "
        f"with a damping of {v['damping']:.2f}"
    ),
    smooth=False,
    nothing=float("inf"),
    # one mode of many
    discrepancy=Discrepancy(0.001, 0.012),
    itself={"damping": (0.0, 0.4)},  # beyond it a spring is still before it has swung back
)


def _on_axis(flow: Flow, index: int, values: Values, memory: Memory) -> None:
    flow.position_m = np.repeat(flow.angles_rad[:, :1], 3, axis=1)
    _operate(flow, index, values, memory)
    flow.angles_rad = flow.position_m[:, :1].copy()


ON_AXIS = replace(
    EFFECT,
    port=Port.ARM,
    components=("axis",),
    operate=_on_axis,
    says=lambda component, v: (
        f"the axis rings at {v['frequency']:.2f} Hz after moves, with a damping of "
        f"{v['damping']:.2f}"
    ),
    order=5,
)

CARD = EffectCard(
    name=EFFECT.name,
    kind=EFFECT,
    listed=1,
    on={"command": ON_AXIS},
    says={
        "": "the axis rings at {frequency} after moves, with a damping of {damping}",
    },
    log_odds={
        # frames ring for longer than a sample in light or tall machines only
        "command/ringing": -4.0,
    },
    words=Words(
        noun="ringing of {part} after moves",
        regime="after starts and stops",
        axis_regime="after starts and stops",
    ),
    remedies={
        "": "accelerate more gently, or stiffen the frame: it rings at {size}",
        "slide/": (
            "accelerate more gently, tension the belt, or stiffen the frame: it rings at {size}"
        ),
    },
    drawing=Drawing(axis=("load",)),
    traits=frozenset({Trait.RINGING}),
    compensated=Compensated.SHAPED,
    fit=Fit(
        coordinates=(
            Coordinate("frequency", "log", step=0.01, low=np.log(0.3), high=np.log(40.0)),
            Coordinate("damping", step=0.01, low=0.005, high=0.95),
        ),
        # Each 1.6 times the one before: from a cable that swings to what 50 readings a second still
        # show; a bolted frame, and one that is held by hand or rubber.
        shapes=tuple(
            Shape((float(np.log(hertz)), damping), ())
            for hertz in (0.7, 1.2, 2.0, 3.2, 5.0, 8.0, 12.0, 18.0)
            for damping in (0.05, 0.2)
        ),
    ),
)
