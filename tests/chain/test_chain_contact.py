"""The stop against calculations by hand: one sample a line, x, y, z in millimetres."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from deltactl.models.chain.active import activate
from deltactl.models.effects import effect_kind
from deltactl.models.effects.flow import Flow, Load


def stopped(sent_mm: list[tuple[float, float, float]], grip: float, height_mm: float = 0.0):
    """Where the platform comes to be, shape (n, 3) [mm]."""
    n = len(sent_mm)
    flow = Flow(
        t_s=0.02 * np.arange(n), fresh=np.arange(n) == 0, start_s=0.0,
        angles_rad=np.zeros((n, 3)), load_of=lambda: Load(np.zeros((n, 3)), np.zeros((n, 3))),
    )  # fmt: skip
    flow.position_m = 1e-3 * np.array(sent_mm, dtype=float)
    sizes = {"height": 1e-3 * height_mm, "grip": grip}
    activate(effect_kind("contact"), "platform", sizes).act(flow)
    return 1e3 * flow.position_m


DOWN = [(0.0, 0.0, 2.0), (2.0, 0.0, -2.0), (4.0, 0.0, -4.0), (20.0, 0.0, -4.0), (20.0, 0.0, 1.0)]


def test_a_smooth_stop_lets_it_slide() -> None:
    np.testing.assert_allclose(
        stopped(DOWN, 0.0), [(x, y, max(z, 0.0)) for x, y, z in DOWN], atol=1e-9
    )


def test_a_rough_stop_holds_it_where_it_touched() -> None:
    """It touches half-way between the first two samples, at x = 1 mm."""
    at = stopped(DOWN, 100.0)
    np.testing.assert_allclose(at[1:4], [(1.0, 0.0, 0.0)] * 3, atol=1e-9)
    np.testing.assert_allclose(at[4], DOWN[4], atol=1e-9)


def test_it_slips_when_it_is_pulled_too_far() -> None:
    """Pressed in by 4 mm with grip 1.5 it may lag behind by 6 mm."""
    at = stopped(DOWN, 1.5)
    np.testing.assert_allclose(at[2], (1.0, 0.0, 0.0), atol=1e-9)
    np.testing.assert_allclose(at[3], (14.0, 0.0, 0.0), atol=1e-9)


@given(
    st.lists(st.tuples(*[st.floats(-50, 50)] * 3), min_size=1, max_size=30),
    st.floats(0, 5),
)
def test_it_never_lags_by_more_than_the_grip_allows(
    sent_mm: list[tuple[float, float, float]], grip: float
) -> None:
    at, sent = stopped(sent_mm, grip), np.array(sent_mm)
    assert (at[:, 2] >= -1e-9).all()
    behind = np.hypot(*(at - sent)[:, :2].T)
    assert (behind <= grip * np.maximum(-sent[:, 2], 0.0) + 1e-6).all()


def test_it_says_whether_it_holds() -> None:
    kind = effect_kind("contact")
    assert "sideways" not in kind.sentence("platform", {"height": -0.5, "grip": 0.0})
    assert "sideways" in kind.sentence("platform", {"height": -0.5, "grip": 1.0})
    assert pytest.approx(0.0) == kind.parameters[1].default
