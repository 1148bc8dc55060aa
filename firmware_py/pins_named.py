"""Pins that a robot file names: each may be named once."""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Mapping
from typing import Any

from deltactl.foundation.yaml_tree import Location

SECTIONS = ("steps", "inputs", "ranging", "homing")
"""Sections whose keys that end in _pin or _pins name some."""
GROUPS = (("outputs",), ("inputs", "named"))
"""Where each entry has a `pin`."""

Named = tuple[Location, tuple[int, ...]]


def pins_named(data: Mapping[str, Any]) -> Iterator[Named]:
    """Each key with the pins it names; whatever is not as it should be names none, and neither
    does `ranging` of a robot without `sensors`.
    """
    for section in SECTIONS:
        if section == "ranging" and data.get("sensors") is None:
            continue
        for key, value in _inside(data, section).items():
            if isinstance(key, str) and key.endswith(("_pin", "_pins")):
                yield (section, key), _numbers(value)
    for place in GROUPS:
        for name, entry in _inside(data, *place).items():
            if isinstance(entry, Mapping):
                yield (*place, name, "pin"), _numbers(entry.get("pin"))


def named_twice(named: Iterable[Named], taken: Mapping[int, str]) -> Iterator[tuple[Location, str]]:
    """Where a pin is named that is taken already; `taken`: pins of others, and whose."""
    seen = dict(taken)
    for place, pins in named:
        for pin in pins:
            if pin in seen:
                says = f"GPIO {pin} is taken by {seen[pin]} already; choose a pin of its own"
                yield place, says
            seen[pin] = ".".join(str(part) for part in place)


def _inside(data: Any, *keys: str) -> Mapping[Any, Any]:
    for key in keys:
        data = data.get(key) if isinstance(data, Mapping) else None
    return data if isinstance(data, Mapping) else {}


def _numbers(value: Any) -> tuple[int, ...]:
    several = value if isinstance(value, list | tuple) else [value]
    return tuple(one for one in several if isinstance(one, int) and not isinstance(one, bool))
