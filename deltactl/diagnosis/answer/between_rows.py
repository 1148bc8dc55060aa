"""What a recording does not say of a delay: what was commanded between its rows.

In: findings, and how far rows are apart. Out: the same, with wider intervals. A chain takes
commands as straight from row to row; a real one bends between them, and a straight course, delayed
by a part of a row and smoothed, lags by less time constant and more dead time than the bent one.
Their sum is the same.
"""

from __future__ import annotations

import math

from deltactl.diagnosis.answer.finding import Finding, ParameterResult
from deltactl.models.effects import Trait, has

SMEARED = 1.0 / 4.0 + 1.0 / 4.0
"""Most that straight lines add to the variance of a delay, in squared row distances: f (1 - f) of a
dead time that ends at a part f of a row, and twice the eighth by which a chord misses a bend."""


def as_far_as_rows_tell(finding: Finding, period_s: float) -> Finding:
    """A delay with both its parts as uncertain as rows so far apart [s] leave them."""
    time, dead = (finding.parameters.get(name) for name in ("time", "dead_time"))
    if not has(finding.effect, Trait.DRIVE_DELAY) or time is None or dead is None:
        return finding
    if len(time.components) != 1 or len(dead.components) != 1:
        return finding
    value_s, low_s, high_s = time.components[0]
    _, dead_low_s, dead_high_s = dead.components[0]
    slack_s = math.hypot(value_s, math.sqrt(SMEARED) * period_s) - value_s
    slack_s = min(slack_s, max(dead_high_s, 0.0))  # their sum stays, and no dead time is below 0
    wider = {
        "time": _between(time, low_s, high_s + slack_s),
        "dead_time": _between(dead, min(dead_low_s, max(dead_low_s - slack_s, 0.0)), dead_high_s),
    }
    return finding.model_copy(update={"parameters": {**finding.parameters, **wider}})


def _between(result: ParameterResult, low: float, high: float) -> ParameterResult:
    return result.model_copy(update={"ci95": [low, high]})
