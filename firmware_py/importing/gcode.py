"""G-code: G0 to G3 (arcs by I, J or R), F, G4, G17, G20, G21, G90, G91; other moves are refused.

Words are read by the package gcodeparser. Coordinates are taken from an origin in the robot's
frame. G0 runs at the job's speed, G1 to G3 at F. Other words are passed over, and said so.
"""

from __future__ import annotations

import math
import re
from pathlib import Path
from typing import Any

from firmware_py.importing.drawn import Drawn, Point
from foundation.errors import ConfigError
from foundation.plain_file import TooLong, read_plain

MAX_BYTES = 20_000_000
MM_M, INCH_M = 1e-3, 0.0254
UNITS = {20: INCH_M, 21: MM_M}
MOVES = (0, 1, 2, 3)
TAKEN = "XYZIJRF"
"""Words of a move; others, such as an extruder's E, are listed."""
SILENT = frozenset({17, 40, 49, 54, 64, 80, 94})
"""Settings of a milling machine that change nothing here: plane XY, no tool, mm a minute, ..."""
ROUND = 1e-3
"""Coordinates are rounded in files: R may be so much too short for a half turn."""
Place = tuple[float, float]
_COMMENT = re.compile(r"\([^)]*\)|;.*")
_NUMBERED = re.compile(r"^\s*[Nn]\d+\s*")
_BARE = re.compile(r"^\s*[XYZIJFxyzijf]")


def read_gcode(path: Path, origin_m: Point) -> Drawn:
    """A G-code file as legs. Raises MissingFile, or ConfigError naming the line."""
    try:
        text = read_plain(path, MAX_BYTES).decode("utf-8-sig")
    except (UnicodeDecodeError, TooLong) as error:
        raise ConfigError(f"{path}: is no G-code ({error or 'too long'})") from error
    reader = _Reader(path, origin_m)
    for number, line in enumerate(text.splitlines(), 1):
        reader.take(number, line)
    return reader.done()


