"""G-code as legs: G0 to G3 (arcs by I and J, or R), F, G4, units, absolute and relative.

Words of one line act together, whatever their order: settings first, then a wait, then a move.
Coordinates are taken from an origin in the robot's frame. G0 runs at the job's speed, G1 to G3 at
F. What means nothing to a delta is passed over and noted; what would change the path is refused.
"""

from __future__ import annotations

import math
from collections import Counter
from pathlib import Path
from typing import Any

from deltactl.firmware_py.importing.drawn import FLAT, Drawn, Point
from deltactl.firmware_py.importing.gcode_arcs import centre_by_words
from deltactl.firmware_py.importing.gcode_tables import (
    ARCS,
    AXES,
    CALLS,
    CENTRE,
    ENDS,
    GROUPS,
    MM_M,
    MOVES,
    OTHER,
    REFUSED,
    SILENT,
    UNITS,
    WITHOUT_MEANING,
)
from deltactl.firmware_py.importing.gcode_words import Word, words_of
from deltactl.foundation.errors import ConfigError
from deltactl.foundation.plain_file import TooLong, read_plain

MAX_BYTES = 20_000_000
MILLISECONDS = "G4 P taken as milliseconds ({}); where the program meant seconds, write S"
EARLY = "moves before X, Y and Z are all known left out ({})"


def read_gcode(path: Path, origin_m: Point) -> Drawn:
    """A G-code file as legs. Raises MissingFile, or ConfigError naming the line."""
    try:
        text = read_plain(path, MAX_BYTES).decode("utf-8-sig")
    except (UnicodeDecodeError, TooLong) as error:
        raise ConfigError(f"{path}: is no G-code ({error or 'too long'})") from error
    reader, rows = _Reader(origin_m), []
    for number, line in enumerate(text.splitlines(), 1):
        try:
            rows.append((number, words_of(line)))
        except ValueError as error:
            raise ConfigError(f"{path}:{number}: '{error}' is not understood") from error
    if not any(word.letter == "Z" for _, words in rows for word in words):
        reader.lies_flat()
    for number, words in rows:
        try:
            reader.take(number, words)
        except ValueError as error:
            raise ConfigError(f"{path}:{number}: {error}") from error
        if any(word.letter == "M" and word.value in ENDS for word in words):
            break
    return reader.done(path)


