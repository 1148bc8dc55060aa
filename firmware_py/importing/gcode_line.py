"""One line of G-code, judged: which of its words are places, settings, switches, waits or nothing.

Each word is taken by a code that may carry it, passed over by name, or the line is refused. Arcs
have their centre by I and J from where they begin, by I and J as a place, or by R.
"""

from __future__ import annotations

import math
import re
from dataclasses import dataclass, field

import numpy as np

from deltactl.firmware_py.importing.gcode_tables import (
    ALONE,
    ANYWHERE,
    AXES,
    CENTRE,
    ENDS,
    GROUPS,
    MOVES,
    NO_AXES,
    OTHER,
    OWN_WORDS,
    PAUSES,
    PAUSES_WITH,
    PLACED,
    PROGRESS,
    REFUSED,
    REFUSED_M,
    SHARED,
    SILENT,
    SPEED_FACTOR,
    SPINDLE,
    STOPS_WITH_TEXT,
    TEXTS,
    TOOL,
    TURNED,
    UNKNOWN_M,
    WITHOUT_MEANING,
    WITHOUT_MEANING_M,
    WORDS_OF,
    Meanings,
)
from deltactl.firmware_py.importing.gcode_words import Word, words_of
from deltactl.firmware_py.path_file import LEAST_RADIUS_M, same_radius

WAIT = 4.0
EXTRUDER, RETRACTION = 92.0, 10.0
"""Codes that a printer gives its filament, and other machines their origins."""
_TAKEN = frozenset({WAIT, *SILENT, *(code for group in GROUPS.values() for code in group)})
_ARGUMENTS = re.compile(
    r"(?:\s*[A-Za-z](?:[ \t]*[-+]?(?:\d+\.?\d*|\.\d+)(?=[\sA-Za-z]|$)|(?=\s|$)))*\s*", re.ASCII
)
_CODE_WITHIN = re.compile(r"(?<![A-Za-z])[GgMm]\s*\d")
_POWER = re.compile(r"[sS]\s*([-+]?(?:\d+\.?\d*|\.\d+))")
_FIRST_M = re.compile(r"\s*(?:[nN]\s*\d+\s*)?[mM]\s*(\d+)(?![\d.])(.*)", re.ASCII)
_PLAIN = re.compile(
    r"G0{0,2}([0-3])((?:[ \t]+[XYZIJRFE][-+]?(?:\d{1,9}(?:\.\d{0,15})?|\.\d{1,15}))+)[ \t]*",
    re.ASCII,
)
"""A move whose words are separated: nothing in it can be meant otherwise."""
_PLAIN_WORD = re.compile(r"([A-Z])(\S+)")
_LETTER = re.compile(r"[A-Za-z]")


@dataclass(slots=True)
class Command:
    """What one line asks for, in the order in which a controller does it."""

    codes: list[float] = field(default_factory=list)
    """G words."""
    given: dict[str, float] = field(default_factory=dict)
    """All other numbers, by letter."""
    bare: set[str] = field(default_factory=set)
    """Letters without a number."""
    switched: dict[str, bool] = field(default_factory=dict)
    """Outputs of the robot file."""
    powered: str = ""
    """The output whose spindle, laser or fan an S word switches from now on."""
    paused: list[str] = field(default_factory=list)
    """Why a person is waited for."""
    changes_tool: bool = False
    """Whether that is for a tool, which at first is the one that is in."""
    ends: str = ""
    """The M word that ends the program."""
    passed: list[str] = field(default_factory=list)
    """Words that mean nothing here."""
    skipped: list[float] = field(default_factory=list)
    """G codes that --skip leaves out, with the places of their line."""

    @property
    def has_others(self) -> bool:
        """Whether there are words beside M words."""
        return bool(self.codes or self.given or self.bare)


def takes_rest(number: float, rest: str) -> bool:
    """Whether an M word has the rest of its line for itself: its arguments, or a text."""
    if number in STOPS_WITH_TEXT | ENDS:
        return _ARGUMENTS.fullmatch(rest) is None
    return number not in SHARED


def command_of(line: str, means: Meanings) -> Command:
    """What a line asks for. Raises ValueError with what is wrong, and what to do."""
    if plain := _PLAIN.fullmatch(line):  # what nearly all lines of a long file are
        pairs = _PLAIN_WORD.findall(plain[2])
        given = {letter: float(number) for letter, number in pairs}
        if len(given) == len(pairs):
            return Command([float(plain[1])], given, passed=["E"] if "E" in given else [])
    command = Command()
    for word in _words(line):
        if word.letter == "M":
            _take_m(command, word, means)
        elif word.value is None:
            command.bare.add(word.letter)
        elif word.letter == "G":
            command.codes.append(word.value)
        elif word.letter in command.given:
            raise ValueError(f"two words {word.letter} on one line")
        else:
            command.given[word.letter] = word.value
    if command.has_others:
        _judge(command, means)
    if command.given.get("S") == 0.0:  # a speed or a power of nothing beside what switches on
        command.switched = dict.fromkeys(command.switched, False)
    return command


