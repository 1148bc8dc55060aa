"""No claim of a delta's search is surer than the chance that the search itself went wrong."""

from __future__ import annotations

import pytest
from hypothesis import given
from hypothesis import strategies as st

from deltactl.diagnosis.selection.credible_set import _Weights
from deltactl.diagnosis.selection.options import CREDIBLE

weights = st.floats(0.0, 1e30)


@given(st.lists(weights, max_size=6), weights)
def test_a_claim_leaves_room_for_a_lapse_and_its_rivals(
    alternatives: list[float], none: float
) -> None:
    compared = _Weights(costs=[0.0], alternatives=[alternatives], none=[none])
    (alone,) = compared.of_terms([1.0])
    assert alone <= 1.0 - CREDIBLE.lapse
    assert alone <= (1.0 - CREDIBLE.lapse) / (1.0 + max([none, *alternatives])) * (1.0 + 1e-12)
    (beside_unknown,) = compared.of_terms([0.7])
    assert beside_unknown == pytest.approx(0.7 * alone)
