"""Gates: what a good distance is, and what becomes of a jump."""

from __future__ import annotations

import pytest

from deltactl.drivers.ranging.contract import Gate
from deltactl.drivers.ranging.sample_reader import BELIEVED_AFTER, Gatekeeper
from deltactl.drivers.ranging.vl53l1x import RawSample
from deltactl.drivers.settings import RangingSettings
from deltactl.foundation.clock import ns

PERIOD_NS = ns(0.02)


def _sample(distance_mm: int = 300, signal_mcps: float = 20.0, sigma_mm: float = 2.0) -> RawSample:
    return RawSample(9, 5, distance_mm, signal_mcps, 0.1, sigma_mm, 128.0)


class Gated:
    """Feeds distances, one a period."""

    def __init__(self) -> None:
        self.keeper = Gatekeeper(RangingSettings())
        self.t_ns = 0

    def see(self, *distances_mm: int, status: int = 0) -> list[Gate]:
        gates = []
        for distance_mm in distances_mm:
            self.t_ns += PERIOD_NS
            gates.append(self.keeper.judge(_sample(distance_mm), status, self.t_ns))
        return gates


@pytest.mark.parametrize(
    ("sample", "status", "gate"),
    [
        (_sample(), 0, Gate.GOOD),
        (_sample(), 4, Gate.STATUS),
        (_sample(), 6, Gate.STATUS),
        (_sample(), 255, Gate.STATUS),
        (_sample(signal_mcps=0.5), 0, Gate.GOOD),
        (_sample(signal_mcps=0.49), 0, Gate.SIGNAL),
        (_sample(sigma_mm=30.0), 0, Gate.GOOD),
        (_sample(sigma_mm=30.25), 0, Gate.SIGMA),
    ],
)
def test_status_signal_and_sigma_are_gated(sample: RawSample, status: int, gate: Gate) -> None:
    assert Gatekeeper(RangingSettings()).judge(sample, status, 0) is gate


def test_slow_motion_passes_however_far_it_goes() -> None:
    assert set(Gated().see(*range(300, 900, 90))) == {Gate.GOOD}


def test_a_single_outlier_is_a_jump_and_leaves_no_trace() -> None:
    gates = Gated().see(300, 301, 25, 302, 303)
    assert gates == [Gate.GOOD, Gate.GOOD, Gate.JUMP, Gate.GOOD, Gate.GOOD]


def test_outliers_that_disagree_are_never_believed() -> None:
    assert Gated().see(300, 25, 900, 26, 901, 300) == [Gate.GOOD, *[Gate.JUMP] * 4, Gate.GOOD]


def test_a_jump_that_stays_is_believed() -> None:
    gates = Gated().see(300, *[600] * (BELIEVED_AFTER + 1))
    assert gates == [Gate.GOOD, *[Gate.JUMP] * (BELIEVED_AFTER - 1), Gate.GOOD, Gate.GOOD]


def test_a_distance_too_old_is_nothing_to_compare_with() -> None:
    gated = Gated()
    gated.see(300)
    gated.t_ns += ns(RangingSettings().maximum_age_s)
    assert gated.see(600) == [Gate.GOOD]


def test_a_refused_sample_is_nothing_to_compare_with() -> None:
    gated = Gated()
    assert gated.see(300, status=4) == [Gate.STATUS]
    assert gated.see(600) == [Gate.GOOD]


def test_after_a_restart_nothing_is_remembered() -> None:
    gated = Gated()
    gated.see(300)
    gated.keeper.forget()
    assert gated.see(600) == [Gate.GOOD]


def test_a_jump_that_goes_on_as_far_as_a_step_may_be_is_believed() -> None:
    step_mm = int(RangingSettings().maximum_jump_mm)
    ways = [300, *(301 + step_mm * number for number in (1, 2, 3))]
    assert Gated().see(*ways) == [Gate.GOOD, Gate.JUMP, Gate.JUMP, Gate.GOOD]
    assert Gated().see(300, 300 + step_mm) == [Gate.GOOD, Gate.GOOD]