class _Reader:
    """Carries out lines; what is wrong with one is raised as ValueError."""

    def __init__(self, origin_m: Point):
        self._origin = origin_m
        self._unit_m, self._absolute, self._placed = MM_M, True, False
        self._modal: float | None = MOVES[0]
        self._at: list[float | None] = [None, None, None]
        self._feed_mps: float | None = None
        self._start: Point | None = None
        self._start_line: int | None = None
        self._legs: list[dict[str, Any]] = []
        self._lines: list[int] = []
        self._over: Counter[str] = Counter()
        self._notes: Counter[str] = Counter()

    def lies_flat(self) -> None:
        """No height is given anywhere: all of it is at the origin's."""
        self._at[2] = 0.0
        self._notes[FLAT] += 1

    def take(self, number: int, words: list[Word]) -> None:
        """The words of one line of the file."""
        codes = [word.value for word in words if word.letter == "G"]
        given = self._given(words)
        self._look_at(codes, given)
        self._settings(codes, given)
        if 4.0 in codes:
            self._dwell(number, given)
            if any(code in MOVES for code in codes):
                raise ValueError("G4 and a move on one line; give each a line of its own")
            return
        if {*AXES, *CENTRE, "R"} & set(given):
            if self._modal is None:
                raise ValueError("coordinates after G80, which ends all moves; give G0 to G3")
            self._move(number, self._modal, given)

    def _given(self, words: list[Word]) -> dict[str, float]:
        """Numbers by letter, G aside; M, T and what goes with them are noted."""
        given: dict[str, float] = {}
        for word in words:
            if word.letter == "M" and word.value in CALLS:
                raise ValueError(f"{word.text} calls another part of the program; write it out")
            if word.letter in "MT":
                self._over[word.text] += 1
            elif word.letter != "G":
                if word.letter in given:
                    raise ValueError(f"two words {word.letter} on one line")
                given[word.letter] = word.value
        waits = any(word.letter == "G" and word.value == 4.0 for word in words)
        known = {*AXES, *CENTRE, *"FKR", *("PSU" if waits else "")}
        self._over.update(letter for letter in given if letter not in known)
        return given

    def _look_at(self, codes: list[float], given: dict[str, float]) -> None:
        for name, group in GROUPS.items():
            if len([code for code in codes if code in group]) > 1:
                raise ValueError(f"two of the {name} {_list(group)} on one line")
        taken = {4.0} | {code for group in GROUPS.values() for code in group}
        for code in codes:
            if code == 92.0 and not set(given) & set(AXES):
                self._over["G92"] += 1  # of an extruder
            elif code in REFUSED:
                raise ValueError(f"G{code:g} {REFUSED[code]}")
            elif code in WITHOUT_MEANING:
                self._over[f"G{code:g}"] += 1
            elif code not in taken | SILENT:
                raise ValueError(f"G{code:g} {OTHER}")

    def _settings(self, codes: list[float], given: dict[str, float]) -> None:
        for code in codes:
            self._unit_m = UNITS.get(code, self._unit_m)
            if code in (90.0, 91.0):
                self._absolute = code == 90.0
            elif code in (90.1, 91.1):
                self._placed = code == 90.1
            elif code in MOVES:
                self._modal = code
            elif code == 80.0:
                self._modal = None
        if "F" in given:
            if given["F"] <= 0.0:
                raise ValueError("F must be above 0")
            self._feed_mps = given["F"] * self._unit_m / 60.0

    def _dwell(self, number: int, words: dict[str, float]) -> None:
        seconds = next((words[letter] for letter in "SXU" if letter in words), None)
        if seconds is None:
            if "P" not in words:
                raise ValueError("G4 needs P (milliseconds), or S, X or U (seconds)")
            seconds = words["P"] / 1000.0
            self._notes[MILLISECONDS] += 1
        if seconds < 0.0:
            raise ValueError("G4 cannot wait for less than nothing")
        if self._start is None:
            raise ValueError("G4 stands before any move; there is nothing to wait at")
        if not self._legs:
            self._legs.append({"to_m": self._start})
            self._lines.append(number)
        self._legs[-1]["dwell_s"] = round(self._legs[-1].get("dwell_s", 0.0) + seconds, 6)

    def _move(self, number: int, code: float, words: dict[str, float]) -> None:
        if code in ARCS and words.get("K", 0.0) != 0.0:
            raise ValueError(f"G{code:g} with K is an arc in another plane; arcs lie in XY (G17)")
        begin = list(self._at)
        self._go(words)
        if any(place is None for place in self._at):
            if code in ARCS:
                raise ValueError("an arc needs a place to begin at: X, Y and Z before it")
            self._notes[EARLY] += code != MOVES[0]
            return  # the first lines of a file name the axes one by one
        here = self._place()
        if self._start is None:
            self._start, self._start_line = here, number
            return
        leg: dict[str, Any] = {"to_m": here}
        if code != MOVES[0] and self._feed_mps is not None:
            leg["speed_mps"] = float(f"{self._feed_mps:.6g}")
        if code in ARCS:
            leg["centre_m"] = self._centre(begin, words, clockwise=code == ARCS[0])
            leg["clockwise"] = code == ARCS[0]
        if math.dist(here, self._last()) > 1e-9 or code in ARCS:
            self._legs.append(leg)
            self._lines.append(number)

    def _go(self, words: dict[str, float]) -> None:
        for axis, letter in enumerate(AXES):
            if letter not in words:
                continue
            was = self._at[axis]
            if not self._absolute and was is None:
                raise ValueError("G91 stands before any absolute place; begin with G90")
            self._at[axis] = words[letter] * self._unit_m + (
                0.0 if self._absolute or was is None else was
            )

    def _centre(
        self, begin: list[float | None], words: dict[str, float], *, clockwise: bool
    ) -> tuple[float, float]:
        from_m = (begin[0] or 0.0, begin[1] or 0.0)
        to_m = (self._at[0] or 0.0, self._at[1] or 0.0)
        x_m, y_m = centre_by_words(from_m, to_m, words, self._unit_m, clockwise, self._placed)
        return round(x_m + self._origin[0], 9), round(y_m + self._origin[1], 9)

    def _place(self) -> Point:
        x_m, y_m, z_m = (
            round((place or 0.0) + zero, 9)
            for place, zero in zip(self._at, self._origin, strict=True)
        )
        return x_m, y_m, z_m

    def _last(self) -> Point:
        assert self._start is not None
        return self._legs[-1]["to_m"] if self._legs else self._start

    def done(self, path: Path) -> Drawn:
        """Everything that was taken. Raises ConfigError where that is nothing."""
        if self._start is None:
            raise ConfigError(f"{path}: holds no moves with X, Y and Z")
        if not self._legs:
            raise ConfigError(
                f"{path}:{self._start_line}: is the only place in it, where the path begins; a path"
                f" needs a move from there{self._too_early()}"
            )
        over = [f"{word} passed over ({_times(count)})" for word, count in self._over.items()]
        notes = [note.format(_times(count)) for note, count in self._notes.items() if count]
        lines = tuple(self._lines)
        return Drawn(self._start, tuple(self._legs), (*over, *notes), lines, self._start_line)

    def _too_early(self) -> str:
        """Why other moves are no part of the path, if there are any."""
        count = self._notes.get(EARLY, 0)
        if not count:
            return ""
        early = EARLY.format(_times(count))
        return f" ({early}: begin with a move that has all three, as G0 X0 Y0 Z5)"


def _list(codes: tuple[float, ...]) -> str:
    return ", ".join(f"G{code:g}" for code in codes)


def _times(count: int) -> str:
    return "once" if count == 1 else f"{count} times"
