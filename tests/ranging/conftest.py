"""What the tests of this folder stand on: one simulated chip, and a started set of three."""

from __future__ import annotations

import pytest

from deltactl.drivers.fakes.ranging_bench import ChipBench, RangingBench


@pytest.fixture
def bench() -> RangingBench:
    """A started bench without noise."""
    made = RangingBench()
    made.bank.start()
    return made


@pytest.fixture
def one() -> ChipBench:
    """One chip without noise, just released from reset."""
    return ChipBench()
