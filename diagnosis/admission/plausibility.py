"""Recordings from which nothing can be told get one clear line, never a confident diagnosis."""

from __future__ import annotations

import numpy as np

from diagnosis.plants.contract import Model
from foundation.errors import RecordingError

UNIT_FACTOR = 20.0
FEWEST_VALID = 30
FEWEST_IN_ALL = 90
"""Valid readings of one channel, and of all together, below which nothing is told."""
STANDS_STILL = 1e-4


def check_input(model: Model) -> None:
    """Refuse what cannot be right. Raises RecordingError."""
    readings = model.readings
    if not 1e-4 <= readings.period_s <= 5.0:
        raise RecordingError(
            f"samples are {readings.period_s:g} s apart; t must be in seconds (is it in ms?)"
        )
    counts = readings.valid.sum(axis=0)
    if counts.max() < FEWEST_VALID or counts.sum() < FEWEST_IN_ALL:
        raise RecordingError(
            f"only {int(counts.max())} valid readings in any of {', '.join(readings.names)}; "
            f"nothing can be told from fewer than {FEWEST_VALID} of one and {FEWEST_IN_ALL} of all"
        )
    predicted = model.predict([n.term for n in model.nuisances])
    moved = np.ptp(predicted, axis=0)
    if moved.max() < STANDS_STILL:
        raise RecordingError("nothing moves in this recording; nothing can be told from it")
    for column, name in enumerate(readings.names):
        good = readings.valid[:, column]
        if good.sum() < FEWEST_VALID:
            continue
        seen, expected = readings.values[good, column], predicted[good, column]
        if np.ptp(seen) == 0.0 and np.ptp(expected) > 100 * STANDS_STILL:
            raise RecordingError(
                f"{name} never changes (always {seen[0]:g}) though the platform moves; "
                "is the sensor dead or the column wrong?"
            )
        ratio = np.median(np.abs(seen)) / max(float(np.median(np.abs(expected))), 1e-9)
        if ratio > UNIT_FACTOR or (
            ratio < 1.0 / UNIT_FACTOR and np.median(np.abs(expected)) > STANDS_STILL
        ):
            unit = readings.units[column]
            raise RecordingError(
                f"{name} is about {ratio:.3g} times what robot and commands give; "
                f"it must be in {unit} (is it in m{unit}, or is this another robot's file?)"
            )
