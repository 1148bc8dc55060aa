"""What a user says that codes of a file mean: --skip G28, --code "M3=spindle on"."""

from __future__ import annotations

import re
from collections.abc import Collection, Iterable
from dataclasses import dataclass, field

from deltactl.firmware_py.importing.drawn import Point
from deltactl.firmware_py.importing.gcode_tables import PLACED, SKIPPABLE, SWITCHES
from deltactl.foundation.errors import ConfigError

_CODE = re.compile(r"\s*([GM])\s*0*(\d+(?:\.\d+)?)\s*", re.IGNORECASE)
_SWITCH = re.compile(r"\s*(\S+)\s+(on|off)\s*", re.IGNORECASE)
_NUMBER = re.compile(r"[-+]?(?:\d+\.?\d*|\.\d+)")
PAUSE = "pause"
_FORMS = (
    'M3, M5, M106, M107 and the like: "M3=OUTPUT on" or "M5=OUTPUT off"; G28: "G28=X Y Z", mm of'
    " the file; an M code that needs a hand: M6=pause; the P of G4: G4=s or G4=ms"
)


@dataclass(frozen=True, slots=True)
class Meanings:
    """Codes by their text, as `M3`. Nothing said: what the tables say holds."""

    skipped: frozenset[str] = frozenset()
    switched: dict[str, tuple[str, bool]] = field(default_factory=dict)
    """Output of the robot file, and whether it is on then."""
    places_m: dict[str, Point] = field(default_factory=dict)
    """In the file's frame."""
    paused: frozenset[str] = frozenset()
    p_is_seconds: bool | None = None
    """What G4's P is; None: as the file lets one see."""
    block_delete: bool | None = None
    """Whether lines that begin with '/' are left out; None: they are refused."""


def meanings_of(
    skip: Iterable[str],
    codes: Iterable[str],
    outputs: Collection[str] = (),
    block_delete: bool | None = None,
) -> Meanings:
    """The meanings that options give; outputs: those of the robot file. Raises ConfigError."""
    skipped = frozenset(_skipped(one) for one in skip)
    switched: dict[str, tuple[str, bool]] = {}
    places_m: dict[str, Point] = {}
    paused: set[str] = set()
    seconds: bool | None = None
    for said in codes:
        name, equals, meaning = said.partition("=")
        meaning = meaning.strip()
        code = _name(name)
        if code is None or not equals or not meaning:
            raise ConfigError(f'--code "{said}": is no CODE=MEANING; {_FORMS}')
        number = float(code[1:])
        if switch := _SWITCH.fullmatch(meaning):
            switched[code] = _switched(said, code, switch, outputs)
        elif meaning.lower() == PAUSE and code[0] == "M":
            paused.add(code)
        elif code == "G4" and meaning.lower() in ("s", "ms"):
            seconds = meaning.lower() == "s"
        elif code[0] == "G" and number in PLACED:
            places_m[code] = _place_m(said, meaning)
        else:
            raise ConfigError(f'--code "{said}": {code} cannot mean that; {_FORMS}')
        if code in skipped:
            raise ConfigError(f"--skip {code} and --code {code}=... contradict each other")
    return Meanings(skipped, switched, places_m, frozenset(paused), seconds, block_delete)


def _name(text: str) -> str | None:
    found = _CODE.fullmatch(text)
    return None if found is None else f"{found[1].upper()}{float(found[2]):g}"


def _skipped(text: str) -> str:
    code = _name(text)
    if code is None or (code[0] == "G" and float(code[1:]) not in SKIPPABLE):
        there = ", ".join(f"G{one:g}" for one in sorted(SKIPPABLE))
        raise ConfigError(
            f"--skip {text}: only M codes and {there} can be left out of G-code: what any other"
            " means would be another path"
        )
    return code


def _switched(
    said: str, code: str, switch: re.Match[str], outputs: Collection[str]
) -> tuple[str, bool]:
    if code[0] != "M" or float(code[1:]) not in SWITCHES:
        there = ", ".join(f"M{one:g}" for one in sorted(SWITCHES))
        raise ConfigError(f'--code "{said}": only {there} can switch an output')
    if switch[1] not in outputs:
        there = ", ".join(outputs) or "none"
        raise ConfigError(
            f"--code \"{said}\": '{switch[1]}' is not in 'outputs' of the robot file, which has"
            f" {there}"
        )
    return switch[1], switch[2].lower() == "on"


def _place_m(said: str, meaning: str) -> Point:
    parts = meaning.replace(",", " ").split()
    if len(parts) != 3 or not all(_NUMBER.fullmatch(part) for part in parts):
        raise ConfigError(f'--code "{said}": is no place; give X Y Z in mm, as "G28=0 0 50"')
    x_m, y_m, z_m = (float(part) / 1e3 for part in parts)
    return x_m, y_m, z_m
