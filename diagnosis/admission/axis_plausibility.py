"""Recordings of a lone axis from which nothing can be told get one line, never a diagnosis."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from diagnosis.answer.records import Finding, Fit
from diagnosis.plants.contract import Model
from foundation.errors import RecordingError

SHORTEST_S, LONGEST_S = 2e-5, 5.0
HOPELESS = 0.5
"""Left over, as a share of how much the reading moves, with the best explanation."""
AGAINST = -0.5
FACTOR = 20.0


def check_times(model: Model, source: str) -> None:
    """Refuse times that are no seconds. Raises RecordingError."""
    period_s = model.readings.period_s
    if not SHORTEST_S <= period_s <= LONGEST_S:
        raise RecordingError(
            f"{source}: samples are {period_s:g} s apart; t must be in seconds (is it in ms?)"
        )


def check_direction(model: Model, source: str) -> None:
    """Refuse a reading that runs against what it should follow. Raises RecordingError."""
    valid = model.readings.valid[:, 0]
    expected = model.predict([n.term for n in model.nuisances])[valid, 0]
    seen = model.readings.values[valid, 0]
    if len(seen) > 2 and np.ptp(expected) > 0.0 and np.ptp(seen) > 0.0:
        alike = float(np.corrcoef(expected, seen)[0, 1])
        if alike < AGAINST:
            raise RecordingError(
                f"{source}: {model.readings.names[0]} moves against its command (correlation "
                f"{alike:.2f}); is a sign or a column wrong?"
            )


def check_outcome(
    model: Model, fit: Fit, found: Sequence[Finding], inertia: float | None, source: str
) -> None:
    """Refuse what only another machine's file or other units explain. Raises RecordingError."""
    observed = model.readings.values[model.readings.valid[:, 0], 0]
    span = float(np.std(observed))
    moved = float(np.std(model.predict([n.term for n in model.nuisances])))
    hopeless = bool(found) and moved > 0.1 * span
    far = min(fit.rms_before_m, fit.rms_after_m) > HOPELESS * span
    if hopeless and far:
        raise RecordingError(
            f"{source}: recording and robot file do not belong together: {fit.rms_before_m:.3g} "
            f"{fit.unit} apart in a motion of {span:.3g} {fit.unit}, and {fit.rms_after_m:.3g} "
            "with the best explanation; are columns, units or the robot file another machine's?"
        )
    for finding in found:
        size = finding.parameters.get("inertia") or finding.parameters.get("scale")
        if size is None or finding.effect not in ("inertia", "effort_gain"):
            continue
        believed = inertia if finding.effect == "inertia" and inertia else 1.0
        ratio = size.components[0][0] / believed
        if not 1.0 / FACTOR < ratio < FACTOR:
            raise RecordingError(
                f"{source}: {finding.effect} would have to be {ratio:.3g} times what the robot "
                "file says; are the units of effort or inertia wrong?"
            )
