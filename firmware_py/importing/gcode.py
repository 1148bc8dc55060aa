"""G-code as legs: G0 to G3 (arcs by I and J, or R), F, G4, units, absolute and relative.

Words of one line act together, whatever their order: settings first, then outputs, a wait, a move,
and a stop last (NIST IR 6556, table 8). Coordinates are taken from an origin in the robot's frame.
G0 runs at the job's speed, G1 to G3 at F. What means nothing to a delta is passed over and noted;
what would change the path is refused. All mistakes of a file are reported together.
"""

from __future__ import annotations

import math
import re
from array import array
from collections import Counter
from collections.abc import Sequence
from pathlib import Path
from typing import Any, cast

from deltactl.firmware_py.importing import gcode_tables as notes_of
from deltactl.firmware_py.importing.drawn import FLAT, MOST_MISTAKES, Drawn, Point, as_written
from deltactl.firmware_py.importing.gcode_line import (
    WAIT,
    Command,
    centre_by_words,
    check_words,
    command_of,
)
from deltactl.firmware_py.importing.gcode_tables import (
    ARCS,
    AXES,
    CENTRE,
    MACROS,
    MM_M,
    MOVES,
    PLACED,
    UNITS,
    Meanings,
)
from deltactl.firmware_py.importing.gcode_words import (
    BLANK,
    DELETED,
    numbered_lines,
    without_comments,
)
from deltactl.firmware_py.path_file import MOST_DWELL_S
from deltactl.firmware_py.paths.legs import MOST_LEGS, LegsGathered
from deltactl.foundation.errors import ConfigError

_SETTING = re.compile(r"[gG][ \t]*0*(20|21|90(?:\.1)?|91(?:\.1)?|[0-3])(?![\d.])", re.ASCII)
_SAME_M = 1e-9
_MOST_SAID = 150
NOTHING_SAID = Meanings()


def read_gcode(path: Path, origin_m: Point, means: Meanings = NOTHING_SAID) -> Drawn:
    """A G-code file as legs. Raises MissingFile, or ConfigError naming each wrong line."""
    for flat in (False, True):  # without any height it lies at that of the origin
        reader = _Reader(path, origin_m, means, flat)
        for number, line in numbered_lines(path):
            reader.take(number, line)
            if reader.full:
                break
        if reader.begun or reader.heights or reader.errors:
            break
    return reader.done()


