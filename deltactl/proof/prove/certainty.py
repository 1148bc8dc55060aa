"""How sure a share or a median from so many cases is."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

Z95 = 1.959963984540054


def wilson(hits: int, cases: int, z: float = Z95) -> tuple[float, float]:
    """95 % limits of a share (Wilson 1927, J. Am. Stat. Assoc. 22, 209); (0, 1) for no cases."""
    if cases == 0:
        return 0.0, 1.0
    share, room = hits / cases, z**2 / cases
    middle = (share + 0.5 * room) / (1.0 + room)
    half = z * np.sqrt(share * (1.0 - share) / cases + 0.25 * room / cases) / (1.0 + room)
    return max(0.0, float(middle - half)), min(1.0, float(middle + half))


def median_limits(values: Sequence[float], draws: int = 2000) -> tuple[float, float]:
    """95 % limits of a median by the bootstrap, always with the same draws."""
    if not values:
        return float("nan"), float("nan")
    rng = np.random.default_rng(0)
    array = np.asarray(values, dtype=float)
    medians = np.median(array[rng.integers(0, len(array), (draws, len(array)))], axis=1)
    low, high = np.quantile(medians, [0.025, 0.975])
    return float(low), float(high)
