"""Second difference over time within stretches."""

from __future__ import annotations

import numpy as np

from models.effects.flow import BoolArray
from models.robot import FloatArray


def second_difference(x: FloatArray, fresh: BoolArray) -> FloatArray:
    """x[k-1] - 2 x[k] + x[k+1] of each column of x (n, m); 0 at both ends of a stretch."""
    bend = np.zeros_like(x)
    bend[1:-1] = x[:-2] - 2.0 * x[1:-1] + x[2:]
    bend[fresh] = 0.0
    bend[:-1][fresh[1:]] = 0.0
    return bend
