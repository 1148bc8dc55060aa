"""A joint of a chain is at another place, or turned otherwise, than its model says."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

import numpy as np

from deltactl.models.effects.card import (
    Compensated,
    Confusion,
    Drawing,
    EffectCard,
    Rule,
    Trait,
    Words,
)
from deltactl.models.effects.units_in_use import said

OFF = ("dx", "dy", "dz", "rx", "ry", "rz")
"""Shift [m] and turn [rad] of the fixed transform before a joint, in the frame of the link before
it."""


def says(component: str, values: Mapping[str, Any]) -> str:
    """How far a joint is off, and how far it is turned."""
    off = np.array([float(values.get(name, 0.0)) for name in OFF])
    shift = ", ".join(f"{1e3 * x:.3g}" for x in off[:3])
    turn = ", ".join(f"{1e3 * x:.3g}" for x in off[3:])
    return (
        f"{component} is {said(float(np.linalg.norm(off[:3])), 'm')} off its place in the model"
        f" ({shift} mm along x, y, z of the link before it) and turned by ({turn}) mrad"
    )


CARD = EffectCard(
    name="link_geometry",
    log_odds={
        # castings are bolted together to a few tenths of a millimetre
        "pose/geometry": -1.0,
    },
    words=Words(
        noun="a wrong place or direction of {part} in the model",
        several="wrong places or directions of {part} in the model",
        further="a further wrong place or direction of {part}",
        regime="everywhere, with the pose",
        axis_regime="everywhere, with the pose",
    ),
    remedies={
        "": (
            "write the place and direction of {part} into the model (`--save-robot`, then "
            "`deltactl export`), or into the controller's own calibration"
        ),
    },
    drawing=Drawing(everywhere=("link",)),
    traits=frozenset({Trait.ENTERED}),
    rule=Rule.EACH,
    compensated=Compensated.INVERSE,
    confusions=(
        Confusion(
            "home_offset",
            axis="measure poses with {part} turned further, and the tool's orientation",
        ),
    ),
)