def _words(line: str) -> list[Word]:
    """The words of a line; an M word with a text is alone on it."""
    text = _FIRST_M.match(line)
    if text is not None and float(text[1]) in TEXTS:
        return [Word("M", float(text[1]), text[2].strip())]
    return words_of(line, takes_rest)


def _m_number(command: Command, word: Word) -> float:
    """The number of an M word. Raises ValueError where it is none, or has to be alone."""
    number, rest = word.value, word.rest or ""
    if number is None or number < 0.0 or (number % 1.0 and int(number) not in TEXTS):
        raise ValueError(f"'{word.text}' is no M word")
    if int(number) not in TEXTS and (within := _CODE_WITHIN.search(rest)):
        raise ValueError(f"{word.text} and {within[0]} on one line; give each a line of its own")
    if rest and command.has_others:
        raise ValueError(f"{word.text} with words of its own; give it a line of its own")
    return number


def _take_m(command: Command, word: Word, means: Meanings) -> None:
    number, text, rest = _m_number(command, word), word.text, word.rest or ""
    if text in means.switched:
        output, is_on = means.switched[text]
        power = _POWER.search(rest)
        command.switched[output] = is_on and (power is None or float(power[1]) != 0.0)
        command.powered = command.powered or (output if is_on and number in SPINDLE else "")
    elif text in means.skipped:
        command.passed.append(text)
    elif number in ENDS:
        if rest:
            raise ValueError(f"{text} with '{rest[:40]}' is not understood; M2 or M30 alone end")
        command.ends = text
    elif text in means.paused or number in PAUSES or _waits_for_a_person(number, rest):
        told = PAUSES.get(number, "wait")
        command.paused.append(f"{text}, {told}" + (f": {rest}" if rest else ""))
        command.changes_tool |= number == TOOL and text not in means.paused
    else:
        _pass_over(command, number, text, rest)


def _waits_for_a_person(number: float, rest: str) -> bool:
    return number in PAUSES_WITH and PAUSES_WITH[number] in rest.upper()


def _pass_over(command: Command, number: float, text: str, rest: str) -> None:
    """An M word that means nothing here, noted with its own words. Raises ValueError."""
    if number in REFUSED_M:
        raise ValueError(f"{text} {REFUSED_M[number].format(text)}")
    if int(number) not in WITHOUT_MEANING_M | SHARED:
        raise ValueError(f"{text} {UNKNOWN_M.format(text)}")
    if (number in ALONE and rest) or (number == PROGRESS and not rest):
        raise ValueError(f"{text} {UNKNOWN_M.format(text)}")
    part = _POWER.search(rest)
    if number == SPEED_FACTOR and part is not None and float(part[1]) != 100.0:
        raise ValueError(f"{text} changes all speeds; give the speeds themselves, and --speed")
    if not rest:
        command.passed.append(text)
    elif int(number) in TEXTS or _ARGUMENTS.fullmatch(rest) is None:
        command.passed.append(f"{text} and its text")
    else:
        letters = ", ".join(dict.fromkeys(_LETTER.findall(rest.upper())))
        command.passed.append(f"{text} with {letters}")


def _judge(command: Command, means: Meanings) -> None:
    """The G codes of a line, and each letter. Raises ValueError."""
    for name, group in GROUPS.items():
        if sum(code in group for code in command.codes) > 1:
            listed = ", ".join(f"G{code:g}" for code in group)
            raise ValueError(f"two of the {name} {listed} on one line")
    for code in command.codes:
        text = f"G{code:g}"
        if text in means.skipped:
            command.skipped.append(code)
        elif text not in means.places_m:
            _judge_code(command, code, text)
    if command.skipped:
        _skip_line(command)
        return
    _refuse_shared_words(command)
    _judge_letters(command)


def _refuse_shared_words(command: Command) -> None:
    """Raise ValueError where the places of a line could be those of two codes, or of none."""
    own = [code for code in command.codes if code in OWN_WORDS]
    if len(own) > 1 or (own and any(code in MOVES for code in command.codes)):
        raise ValueError(f"G{own[0]:g} and another code on one line; give each a line of its own")
    if own and own[0] in NO_AXES and (axes := set(command.given) & set(AXES)):
        raise ValueError(f"{min(axes)} has no meaning here on a line with G{own[0]:g}; delete one")


def _judge_code(command: Command, code: float, text: str) -> None:
    letters = set(command.given)
    of_filament = code == EXTRUDER and "E" in letters and not letters & set(AXES + TURNED)
    if of_filament or (code == RETRACTION and not letters & {"L", "P"}):
        command.passed.append(text)
    elif code == RETRACTION:
        raise ValueError(f"{text} {REFUSED[EXTRUDER]}")
    elif code in REFUSED:
        raise ValueError(f"{text} {REFUSED[code].format(code)}")
    elif code in WITHOUT_MEANING:
        command.passed.append(text)
    elif code not in _TAKEN:
        raise ValueError(f"{text} {OTHER}")


