"""Which distances may be used: status, signal, sigma, and no jumps (status 0 is not proof).

stm32duino/VL53L1X#7: short mode returned 22 to 27 mm for a target at 1.8 m with status 0.
"""

from __future__ import annotations

from deltactl.drivers.ranging.contract import Gate
from deltactl.drivers.ranging.sample import RawSample
from deltactl.drivers.ranging.status import RANGE_VALID
from deltactl.drivers.settings import RangingSettings
from deltactl.foundation.clock import ns

BELIEVED_AFTER = 3
"""So many readings in a row that agree with each other make a jump a fact."""


class Gatekeeper:
    """Judges the samples of one sensor; a jump is measured from its last good distance."""

    def __init__(self, settings: RangingSettings):
        self._settings = settings
        self._memory_ns = ns(settings.maximum_age_s)
        self._good: tuple[int, float] | None = None
        self._landed_mm = 0.0
        self._landings = 0

    def forget(self) -> None:
        """The sensor was restarted: nothing to compare with."""
        self._good = None
        self._landings = 0

    def judge(self, sample: RawSample, status: int, t_ns: int) -> Gate:
        """The first gate that a sample does not pass, or GOOD."""
        settings = self._settings
        if status != RANGE_VALID:
            return Gate.STATUS
        if sample.signal_mcps < settings.minimum_signal_mcps:
            return Gate.SIGNAL
        if sample.sigma_mm > settings.maximum_sigma_mm:
            return Gate.SIGMA
        if self._jumped(float(sample.distance_mm), t_ns):
            return Gate.JUMP
        self._good = (t_ns, float(sample.distance_mm))
        self._landings = 0
        return Gate.GOOD

    def _jumped(self, distance_mm: float, t_ns: int) -> bool:
        if self._good is None or t_ns - self._good[0] > self._memory_ns:
            return False
        limit_mm = self._settings.maximum_jump_mm
        if abs(distance_mm - self._good[1]) <= limit_mm:
            return False
        again = self._landings > 0 and abs(distance_mm - self._landed_mm) <= limit_mm
        self._landings = self._landings + 1 if again else 1
        self._landed_mm = distance_mm
        return self._landings < BELIEVED_AFTER
