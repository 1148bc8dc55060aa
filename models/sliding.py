"""What an axis that slides calls the parameters of effects in its robot file.

Inside, and in the JSON of an answer, one effect has one vocabulary whatever its motion. A file is
read by people: a shift in m is no angle there, and a force in N no torque.
"""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

IN_FILE: Mapping[str, Mapping[str, str]] = {
    "home_offset": {"angle": "offset"},
    "joint_friction": {"torque": "force"},
    "stribeck_friction": {"torque": "force"},
}
"""Effect -> parameter -> its name in the file of an axis that slides."""


def named_for_file(entry: Mapping[str, Any]) -> dict[str, Any]:
    """An entry of `effects` with the names for a file."""
    return _renamed(entry, IN_FILE.get(str(entry.get("effect")), {}))


def named_inside(entry: Mapping[str, Any]) -> dict[str, Any]:
    """An entry of `effects` as it is inside; a file that has those names already is read too."""
    names = IN_FILE.get(str(entry.get("effect")), {})
    return _renamed(entry, {shown: name for name, shown in names.items()})


def _renamed(entry: Mapping[str, Any], names: Mapping[str, str]) -> dict[str, Any]:
    made = dict(entry)
    if isinstance(values := made.get("parameters"), dict):
        made["parameters"] = _keys(values, names)
    if isinstance(found := made.get("found"), dict) and isinstance(found.get("ci95"), dict):
        made["found"] = found | {"ci95": _keys(found["ci95"], names)}
    return made


def _keys(values: dict[str, Any], names: Mapping[str, str]) -> dict[str, Any]:
    """With other keys, in the same order; a key whose new name is there already is left."""
    return {
        key if names.get(key, key) in values else names[key]: value for key, value in values.items()
    }
