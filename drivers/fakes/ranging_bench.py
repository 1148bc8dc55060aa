"""Three simulated sensors in front of targets that can be moved, on a virtual clock.

For tests and benchmarks: time passes only in `run` and `run_until`.
"""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

from deltactl.drivers.fakes.range_noise import RangeNoise
from deltactl.drivers.fakes.ranging_rig import RangingRig, build_rig
from deltactl.drivers.fakes.vl53l1x_chip import Vl53l1xChip
from deltactl.drivers.ranging.bank import SensorBank
from deltactl.drivers.ranging.contract import Reading
from deltactl.drivers.settings import RangingSettings
from deltactl.foundation.clock import NS_PER_S, VirtualClock, ns

TARGETS_M = {"x": 0.30, "y": 0.45, "z": 0.60}
NO_NOISE = RangeNoise(sigma_m=0.0)


class RangingBench:
    """The sensors, not yet started. `true_m` is where the target of each axis stands."""

    def __init__(
        self,
        settings: RangingSettings | None = None,
        noise: RangeNoise = NO_NOISE,
        **rig_options: Any,
    ):
        """`rig_options` are those of `build_rig`."""
        self.settings = RangingSettings() if settings is None else settings
        self.clock = VirtualClock()
        self.true_m = dict(TARGETS_M)
        self.rig: RangingRig = build_rig(
            self.settings, self.clock, self._distance_m, noise, **rig_options
        )

    @property
    def bank(self) -> SensorBank:
        """The driver."""
        return self.rig.bank

    @property
    def chips(self) -> dict[str, Vl53l1xChip]:
        """The chips by axis."""
        return self.rig.chips

    @property
    def now_s(self) -> float:
        """Time on the virtual clock."""
        return self.clock.now_ns() / NS_PER_S

    def run(self, duration_s: float, period_s: float = 0.02) -> list[Reading]:
        """Poll for a while; all readings that came."""
        readings = []
        until_ns = self.clock.now_ns() + ns(duration_s)
        while self.clock.now_ns() < until_ns:
            self.clock.sleep_until_ns(self.clock.now_ns() + ns(period_s))
            readings += self.bank.poll()
        return readings

    def run_until(self, done: Callable[[], bool], limit_s: float = 10.0) -> float:
        """Poll until something holds; the seconds it took. Raises TimeoutError."""
        start_s = self.now_s
        while not done():
            self.run(0.02)
            if self.now_s - start_s > limit_s:
                raise TimeoutError(f"not within {limit_s:g} s: {self.bank.health()}")
        return self.now_s - start_s

    def well(self) -> bool:
        """Whether all three sensors say ok."""
        return set(self.bank.health().values()) == {"ok"}

    def _distance_m(self, axis: str, start_ns: int, end_ns: int) -> float:
        return self.true_m[axis]