def _skip_line(command: Command) -> None:
    """The places of a line that is left out are left out; its settings stay."""
    command.passed += [f"G{code:g}" for code in command.skipped]
    command.codes = [code for code in command.codes if code not in (*command.skipped, *MOVES)]
    command.passed += [letter for letter in command.given if letter in "ST"]
    command.given = {key: value for key, value in command.given.items() if key in (*AXES, "F")}
    command.given |= dict.fromkeys(command.bare & set(AXES), 0.0)


def _letters_beside(codes: set[float]) -> set[str]:
    """What a line with these codes may carry."""
    if WAIT in codes:
        return set("PSXU")
    if codes & PLACED:
        return {*AXES, *ANYWHERE}
    if EXTRUDER in codes:
        return set("ES")
    own = {letter for code in codes for letter in WORDS_OF.get(code, "")}
    return {*AXES, *ANYWHERE, *CENTRE, "R", *own}


def _judge_letters(command: Command) -> None:
    codes = set(command.codes)
    may = _letters_beside(codes)
    homed = set(AXES) if codes & PLACED else set()
    if bare := command.bare - homed:
        raise ValueError(f"{min(bare)} has no number")
    if "O" in command.given:
        raise ValueError("O words (loops, calls) are not carried out; write the moves out")
    for letter, value in command.given.items():
        if letter in TURNED and letter not in may:
            if value != 0.0:
                raise ValueError(
                    f"{letter}{value:g}: a delta has the axes X, Y and Z; take {letter} out of the"
                    " program that made the file"
                )
            command.passed.append(letter)
        elif letter not in may:
            raise ValueError(f"{letter}{value:g} has no meaning on this line; correct or delete it")
        elif letter == "T":
            command.passed.append(f"T{value:g}")
        elif letter not in (*AXES, *CENTRE, "R", "F") and WAIT not in codes:
            command.passed.append(letter)


Place = tuple[float, float]
ROUND = 1e-3
"""Coordinates are rounded in files: R may be so much too short for a half turn."""
SAME_M = 1e-9


def check_words(words: dict[str, float], placed: bool) -> None:
    """Whether an arc has what it needs, wherever it begins. Raises ValueError."""
    given = {"I", "J"} & set(words)
    if "R" in words:
        if given:
            raise ValueError("an arc has its centre (I, J) or its radius (R), not both")
    elif placed and len(given) < 2:
        raise ValueError("an arc under G90.1 needs I and J, the place of its centre")
    elif not given:
        raise ValueError("an arc needs I and J, from its beginning to its centre, or its radius R")


def centre_by_words(
    begin: Place, end: Place, words: dict[str, float], unit_m: float, clockwise: bool, placed: bool
) -> Place:
    """The centre [m] of an arc from `begin` to `end` [m]; placed: I and J are a place (G90.1).

    Raises ValueError with what is wrong. The words are those that check_words lets pass.
    """
    if "R" in words:
        return _by_radius(begin, end, words["R"], unit_m, clockwise)
    east_m, north_m = words.get("I", 0.0) * unit_m, words.get("J", 0.0) * unit_m
    centre = (east_m, north_m) if placed else (begin[0] + east_m, begin[1] + north_m)
    first_m, last_m = math.dist(begin, centre), math.dist(end, centre)
    if min(first_m, last_m) < LEAST_RADIUS_M:
        raise ValueError("an arc's centre (I, J) is one of its ends; it has no radius")
    if not same_radius(np.array(first_m), np.array(last_m)):
        raise ValueError(
            f"an arc's radius is {first_m / unit_m:.6g} where it begins and {last_m / unit_m:.6g}"
            " where it ends; at most 0.1 % may be between them: is it G90.1 or G91.1, G20 or G21?"
        )
    return centre


def _by_radius(begin: Place, end: Place, radius: float, unit_m: float, clockwise: bool) -> Place:
    """R below 0 is the longer way round."""
    chord_m, radius_m = math.dist(begin, end), abs(radius) * unit_m
    if chord_m < SAME_M:
        raise ValueError("an arc by R needs another place to end at; whole turns by I, J")
    if chord_m > 2.0 * radius_m * (1.0 + ROUND) + SAME_M:
        raise ValueError(
            f"R {radius:g} cannot reach: half the distance is {chord_m / 2.0 / unit_m:.6g}"
        )
    # Left of the chord lies the centre of a short counter-clockwise arc.
    height_m = math.sqrt(max(0.0, radius_m**2 - chord_m**2 / 4.0))
    side = -height_m if clockwise != (radius < 0.0) else height_m
    east, north = ((b - a) / chord_m for a, b in zip(begin, end, strict=True))
    return (
        begin[0] + east * chord_m / 2.0 - north * side,
        begin[1] + north * chord_m / 2.0 + east * side,
    )
