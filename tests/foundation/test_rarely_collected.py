"""Garbage is collected seldom within, and as before afterwards."""

from __future__ import annotations

import gc
import weakref

import pytest

from deltactl.foundation.process import SELDOM, rarely_collected


@rarely_collected
def _looked_at(fails: bool = False) -> tuple[tuple[int, int, int], int]:
    if fails:
        raise ValueError("on purpose")
    return gc.get_threshold(), gc.get_freeze_count()


def test_within_it_what_was_there_before_is_left_out() -> None:
    before = gc.get_threshold()
    threshold, frozen = _looked_at()
    assert threshold == SELDOM
    assert frozen > 1000
    assert gc.get_threshold() == before
    assert gc.get_freeze_count() < frozen


def test_afterwards_all_is_as_before_whatever_was_raised() -> None:
    before = gc.get_threshold()
    with pytest.raises(ValueError, match="on purpose"):
        _looked_at(fails=True)
    assert gc.get_threshold() == before


def test_what_the_work_leaves_in_cycles_is_collected_at_its_end() -> None:
    class Plant:
        def __init__(self) -> None:
            self.itself = self

    @rarely_collected
    def work() -> weakref.ref[Plant]:
        return weakref.ref(Plant())

    assert work()() is None