class _Reader:
    """Carries out lines, and gathers what is wrong with them."""

    def __init__(self, path: Path, origin_m: Point, means: Meanings, flat: bool):
        self.errors: list[str] = []
        self.heights = False
        """Whether any line gives a height."""
        self._path, self._origin, self._means = path, origin_m, means
        self._unit_m, self._absolute, self._placed = MM_M, True, False
        self._modal: float | None = MOVES[0]
        self._at: list[float | None] = [None, None, 0.0 if flat else None]
        self._lost = False
        """Whether --skip has left out moves to unknown places."""
        self._gone, self._doubtful = False, set[str]()
        """Whether the axes are where a line leads to, and of which that is not sure any more."""
        self._feed_mps: float | None = None
        self._start: Point | None = None
        self._start_line: int | None = None
        self._legs, self._lines = LegsGathered(), array("L")
        self._between: list[tuple[int, dict[str, Any]]] = []
        self._waits: list[tuple[int, dict[str, Any] | int, float]] = []
        """Waits by G4 P: line, the step or leg that waits, and P, whose unit its end shows."""
        self._fraction = False  # also for a P that is left out: the file counts in seconds
        self._on, self._powered = dict[str, bool](), ""
        self._ended, self._behind, self._words = "", 0, False
        self._over: Counter[str] = Counter()
        self._notes: Counter[str] = Counter({FLAT: 1} if flat else {})

    @property
    def begun(self) -> bool:
        """Whether a place is known."""
        return self._start is not None

    @property
    def full(self) -> bool:
        """Whether nothing more need be read, as the file is refused."""
        return len(self.errors) > MOST_MISTAKES or len(self._legs) > MOST_LEGS

    def take(self, number: int, line: str) -> None:
        """One line of the file."""
        said = line.strip(BLANK)
        if not said or said[0] == ";":
            return
        if self._ended:
            self._behind += 1
            return
        leaves_out = self._means.block_delete
        if leaves_out is not None and (deleted := DELETED.match(said)):
            self._notes[notes_of.LEFT_OUT if leaves_out else notes_of.CARRIED_OUT] += 1
            if leaves_out:
                return
            said = line = deleted[1] + said[deleted.end() :]
        self._gone = False
        try:
            if not self._outside(number, said):
                self._carry_out(number, line, command_of(line, self._means))
                self._words = True
        except ValueError as error:
            self.errors.append(f"{self._path}:{number}: {error}")
            self._go_on_after(line)

    def _go_on_after(self, line: str) -> None:
        """After a line that is refused: its settings hold, and where it led to is doubtful."""
        self._settings([float(code) for code in _SETTING.findall(line.partition(";")[0])], {})
        if not self._gone:
            self._doubtful = set(AXES)

    def _outside(self, number: int, said: str) -> bool:
        """Whether a line is about the program as a whole, or a command of Klipper."""
        if said[0] == "%":
            if said != "%" and self._words:
                raise ValueError(f"'{said[:40]}' is not understood")
            if said != "%":
                self._over["the text after %"] += 1
            elif self._words:
                self._ended = "%"
            return True
        if said[0] in "oO:" and not self._words:
            name = without_comments(said)[0].strip()
            if name[1:].strip().isdecimal():
                self._over[f"the number of the program ({name})"] += 1
                self._words = True
                return True
        name = said.split(None, 1)[0].upper()
        if name in MACROS:
            self._over[name] += 1
            return True
        return False

    def _carry_out(self, number: int, line: str, command: Command) -> None:
        given, codes = command.given, command.codes
        self.heights |= "Z" in given
        if command.passed:
            self._over.update(command.passed)
        self._settings(codes, given)
        self._switch(command)
        if command.skipped:
            self._lose(given)
        elif WAIT in codes:
            self._dwell(number, given)
        elif placed := [code for code in codes if code in PLACED]:
            self._go_to_place(number, placed[0], command)
        elif given.keys() & {*AXES, *CENTRE, "R"}:
            if self._modal is None:
                raise ValueError("coordinates after G80, which ends all moves; give G0 to G3")
            self._move(number, self._modal, given)
        self._pause(number, line, command)
        self._ended = command.ends

    def _settings(self, codes: list[float], given: dict[str, float]) -> None:
        for code in codes:
            self._unit_m = UNITS.get(code, self._unit_m)
            if code in (90.0, 91.0):
                self._absolute = code == 90.0
            elif code in (90.1, 91.1):
                self._placed = code == 90.1
            elif code in MOVES:
                self._modal = code
            elif code == 80.0 and not set(codes) & set(MOVES):
                self._modal = None
        if "F" in given:
            if given["F"] <= 0.0:
                raise ValueError("F must be above 0")
            self._feed_mps = float(f"{given['F'] * self._unit_m / 60.0:.6g}")

    def _switch(self, command: Command) -> None:
        """Outputs that the line names, and what an S switches of one that runs."""
        switched = dict(command.switched)
        self._powered = command.powered or self._powered
        if "S" in command.given and WAIT not in command.codes and self._powered and not switched:
            switched = {self._powered: command.given["S"] > 0.0}
        changed = {name: on for name, on in switched.items() if self._on.get(name) is not on}
        if changed:
            self._on |= changed
            self._step({"set": changed})

    def _step(self, step: dict[str, Any]) -> None:
        """Something that is done where the arms are by then."""
        if self._start is None:
            self._between.append((-1, step))
            return
        if not self._legs:  # they are to be where the path begins
            self._legs.add(self._start)
            self._lines.append(self._start_line or 1)
        self._between.append((len(self._legs), step))

    def _pause(self, number: int, line: str, command: Command) -> None:
        for why in command.paused:
            if command.changes_tool and self._start is None:
                self._over["M6"] += 1  # the tool that is in
                continue
            comment = without_comments(line)[1]
            said = f"{why}, line {number}" + (f": {comment}" if comment else "")
            shown = "".join(sign if sign.isprintable() else " " for sign in said)
            self._step({"pause": shown[:_MOST_SAID].strip()})

    def _dwell(self, number: int, words: dict[str, float]) -> None:
        given = [letter for letter in "SXUP" if letter in words]
        if len(given) != 1:
            raise ValueError("G4 needs one of P, S, X or U (S, X and U are seconds)")
        value = words[given[0]]
        if not 0.0 <= value <= (1e3 if given == ["P"] else 1.0) * MOST_DWELL_S:
            raise ValueError("G4 waits from nothing to an hour")
        self._fraction |= given == ["P"] and value % 1.0 != 0.0
        if value == 0.0:
            return
        here = -1 if self._start is None else len(self._legs)
        holder: dict[str, Any] | int
        if self._between and self._between[-1][0] == here:
            holder = {"wait_s": 0.0}
            self._between.append((here, holder))
        elif self._start is None:
            self._notes[notes_of.EARLY_WAIT] += 1
            return
        else:
            if not self._legs:
                self._legs.add(self._start)
                self._lines.append(number)
            holder = len(self._legs) - 1
        if given == ["P"]:
            self._waits.append((number, holder, value))
        else:
            self._wait(holder, value)

    def _wait(self, holder: dict[str, Any] | int, seconds: float) -> float:
        """Longer, at a step or at the end of a leg; how long that is then."""
        if isinstance(holder, int):
            return self._legs.wait(holder, seconds)
        holder["wait_s"] = round(holder["wait_s"] + seconds, 6)
        return float(holder["wait_s"])

    def _lose(self, given: dict[str, float]) -> None:
        """A move that is left out went to unknown places."""
        self._lost = True
        for axis in [letter for letter in AXES if letter in given] or AXES:
            self._at[AXES.index(axis)] = None

    def _go_to_place(self, number: int, code: float, command: Command) -> None:
        """To the place that --code gives G28, in the axes that the line names, or in all.

        By way of a place that the line gives, as RS-274, LinuxCNC and grbl have it.
        """
        place, given = self._means.places_m[f"G{code:g}"], command.given
        named = [axis for axis in AXES if axis in given.keys() | command.bare] or list(AXES)
        self.heights |= "Z" in named
        if given.keys() & set(AXES) and (self._absolute or None not in self._at):
            self._go(given)
            if self._start is not None and self._arrive(number, MOVES[0], {}):
                self._notes[notes_of.BY_WAY.format(f"G{code:g}", "{}")] += 1
        for axis in named:
            self._at[AXES.index(axis)] = place[AXES.index(axis)]
        self._doubtful -= set(named)
        self._arrive(number, MOVES[0], {})

    def _move(self, number: int, code: float, words: dict[str, float]) -> None:
        begin, doubtful = list(self._at), self._doubtful & set("XY")
        if code not in ARCS and words.keys() & {*CENTRE, "R"}:
            letter = next(one for one in (*CENTRE, "R") if one in words)
            raise ValueError(f"{letter} belongs to an arc (G2, G3), and this is G{code:g}")
        self._go(words)
        if code in ARCS and words.get("K", 0.0) != 0.0:
            raise ValueError(f"G{code:g} with K is an arc in another plane; arcs lie in XY (G17)")
        if code not in ARCS:
            self._arrive(number, code, {})
            return
        check_words(words, self._placed)
        unknown = None in (*begin, *self._at)
        if doubtful or (unknown and self._doubtful):
            return  # it may begin elsewhere than it seems
        if unknown:
            raise ValueError(
                "an arc needs a place to begin at: X, Y and Z before it" + self._too_early()
            )
        from_m, to_m = ((place[0] or 0.0, place[1] or 0.0) for place in (begin, self._at))
        clockwise = code == ARCS[0]
        centre_m = centre_by_words(from_m, to_m, words, self._unit_m, clockwise, self._placed)
        arc = {"centre_m": self._written(centre_m), "clockwise": clockwise}
        self._arrive(number, code, arc)

    def _arrive(self, number: int, code: float, arc: dict[str, Any]) -> bool:
        """A leg to where the axes are by now; whether there is one."""
        if any(place is None for place in self._at):
            if self._start is not None and not self.errors:
                missing = ", ".join(
                    axis for axis, place in zip(AXES, self._at, strict=True) if place is None
                )
                raise ValueError(
                    f"{missing} is not known after what --skip left out; give all three in the file"
                )
            self._notes[notes_of.EARLY] += code != MOVES[0]
            return False  # the first lines of a file name the axes one by one
        here = cast(Point, self._written(self._at))
        if self._start is None:
            self._start, self._start_line = here, number
            return True
        if arc or math.dist(here, self._legs.end_m if self._legs else self._start) > _SAME_M:
            self._legs.add(here, None if code == MOVES[0] else self._feed_mps, **arc)
            self._lines.append(number)
            return True
        return False

    def _go(self, words: dict[str, float]) -> None:
        for axis, letter in enumerate(AXES):
            if letter not in words:
                continue
            was = self._at[axis]
            if self._absolute:
                self._at[axis] = words[letter] * self._unit_m
                self._doubtful.discard(letter)
            elif was is not None:
                self._at[axis] = was + words[letter] * self._unit_m
            elif not self._lost and not self.errors:
                raise ValueError("G91 comes before any absolute place; begin with G90")
        self._gone = True

    def _written(self, place_m: Sequence[float | None]) -> tuple[float, ...]:
        """A place of the file in the robot's frame."""
        pairs = zip(place_m, self._origin, strict=False)
        return as_written(tuple(round((place or 0.0) + zero, 9) for place, zero in pairs))

    def done(self) -> Drawn:
        """Everything that was taken. Raises ConfigError where that is nothing, or any is wrong."""
        self._refuse()
        assert self._start is not None
        self._wait_in_seconds()
        over = [f"{word} passed over ({_times(count)})" for word, count in self._over.items()]
        notes = [note.format(_times(count)) for note, count in self._notes.items() if count]
        if self._behind:
            lines = "one line" if self._behind == 1 else f"{self._behind} lines"
            notes.append(notes_of.AFTER.format(lines))
        legs, said, between = self._legs.legs(), (*over, *notes), tuple(self._between)
        return Drawn(self._start, legs, said, self._lines, self._start_line, between)

    def _refuse(self) -> None:
        if len(self._legs) > MOST_LEGS:
            raise ConfigError(
                f"{self._path}:{self._lines[-1]}: is move {MOST_LEGS + 1:,}, and a job has at most"
                f" {MOST_LEGS:,}; split the file before this line into several jobs"
            )
        if len(self.errors) > MOST_MISTAKES:
            self.errors[MOST_MISTAKES:] = [f"{self._path}: and more mistakes after these"]
        if self.errors:
            raise ConfigError(*self.errors)
        if self._start is None:
            raise ConfigError(f"{self._path}: holds no moves with X, Y and Z{self._too_early()}")
        if not self._legs:
            raise ConfigError(
                f"{self._path}:{self._start_line}: is the only place in it, where the path begins;"
                f" a path needs a move from there{self._too_early()}"
            )

    def _wait_in_seconds(self) -> None:
        """Only seconds have fractions: controllers that count milliseconds count whole ones."""
        if not self._waits:
            return
        seconds = self._means.p_is_seconds
        if seconds is None:
            seconds = self._fraction
            self._notes[notes_of.SECONDS if seconds else notes_of.MILLISECONDS] = len(self._waits)
        for number, holder, value in self._waits:
            if self._wait(holder, value if seconds else value / 1e3) > MOST_DWELL_S:
                raise ConfigError(f"{self._path}:{number}: G4 waits from nothing to an hour")

    def _too_early(self) -> str:
        """Why other moves are no part of the path, if there are any."""
        count = self._notes.get(notes_of.EARLY, 0)
        if not count:
            return ""
        early = notes_of.EARLY.format(_times(count))
        return f" ({early}: begin with a move that has all three, as G0 X0 Y0 Z5)"


def _times(count: int) -> str:
    return "once" if count == 1 else f"{count} times"
