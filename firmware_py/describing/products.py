"""Numbers as people type them: also as a product or a quotient, 1.17*9.81*0.15 or 1/3."""

from __future__ import annotations

import math
import re

_NUMBER = r"[-+]?(?:\d+\.?\d*|\.\d+)(?:[eE][-+]?\d+)?"
_PRODUCT = re.compile(rf"\s*{_NUMBER}(?:\s*[*/]\s*{_NUMBER})*\s*", re.ASCII)
_PART = re.compile(rf"([*/]?)\s*({_NUMBER})", re.ASCII)


def product(text: str) -> float | None:
    """The number that a text is or comes to, from left to right; None where it is none, infinite,
    or divided by zero.
    """
    if _PRODUCT.fullmatch(text) is None:
        return None
    value = 1.0
    for sign, part in _PART.findall(text):
        number = float(part)
        if sign == "/" and not number:
            return None
        value = value / number if sign == "/" else value * number
    return value if math.isfinite(value) else None
