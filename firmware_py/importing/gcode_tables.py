"""What words of G-code do: by themselves, and as a user says (--skip G28, --code "M3=fan on").

Held against NIST RS274NGC (IR 6556), LinuxCNC, grbl 1.1, Marlin 2, RepRapFirmware and Prusa's
firmware, which give some codes other meanings: where these differ in where the robot goes, or
whether it waits, the code is refused, or asked about.
"""

from __future__ import annotations

import re
from collections.abc import Collection, Iterable
from dataclasses import dataclass, field

from deltactl.firmware_py.importing.drawn import Point
from deltactl.foundation.errors import ConfigError

MILLISECONDS = "G4 P taken as milliseconds ({}); where they are seconds: --code G4=s"
SECONDS = "G4 P taken as seconds, as one has a fraction ({}); where not so: --code G4=ms"
EARLY = "moves before X, Y and Z are all known left out ({})"
EARLY_WAIT = "G4 before the first place left out ({})"
LEFT_OUT = "lines with / left out ({})"
CARRIED_OUT = "lines with / carried out ({})"
BY_WAY = "{} goes by way of the place that it names ({}); a 3D printer's goes straight home"
AFTER = "{} behind the end of the program left out"
"""What is said of what a file holds; {} is how often."""

MM_M, INCH_M = 1e-3, 0.0254
UNITS = {20.0: INCH_M, 21.0: MM_M}
MOVES = (0.0, 1.0, 2.0, 3.0)
ARCS = (2.0, 3.0)
AXES = "XYZ"
CENTRE = "IJK"
TURNED = "ABCUVW"
"""Letters of axes that a delta has not: nothing but 0 can be carried out."""

GROUPS: dict[str, tuple[float, ...]] = {
    "moves": MOVES,
    "planes": (17.0, 18.0, 19.0),
    "ways to give coordinates": (90.0, 91.0),
    "ways to give centres": (90.1, 91.1),
    "units": (20.0, 21.0),
}
"""A line may have one of each group (NIST IR 6556, table 4); beside a move G80 ends nothing, as
Vectric's programs have it in their first line."""

SILENT = frozenset({17.0, 40.0, 49.0, 54.0, 80.0, 90.1, 91.1, 94.0})
"""Settings that ask for what holds here anyway: plane XY, no tool, mm a minute, or are read."""

NO_AXES = frozenset({10.0, 28.1, 30.1, 50.0, 92.0, 92.1, 92.2})
"""Codes with which X, Y and Z would set something that is not kept here."""
WITHOUT_MEANING = NO_AXES | {11.0, 15.0, 43.0, 61.0, 61.1, 64.0, 69.0, 96.0, 97.0, 98.0, 99.0}
"""Filament, tool lengths, ends of what never began, exact stops: no part of a path; noted."""

WORDS_OF: dict[float, str] = {10.0: "S", 40.0: "D", 43.0: "HXYZ", 49.0: "H", 64.0: "PQ", 96.0: "D"}
"""Words that a code may carry beside those that any line may."""
ANYWHERE = frozenset("FSTE")
"""Feed, spindle or laser, tool, extruder: no place, on whatever line they are."""
OWN_WORDS = NO_AXES | {4.0, 27.0, 28.0, 30.0}
"""Codes whose X, Y and Z are no place to go to."""

_MACHINE = (
    'goes to a place that the machine knows; say --code "G{0:g}=X Y Z" with that place in the'
    " file's mm, or --skip G{0:g}"
)
_ORIGIN = "moves the origin; give it once, by --origin"
_OFFSETS = "other origins are not known here; use one (G54), which --origin places"
_RADIUS = "the tool's radius is not taken off; let the program that made the file do it"
_TIP = "moves the tool's tip; give one --origin"
_CYCLE = "is a cycle for drilling; let the program that made the file write its moves"
_PROBE = "moves until something is touched; no job does that: --skip G{0:g}, or delete the line"
_CURVE = "curves of this kind are not taken; let the program that made the file write arcs or lines"
REFUSED: dict[float, str] = {
    7.0: "diameters are not taken; give radii (G8)",
    12.0: _PROBE.replace("until something is touched", "as the machine says"),
    16.0: "polar coordinates are not taken; give X and Y (G15)",
    18.0: "arcs in XZ cannot be made; arcs lie in XY (G17)",
    19.0: "arcs in YZ cannot be made; arcs lie in XY (G17)",
    51.0: "scales the path; let the program that made the file do it",
    53.0: "is a place in the machine's own frame; give it in the file's, which --origin places, or"
    " --skip G53",
    68.0: "turns the path; let the program that made the file do it",
    93.0: "F as a time is not taken; let F be a speed (G94)",
    95.0: "F for a turn of the spindle is not taken; let F be a speed (G94)",
    **dict.fromkeys((27.0, 28.0, 30.0), _MACHINE),
    **dict.fromkeys((41.0, 41.1, 42.0, 42.1), _RADIUS),
    **dict.fromkeys((43.1, 43.2), _TIP),
    **dict.fromkeys((52.0, 92.0, 92.3), _ORIGIN),
    **dict.fromkeys((5.0, 5.1, 5.2, 5.3, 6.0, 33.0), _CURVE),
    **dict.fromkeys((55.0, 56.0, 57.0, 58.0, 59.0, 59.1, 59.2, 59.3), _OFFSETS),
    **dict.fromkeys((73.0, 76.0, *map(float, range(81, 90))), _CYCLE),
    **dict.fromkeys((29.0, 29.1, 29.2, 32.0, 34.0, 35.0, 38.2, 38.3, 38.4, 38.5), _PROBE),
}
"""What would change the path, and what to do instead."""
OTHER = "is not taken; G0 to G4, G17, G20, G21, G90, G91, G90.1, G91.1 are"

