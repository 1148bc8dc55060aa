"""The unit in which texts say a size: the one in which its owner recorded it, or a usual one."""

from __future__ import annotations

import math
from collections.abc import Iterable, Iterator, Mapping
from contextlib import contextmanager
from contextvars import ContextVar
from types import MappingProxyType

USUAL = {
    "rad": ("degrees", math.degrees(1.0)),
    "m": ("mm", 1e3),
    "s": ("ms", 1e3),
    "kg": ("g", 1e3),
    "kg m2": ("kg m\u00b2", 1.0),
    "1/m": ("mm per m\u00b2", 1e3),
    "1": ("", 1.0),
}
"""Unit of the contract -> what people call a usual one, and how many of it are one."""
FINE = {
    "mrad": ("rad", "mrad", 1e3),
    "arcmin": ("rad", "arcmin", 10800.0 / math.pi),
    "arcsec": ("rad", "arcsec", 648000.0 / math.pi),
    "um": ("m", "\u00b5m", 1e6),
    "inch": ("m", "inch", 1.0 / 0.0254),
}
"""Unit of a table, in which its owner reads answers too -> that of the contract, and the same."""
_owners: ContextVar[Mapping[str, tuple[str, float]]] = ContextVar(
    "owners", default=MappingProxyType({})
)


@contextmanager
def said_in(units: Iterable[str]) -> Iterator[None]:
    """Say sizes in the fine ones of a table's units until the block ends."""
    own = {FINE[one][0]: FINE[one][1:] for one in units if one in FINE}
    token = _owners.set(own)
    try:
        yield
    finally:
        _owners.reset(token)


def in_use(unit: str, value: float = math.nan) -> tuple[str, float]:
    """What a size of a unit of the contract is said in, and how many of that are one.

    value: the size; usual for lengths, times and masses from 1 on are m, s and kg.
    """
    place = unit.removesuffix("/s")
    if (one := place if place in ("rad", "m") else unit) in _owners.get():
        word, many = _owners.get()[one]
    elif one in ("m", "s", "kg") and abs(value) >= 1.0:
        word, many = one, 1.0
    else:
        word, many = USUAL.get(one, (one, 1.0))
    return word if one == unit else f"{word}/s", many


NEAR_ONE = 0.5
"""Further off, a number is no ratio of which only the difference from 1 matters."""


def said(value: float, unit: str) -> str:
    """A number with a unit in which it is easily read."""
    if unit == "1":
        near_one = abs(value - 1.0)
        digits = 3 - math.floor(math.log10(near_one)) if 0.0 < near_one < 1e-3 else 5
        digits = digits if near_one < NEAR_ONE else 3
        return f"{value:.{digits}g}"
    word, many = in_use(unit, value)
    return f"{plain(many * value)} {word}"


def plain(value: float) -> str:
    """Three significant digits, and no exponent where a person would write none."""
    if not math.isfinite(value) or value == 0.0 or not 1e-5 <= abs(value) < 1e6:
        return f"{value:.3g}"
    decimals = 2 - math.floor(math.log10(abs(value)))
    return f"{value:.{max(decimals, 0)}f}"