class _Reader:
    def __init__(self, path: Path, origin_m: Point):
        self._path, self._origin = path, origin_m
        self._unit_m, self._absolute, self._modal = MM_M, True, 0
        self._at: list[float | None] = [None, None, None]
        self._feed_mps: float | None = None
        self._start: Point | None = None
        self._legs: list[dict[str, Any]] = []
        self._over: dict[str, int] = {}

    def take(self, number: int, line: str) -> None:
        """One line of the file."""
        from gcodeparser import parse_gcode_lines

        said = _NUMBERED.sub("", _COMMENT.sub("", line)).strip()
        if not said or said.startswith("%"):
            return
        if _BARE.match(said):  # the word before still holds
            said = f"G{self._modal} {said}"
        words = list(parse_gcode_lines(said.upper()))
        if not words:
            raise self._fail(number, f"'{said[:40]}' is not understood; give a G word")
        for word in words:
            letter, code = word.command
            if letter == "G" and code is not None:
                self._g(number, int(code), self._numbers(number, word.params))
            else:
                self._pass_over(word.command_str, *(word.params if letter == "M" else ()))

    def _pass_over(self, *words: str) -> None:
        for word in words:
            self._over[word] = self._over.get(word, 0) + 1

    def _g(self, number: int, code: int, words: dict[str, float]) -> None:
        if code in UNITS:
            self._unit_m = UNITS[code]
        elif code in (90, 91):
            self._absolute = code == 90
        elif code == 4:
            self._dwell(number, words)
        elif code in MOVES:
            self._modal = code
            self._move(number, code, words)
        elif code not in SILENT:
            raise self._fail(number, f"G{code} is not taken; G0 to G4, G17, G20, G21, G90, G91 are")

    def _dwell(self, number: int, words: dict[str, float]) -> None:
        seconds = words["S"] if "S" in words else words.get("P", 0.0) / 1000.0
        if not self._legs:
            raise self._fail(number, "G4 stands before any move; there is nothing to wait at")
        self._legs[-1]["dwell_s"] = round(self._legs[-1].get("dwell_s", 0.0) + seconds, 6)

    def _move(self, number: int, code: int, words: dict[str, float]) -> None:
        self._pass_over(*(letter for letter in words if letter not in TAKEN))
        if "F" in words:
            self._feed_mps = words["F"] * self._unit_m / 60.0
        if not {"X", "Y", "Z", "I", "J"} & set(words):
            return
        begin, relative = list(self._at), not self._absolute
        for axis, letter in enumerate("XYZ"):
            if letter not in words:
                continue
            if relative and begin[axis] is None:
                raise self._fail(number, "G91 stands before any absolute place; begin with G90")
            was = begin[axis] or 0.0
            self._at[axis] = words[letter] * self._unit_m + (was if relative else 0.0)
        if any(place is None for place in self._at):
            if code in (2, 3):
                raise self._fail(number, "an arc needs a place to begin at: X, Y and Z before it")
            return  # the first lines of a file name the axes one by one
        here = self._place(number)
        if self._start is None:
            self._start = here
            return
        leg: dict[str, Any] = {"to_m": here}
        if code != 0 and self._feed_mps is not None:
            leg["speed_mps"] = float(f"{self._feed_mps:.6g}")
        if code in (2, 3):
            leg |= self._arc(number, begin, words, clockwise=code == 2)
            leg["clockwise"] = code == 2
        if math.dist(here, self._last()) > 1e-9 or code in (2, 3):
            self._legs.append(leg)

    def _arc(
        self, number: int, begin: list[float | None], words: dict[str, float], *, clockwise: bool
    ) -> dict[str, Any]:
        x_m, y_m = (place or 0.0 for place in begin[:2])
        if "R" in words:
            from_m, to_m = (x_m, y_m), (self._at[0] or 0.0, self._at[1] or 0.0)
            east_m, north_m = self._centre(number, from_m, to_m, words["R"], clockwise)
        elif {"I", "J"} & set(words):
            east_m = words.get("I", 0.0) * self._unit_m
            north_m = words.get("J", 0.0) * self._unit_m
        else:
            raise self._fail(
                number, "an arc needs I and J, from its beginning to its centre, or its radius R"
            )
        centre = (x_m + east_m + self._origin[0], y_m + north_m + self._origin[1])
        return {"centre_m": (round(centre[0], 9), round(centre[1], 9))}

    def _centre(
        self, number: int, begin: Place, end: Place, radius: float, clockwise: bool
    ) -> Place:
        """From the beginning of an arc to its centre [m]; R below 0 is the longer way round."""
        chord_m, radius_m = math.dist(begin, end), abs(radius) * self._unit_m
        if chord_m < 1e-9:
            raise self._fail(
                number, "an arc by R needs another place to end at; whole turns by I, J"
            )
        if chord_m > 2.0 * radius_m * (1.0 + ROUND) + 1e-9:
            raise self._fail(
                number,
                f"R {radius:g} cannot reach: half the distance is"
                f" {chord_m / 2.0 / self._unit_m:.6g}",
            )
        # Left of the chord lies the centre of a short counter-clockwise arc.
        height_m = math.sqrt(max(0.0, radius_m**2 - chord_m**2 / 4.0))
        side = -height_m if clockwise != (radius < 0.0) else height_m
        east, north = ((b - a) / chord_m for a, b in zip(begin, end, strict=True))
        return (
            east * chord_m / 2.0 - north * side,
            north * chord_m / 2.0 + east * side,
        )

    def _place(self, number: int) -> Point:
        x_m, y_m, z_m = (
            round((place or 0.0) + zero, 9)
            for place, zero in zip(self._at, self._origin, strict=True)
        )
        return x_m, y_m, z_m

    def _last(self) -> Point:
        assert self._start is not None
        return self._legs[-1]["to_m"] if self._legs else self._start

    def _numbers(self, number: int, params: dict[str, Any]) -> dict[str, float]:
        try:
            return {letter: float(value) for letter, value in params.items()}
        except (TypeError, ValueError):
            raise self._fail(number, f"a word without a number: {params}") from None

    def done(self) -> Drawn:
        """Everything that was taken."""
        if self._start is None or not self._legs:
            raise ConfigError(f"{self._path}: holds no moves with X, Y and Z")
        notes = tuple(f"{word} passed over ({_times(count)})" for word, count in self._over.items())
        return Drawn(self._start, tuple(self._legs), notes)

    def _fail(self, number: int, message: str) -> ConfigError:
        return ConfigError(f"{self._path}:{number}: {message}")


def _times(count: int) -> str:
    return "once" if count == 1 else f"{count} times"