SKIPPABLE = frozenset(
    {12.0, 27.0, 28.0, 29.0, 29.1, 29.2, 30.0, 32.0, 34.0, 35.0, 38.2, 38.3, 38.4, 38.5, 53.0}
)
"""G codes that --skip may leave out: they go to places that only the machine knows."""
PLACED = frozenset({27.0, 28.0, 30.0})
"""G codes for which --code may name a place."""

ENDS = frozenset({2.0, 30.0})
"""M words after which nothing is carried out."""
TOOL = 6.0
PAUSES: dict[float, str] = {
    0.0: "stop of the program",
    1.0: "optional stop of the program",
    60.0: "change of the part",
    125.0: "park and pause",
    600.0: "change of the filament",
    TOOL: "change of the tool",
    **dict.fromkeys((25.0, 226.0, 601.0), "pause of the print"),
}
"""M words at which a hand may be in the machine: the job waits for `resume`."""
SPINDLE = frozenset({3.0, 4.0})
"""M words after which an S on any line is a speed or a power, and S0 is off."""
SWITCHES = SPINDLE | {5.0, 7.0, 8.0, 9.0, 10.0, 11.0, 106.0, 107.0, 126.0, 127.0}
"""M words that switch something which --code may name as an output; S0 with one is off."""
SHARED = frozenset({3.0, 4.0, 5.0, TOOL, 7.0, 8.0, 9.0, 19.0, 60.0}) | ENDS
"""M words of spindle, coolant, tool and end: a line with one may move too (NIST IR 6556). Any
other takes the words of its line for itself: `M205 X8` is no place."""
ALONE = frozenset({48.0, 49.0})
"""Switches of LinuxCNC for the feed; with words, a test of Marlin that moves."""
PAUSES_WITH = {400.0: "U"}
"""A wait for the moves before it, which has none to wait for; with this letter, for a person."""
STOPS_WITH_TEXT = frozenset({0.0, 1.0})
"""Words in RS-274; a message in Marlin."""

_CALLS = "calls another part of the program, or another file; write it out"
_SHIFTS = "moves the origin or the tool; give one --origin"
_ENDS_ALL = "ends everything at once; delete the line, or write M2"
_AWAITS = "waits for an input; write a job with 'wait_for' (docs/jobs.md), or --skip {0}"
_RESTORES = "restores settings that were saved; write them out (G90, G20, ...)"
_BY_ITSELF = "moves the machine as it knows; --skip {0} leaves it out, --code {0}=pause waits there"
REFUSED_M: dict[float, str] = {
    28.0: "writes what follows to a card; delete the line",
    29.0: "ends what M28 began; delete the line",
    66.0: _AWAITS,
    808.0: "repeats what follows; write it out, or use 'repeat' in a job (docs/jobs.md)",
    **dict.fromkeys((23.0, 32.0, 97.0, 98.0, 99.0, 810.0), _CALLS),
    **dict.fromkeys((206.0, 218.0, 290.0, 428.0), _SHIFTS),
    **dict.fromkeys((112.0, 410.0, 524.0, 999.0), _ENDS_ALL),
    **dict.fromkeys((70.0, 72.0), _RESTORES),
    **dict.fromkeys((602.0, 603.0, 701.0, 702.0), _BY_ITSELF),
}
UNKNOWN_M = "is not known here; if it moves nothing and waits for nothing: --skip {0}"
SPEED_FACTOR = 220.0
PROGRESS = 73.0
"""A percentage in Marlin, with P, R, Q or S; alone it saves settings in LinuxCNC."""


def _numbers(text: str) -> frozenset[float]:
    found: set[float] = set()
    for part in text.split():
        first, _, last = part.partition("-")
        found |= {float(one) for one in range(int(first), int(last or first) + 1)}
    return frozenset(found)


WITHOUT_MEANING_M = SWITCHES | _numbers(
    "15-22 24 26 27 31 33 34 42 43 48-53 61-65 67 68 71 73-78 80-86 92 100-111 113-124 128 129"
    " 140-145 149-151 154-156 163-166 190-193 200-205 207-217 219-221 225 230-233 240 250-252"
    " 255-257 260 261 280-282 293-295 300-309 321-323 340 350 351 355 360-364 371 372 400-409"
    " 411-415 420-427 430 450-453 486 493 500-511 540 550-599 604 605 665 666 672 710 851 852"
    " 860-869 871 900 905-919 928 950-957 993 995 997"
)
"""Heaters, fans, limits, tuning, cards, displays, reports: no part of a path; noted."""
TEXTS = frozenset({16.0, 115.0, 117.0, 118.0, 486.0}) | _numbers("550-559 587-589 860-869")
"""M words whose text may be anything, also what looks like another code."""
_OBJECTS = ("OBJECT", "OBJECT_DEFINE", "OBJECT_END", "OBJECT_START")
_SETTINGS = (
    "DISPLAY_TEXT FAN_SPEED HEATER_TEMPERATURE LED PRESSURE_ADVANCE PRINT_STATS_INFO VELOCITY_LIMIT"
)
MACROS = frozenset(
    {"BED_MESH_PROFILE", "RESPOND", "TEMPERATURE_WAIT", "TIMELAPSE_TAKE_FRAME"}
    | {f"EXCLUDE_{name}" for name in _OBJECTS}
    | {f"SET_{name}" for name in _SETTINGS.split()}
)
"""Commands of Klipper that move nothing; any other is a macro that may."""


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
