"""Recordings from which nothing can be told get one clear line, never a confident diagnosis."""

from __future__ import annotations

import numpy as np

from deltactl.diagnosis.admission.options import ADMISSION
from deltactl.diagnosis.plants.contract import Model
from deltactl.foundation.errors import RecordingError


def check_input(model: Model) -> None:
    """Refuse what cannot be right. Raises RecordingError."""
    readings = model.readings
    if not 1e-4 <= readings.period_s <= 5.0:
        raise RecordingError(
            f"samples are {readings.period_s:g} s apart; t must be in seconds (is it in ms?)"
        )
    counts = readings.valid.sum(axis=0)
    if counts.max() < ADMISSION.fewest_valid or counts.sum() < ADMISSION.fewest_in_all:
        raise RecordingError(
            f"only {int(counts.max())} valid readings in any of {', '.join(readings.names)}; "
            f"nothing can be told from fewer than {ADMISSION.fewest_valid} of one and "
            f"{ADMISSION.fewest_in_all} of all"
        )
    predicted = model.predict([n.term for n in model.nuisances])
    moved = np.ptp(predicted, axis=0)
    if moved.max() < ADMISSION.stands_still:
        raise RecordingError("nothing moves in this recording; nothing can be told from it")
    sizes = np.median(np.abs(predicted), axis=0)
    for column, name in enumerate(readings.names):
        good = readings.valid[:, column]
        if good.sum() < ADMISSION.fewest_valid:
            continue
        seen, expected = readings.values[good, column], predicted[good, column]
        if np.ptp(seen) == 0.0 and np.ptp(expected) > 100 * ADMISSION.stands_still:
            raise RecordingError(
                f"{name} never changes (always {seen[0]:g}) though the platform moves; "
                "is the sensor dead or the column wrong?"
            )
        unit, size = readings.units[column], float(np.median(np.abs(seen)))
        usual = float(np.median(np.abs(expected)))
        alike = float(sizes[[other == unit for other in readings.units]].max())
        if _another_unit(size, usual, alike):
            times = size / max(usual, 1e-9)
            raise RecordingError(
                f"{name} is about {times:.3g} times what robot and commands give; "
                f"it must be in {unit} (is it in m{unit}, or is this another robot's file?)"
            )


def _another_unit(size: float, usual: float, alike: float) -> bool:
    """Whether readings are so much larger or smaller than is usual that their unit is another.

    alike: the largest of what is usually expected of channels in this unit. Of a platform that
    only moves up and down, x and y are noise about 0: no size can be expected of them.
    """
    if size < usual / ADMISSION.unit_factor:
        return usual > ADMISSION.stands_still
    return size > ADMISSION.unit_factor * alike
