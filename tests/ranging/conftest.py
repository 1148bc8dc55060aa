"""A simulated set of sensors for the tests of this folder, and ways to let time pass."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, field

import pytest

from drivers.fakes.range_noise import RangeNoise
from drivers.fakes.ranging_rig import RangingRig, build_rig
from drivers.ranging.contract import Reading
from drivers.settings import RangingSettings
from foundation.clock import VirtualClock, ns

TRUE_M = {"x": 0.30, "y": 0.45, "z": 0.60}


@dataclass
class Bench:
    """Three simulated sensors on a virtual clock, in front of targets that tests can move."""

    clock: VirtualClock
    rig: RangingRig
    settings: RangingSettings
    true_m: dict[str, float] = field(default_factory=lambda: dict(TRUE_M))

    def run(self, duration_s: float, period_s: float = 0.02) -> list[Reading]:
        """Poll for a while; all readings that came."""
        readings = []
        until_ns = self.clock.now_ns() + ns(duration_s)
        while self.clock.now_ns() < until_ns:
            self.clock.sleep_until_ns(self.clock.now_ns() + ns(period_s))
            readings += self.rig.bank.poll()
        return readings

    def run_until(self, done: Callable[[], bool], limit_s: float = 10.0) -> float:
        """Poll until something holds; the seconds it took."""
        start_ns = self.clock.now_ns()
        while not done():
            self.run(0.02)
            assert self.clock.now_ns() - start_ns < ns(limit_s), "it never happened"
        return (self.clock.now_ns() - start_ns) / 1e9

    def well(self) -> bool:
        """Whether all three sensors say ok."""
        return set(self.rig.bank.health().values()) == {"ok"}


MakeBench = Callable[..., Bench]


@pytest.fixture
def make_bench() -> MakeBench:
    """Build a bench: keyword arguments of build_rig, and `settings`."""

    def make(settings: RangingSettings | None = None, **kwargs: object) -> Bench:
        clock = VirtualClock()
        chosen = RangingSettings() if settings is None else settings
        true_m = dict(TRUE_M)
        kwargs.setdefault("noise", RangeNoise(sigma_m=0.0))
        rig = build_rig(chosen, clock, lambda axis, start, end: true_m[axis], **kwargs)
        return Bench(clock, rig, chosen, true_m)

    return make


@pytest.fixture
def bench(make_bench: MakeBench) -> Bench:
    """A started bench without noise."""
    made = make_bench()
    made.rig.bank.start()
    return made
