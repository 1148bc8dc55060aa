"""A model that cannot be assembled everywhere is a bad fit that the search finds its way out of."""

from __future__ import annotations

import numpy as np

from deltactl.models.chain.delta import standing


def test_the_platform_stands_where_it_last_was() -> None:
    rows = np.array([[np.nan, 1.0], [1.0, 2.0], [np.nan, np.nan], [np.nan, 5.0], [3.0, 4.0]])
    expected = [[1.0, 2.0], [1.0, 2.0], [1.0, 2.0], [1.0, 2.0], [3.0, 4.0]]
    np.testing.assert_array_equal(standing(rows), expected)


def test_whole_rows_stay_as_they_are() -> None:
    rows = np.arange(6.0).reshape(3, 2)
    np.testing.assert_array_equal(standing(rows), rows)
