"""Names beside unknown physics: the more of them, and the nearer, the likelier they imitate it."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from deltactl.diagnosis.selection.imitation import _along, chances
from deltactl.diagnosis.selection.options import CREDIBLE

shares = st.lists(st.floats(0.0, 1.0), min_size=1, max_size=8)


@given(shares, st.floats(0.0, CREDIBLE.same_place))
def test_another_name_elsewhere_makes_none_of_them_likelier(
    of_names: list[float], more: float
) -> None:
    before, after = chances(of_names), chances([*of_names, more])
    assert all(new <= old for old, new in zip(before, after[:-1], strict=True))
    assert all(0.0 < one < 1.0 for one in after)


def test_one_name_elsewhere_is_probably_a_cause_of_its_own_and_a_pile_is_not() -> None:
    assert chances([0.0])[0] > 0.5
    assert chances([0.0] * 4)[0] < 0.5
    assert chances([1.0, 0.0])[0] < 0.1 < chances([1.0, 0.0])[1]


def test_what_lies_along_a_place_is_counted_row_by_row() -> None:
    angle = np.linspace(0.0, 3.0, 50)
    direction = np.stack([np.cos(angle), np.sin(angle)], axis=1)
    across = np.stack([-np.sin(angle), np.cos(angle)], axis=1)
    size = np.linspace(1.0, 2.0, 50)[:, None]
    assert _along(size * direction, 3.0 * direction) == pytest.approx(np.sum(size**2))
    assert _along(size * across, direction) == pytest.approx(0.0, abs=1e-12)
    assert _along(size * direction, np.zeros((50, 2))) == 0.0
