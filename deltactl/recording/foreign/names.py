"""What people call their columns: words of several trades and languages, and units in names."""

from __future__ import annotations

import itertools
import re
import unicodedata
from collections.abc import Mapping, Sequence
from dataclasses import dataclass

from deltactl.recording.foreign.units import (
    CLOCKS,
    LINEAR,
    LONE,
    LONE_UNITS,
    ROTARY,
    UNIT_APART,
    UNIT_OF,
    UNIT_WORDS,
    UNITS_OF,
)

WORDS: dict[str, str] = {
    "t": "t time timestamp stamp timestamps zeit zeitstempel uhrzeit datetime temps tiempo sec "
    "secs second seconds clock elapsed",
    "command": "command cmd target setpoint set_point reference ref goal goal_position desired des "
    "soll sollwert set set_pos setpos pos_set set_position consigne action demand goal_pos q_des "
    "qd_ref q_d commanded target_position commanded_position desired_position reference_position "
    "x_ref pos_ref wanted goto objetivo obiettivo expected nominal leader gcode",
    "position": "position pos angle theta actual measured encoder enc q ist istwert state present "
    "present_position pos_fbk feedback fbk joint_position joint_pos winkel weg x "
    "y_meas output resolver "
    "actual_position measured_position observation laser encoderwert lage messwert gemessen "
    "angolo angulo posizione posicion mesure mesuree reel reelle readback rbv star dial caliper "
    "indicator messuhr dro glass follower",
    "velocity": "velocity vel speed omega dq qd dot rate geschwindigkeit drehzahl vitesse "
    "velocidad velocita present_velocity rpm",
    "effort": "effort torque tq trq current force tau voltage control u i_q iq drehmoment strom "
    "spannung stellgroesse stellsignal moment kraft couple courant corriente corrente motorstrom "
    "cur i_actual i_act i_meas i_motor load_current motor_current motor_torque present_current pwm",
    "load": "load payload external_force weight",
    "distance": "distance truth true true_distance ground_truth reference_distance actual_distance "
    "known_distance abstand entfernung distanz surveyed ruler",
    "range": "range reading measured_distance tof lidar sensor sensor_distance ultrasonic dist "
    "anzeige gemessene_entfernung vl53l0x vl53l1x",
    "steps": "steps step counts count pulses pulse microsteps ticks step_count "
    "schritte schritt schrittzahl zaehler impulse pas pasos passi",
    "segment": "segment run trial stretch episode episode_index spot site",
    "temp_c": "temp temperature temp_c",
}
"""Column of the contract -> words for it, in lower case."""
ROLE_OF = {word: role for role, words in WORDS.items() for word in words.split()}


def _words(text: str) -> frozenset[str]:
    return frozenset(text.split())


PULLS = _words("pull load torque moment nm n force current effort tau amps ampere kraft")
"""Words of what pulls or drives, in names of columns that are not used."""
_BRACKETED = re.compile(r"\s*[\[(]\s*(?!\d+\s*[\])])([^\])]+?)\s*[\])]\s*$")
"""Text in brackets at the end that is no number, unlike that of a joint: position[0]."""
_MILLI = re.compile(r"(?<![A-Za-z])(mA|mN|mNm)$")
"""Units in which a capital begins no word."""
_CAPITAL = re.compile(r"(?<=[a-z])(?=[A-Z])|(?<=[A-Z])(?=[A-Z][a-z])")
"""Where a word begins with a capital: goalPos, AIPos."""
_LAST = re.compile(r"(\w+)_([123xyz])")
_NUMBERED = re.compile(r"^(.*?)(?:_?(?=[0-3])|_(?=[xyz]))([0-3xyz])$")
_NUMBERED_INSIDE = re.compile(r"^(.*[a-z])_?([0-3])_([a-z_]+)$")
"""As q1_ref and joint_2_pos: what is numbered, the number, and which value of it."""
MEASURED = _words(
    "actual measured estimated estimate feedback fbk fb present act meas ist follower"
)
"""Words that say that a value was measured, not asked for."""
TORQUES = _words("torque force effort tau moment drehmoment kraft couple nm")
"""Words of an effort in the unit that moves a mass; a current or a voltage counts as one."""
QUALIFIES = frozenset(["control", "ctrl", "input"])
"""Words that say beside a quantity that it was asked for: control_torque, input_pos."""
SUPPLY = frozenset(["bus", "supply", "dc", "battery", "versorgung"])
"""Words of what feeds a drive, which says nothing of the motion."""
SEEN = frozenset(["act", "meas", "mes", "fb", "fbk", "is"])
"""Short words for what was measured, which say so only after a number."""
OF_SURROUNDINGS = _words(
    "temp temperature temperatur humidity feuchte pressure luftdruck wind rain regen co2"
    " illuminance lux brightness dewpoint"
)
"""Words of what moves no axis, whatever else is in the name: temp_setpoint, pressure_actual."""
OF_NO_USE = _words(
    "accel acceleration beschleunigung gyro jerk error err ferror fehler schleppfehler"
    " schleppabstand deviation abweichung duration direction mass snr"
)
"""Words of what is neither asked for nor read, whatever else is in the name: accel_x."""
OF_JOINTS = _words(
    "shoulder elbow wrist pan tilt roll pitch yaw gripper joint gelenk angle winkel theta angolo"
    " angulo az azm azimuth alt altitude elevation ra dec declination"
)
"""Words of what turns."""
OF_MACHINE = re.compile(r"(?i)joint\.\d+\.(motor-)?pos-(cmd|fb)")
"""Pins of LinuxCNC, whose joints turn or slide, in the units of the machine."""
IS_PRESENT = "current"
"""Also says that something is as it is now, before another word: current_position."""
OF_A_SERVO = "present"
"""A servo's present_load is what its motor gives, as its present_current."""
TOGETHER: tuple[tuple[frozenset[str], str | None], ...] = (
    (_words("command velocity"), None),  # a speed that was asked for: of no use here
    (_words("command effort"), "effort"),
    (frozenset(["load", OF_A_SERVO]), "effort"),
    *((_words(one), one) for one in ("t", "command", "velocity", "effort", "steps", "range")),
)
"""What names say whose words have these roles, the first that fits: a target_position is a command,
a measured_distance a range."""
OUTSIDE = _words("torque force moment drehmoment kraft couple coppia nm n ncm mnm")
"""Words of an effort that may as well pull from outside; a current or a voltage never does."""
OF_A_DRIVE = _words("motor drive servo actuator antrieb")
"""Words of what gives an effort, and no weight does."""
OF_ENCODER = frozenset(["encoder", "enc", "resolver"])
"""Words of what counts the motion that came of a command."""
ANALOGUE = _words(
    "pot poti potentiometer potmeter adc analog analogue analogread ain a0 a1 a2 a3 a4 a5"
)
"""Words of a voltage that a converter counts, as that of a potentiometer."""
PULSES = _words("pulse pulses puls pulsewidth width pw pwm us usec micros microseconds servo")
"""Words of the pulses that command a hobby servo."""
OF_A_PART = _words("wert motor achs achse axis ax gelenk joint arm servo mess")
"""Words that say nothing by themselves, and occur in compounds: Sollwert, motorangle."""
PHASES = frozenset(["i", "iq", "id", "u", "v", "w"])
"""Letters that say, with a number and `act`, that a current or a voltage was measured."""
_SAY_WHAT = ROLE_OF.keys() | MEASURED | QUALIFIES | SEEN | OF_A_PART | UNIT_OF.keys() | {""}
_SHORTEST = 3
"""Letters of a word in a compound."""


@dataclass(frozen=True, slots=True)
class Named:
    """What a column's name says: its role, its unit, and a number or axis at its end."""

    role: str | None
    unit: str | None
    index: str | None
    asked: bool = False
    """Whether it was asked for, which says something of an effort: others were measured."""
    used: bool = True
    """False of an acceleration, an error and the like, whatever its numbers look like."""


BY_NAME = "by its name"
AS_SAID = "as you say"
ALONE = "it alone increases all the way"


@dataclass(frozen=True, slots=True)
class Factor:
    """What one of a column is, which nobody but the owner of the machine knows."""

    word: str
    """In a printed command in place of the number."""
    is_: str
    """What the column is."""
    says: str
    """What is to be put for it."""
    zero_known: bool = True
    """Whether what it makes of the column is 0 where the axis is."""


@dataclass(frozen=True, slots=True)
class Guess:
    """A column of a file and what it is taken for; `why` says from what."""

    source: str
    role: str
    index: str | None
    unit: str | None
    why: str
    scale: float = 1.0
    """How much of `unit` one of the column is."""
    unit_guessed: bool = False
    """Whether only the size of the values speaks for the unit."""
    factor: Factor | None = None
    """What its owner has to say in place of `scale`."""

    @property
    def unsaid(self) -> bool:
        """Whether neither a word nor a factor says the unit."""
        return self.scale == 1.0 and (self.unit is None or self.unit_guessed)

    @property
    def name(self) -> str:
        """The column's name in the contract; velocity and others have none with a number."""
        return self.role if self.index is None else f"{self.role}_{self.index}"


Taken = Mapping[str, Guess]
"""Columns of a file and what each is taken for."""


def of_role(guesses: Taken, *roles: str) -> list[str]:
    """Columns that are taken for one of the roles."""
    return [name for name, guess in guesses.items() if guess.role in roles]


def by_name(guesses: Taken) -> dict[str, Guess]:
    """Guesses by the columns' names in the contract."""
    return {guess.name: guess for guess in guesses.values()}


def read_name(name: str, unit_line: str = "") -> Named:
    """Take a name apart, as `Goal Angle 1 [deg]` or `joint1.pos_mm`."""
    bracketed = _BRACKETED.search(name)
    apart = [unit_line, *([bracketed[1]] if bracketed else [])]
    unit = next(filter(None, (UNIT_APART.get(one.lower()) for one in apart)), None)
    words = _words_of(without_unit(name))
    if len(words) == 1 and words[0] in CLOCKS:
        return Named("t", UNIT_OF[words[0]], None)
    if len(words) == 1 and words[0] in LONE_UNITS:
        return Named(None, UNIT_OF[words[0]], None)
    words, ending = _without_unit(words)
    unit, role = unit or ending, _role(words)
    if _of_no_use(words, role):
        return Named(None, unit, None, used=False)
    role, index, stem = _numbered(words, role)
    role = _with_unit(role, unit, words)
    if role == "steps" and unit in (*LINEAR, *ROTARY):
        role = "command"  # a counter that is read in mm
    elif role == "steps" and (MEASURED | OF_ENCODER).intersection(words):
        role = "position"
    asked = "command" in {ROLE_OF.get(word) for word in [*words, *stem]} or _qualified(words)
    return Named(role, unit, index, asked)


def _with_unit(role: str | None, unit: str | None, words: Sequence[str]) -> str | None:
    """The role of a name with a unit: q is a position, and q_A a current; angle_a is none."""
    if role not in LONE or unit is None or unit in UNITS_OF[role]:
        return role
    if any(len(word) > 1 and ROLE_OF.get(word) == role for word in words):
        return role
    return next((other for other in ("effort", "velocity") if unit in UNITS_OF[other]), role)


def _words_of(name: str) -> list[str]:
    """The words of a name in lower case, those of compounds one by one: goalPos, Sollwinkel."""
    name = _plain_letters(name.strip())
    plain = _CAPITAL.sub("_", _MILLI.sub(lambda at: at[0].lower(), name))
    words = filter(None, re.split(r"[^0-9a-zµ°]+", plain.lower()))
    return [part for word in words for part in _parts(word)]


def _of_no_use(words: list[str], role: str | None) -> bool:
    """Whether words say that a column is neither asked for nor read, whatever its numbers are."""
    no_use = (OF_NO_USE | SUPPLY).intersection(words) or _asks_for_speed(words)
    return bool(no_use or (role != "temp_c" and OF_SURROUNDINGS.intersection(words)))


def _numbered(words: list[str], role: str | None) -> tuple[str | None, str | None, list[str]]:
    """Role of a name, the number of its joint, and the words beside the number.

    role: that of all words together, which counts where those beside the number have none.
    """
    whole, index = "_".join(words), None
    stem, number = list[str](), None
    if (numbered := _NUMBERED.match(whole)) and numbered[1]:
        parts = (_parts(word) for word in numbered[1].split("_"))
        stem, number = list(itertools.chain.from_iterable(parts)), numbered[2]
    elif whole not in ROLE_OF and (inside := _NUMBERED_INSIDE.match(whole)):
        after = inside[3].split("_")
        stem, number = [*inside[1].split("_"), *after], inside[2]
        stem = stem if (set(ROLE_OF) | SEEN).intersection(after) else []
        if SEEN.intersection(after) and _role(stem) is None and stem[0] not in PHASES:
            role, index = "position", number
    stem = [word for word in stem if word]
    if (stemmed := _role(stem)) is not None:
        role, index = stemmed, number
    elif SEEN.intersection(stem) and not set(stem) - SEEN - OF_A_PART:
        role, index = "position", number
    return role, index, stem


def of_contract(name: str) -> tuple[str, str | None]:
    """The role and the number or axis of a column of the contract: status_x, t_pwm, position."""
    numbered = _LAST.fullmatch(name)
    return (numbered[1], numbered[2]) if numbered else (name, None)


def _plain_letters(name: str) -> str:
    """A name with its umlauts written out and without accents: Zähler is Zaehler."""
    for letter, written in (("ä", "ae"), ("ö", "oe"), ("ü", "ue"), ("ß", "ss")):
        name = name.replace(letter, written)
    return "".join(
        one for one in unicodedata.normalize("NFD", name) if not unicodedata.combining(one)
    )


def _parts(word: str) -> list[str]:
    """The words of a compound, both of which are known: targetpos, Schrittzaehler, Sollwinkel."""
    known = ROLE_OF.keys() | SEEN | OF_A_PART
    if word in known:
        return [word]
    for ending, one in (("s", ""), ("ies", "y")):  # commands, velocities
        if word.endswith(ending) and (single := word.removesuffix(ending) + one) in known:
            return [single]
    for at in range(_SHORTEST, len(word) - _SHORTEST + 1):
        if word[:at] in known and word[at:] in known and ROLE_OF.keys() & {word[:at], word[at:]}:
            return [word[:at], word[at:]]
    return [word]


def _without_unit(words: list[str]) -> tuple[list[str], str | None]:
    """Words less a unit at their end, as in q_deg, dq_rad_s and dq_mm_per_s; and the unit."""
    for end in (["per", "s"], ["s"]):
        stem = words[: -len(end)]
        if words[-len(end) :] == end and len(stem) > 1 and stem[-1] in UNIT_OF:
            speed = f"{UNIT_OF[stem[-1]]}/s"
            if speed in UNIT_WORDS:
                return stem[:-1], speed
    if len(words) > 1 and words[-1] in UNIT_OF:
        return words[:-1], UNIT_OF[words[-1]]
    return words, None


def unit_said(heading: str, name: str) -> str | None:
    """The unit that a heading says of a column of the contract; None where it says none that such
    a column has, as `_s` of a position.
    """
    unit = read_name(heading).unit
    role = re.sub(r"_[123xyz]$", "", name)
    if role == "velocity" and unit is not None:
        unit = f"{unit}/s" if f"{unit}/s" in UNIT_WORDS else unit
    return unit if unit in UNITS_OF.get(role, ()) else None


def without_unit(name: str) -> str:
    """A column's name without a unit in brackets at its end."""
    return _BRACKETED.sub("", name)


def is_of_joint(name: str) -> bool:
    """Whether a name says that it is an angle, or is that of a joint that turns."""
    return not (OF_JOINTS.isdisjoint(in_words(name)) or OF_MACHINE.search(name))


def pulls(name: str) -> bool:
    """Whether a name sounds like a load, a torque or a current, as `pull_Nm` does."""
    return not PULLS.isdisjoint(in_words(name))


def may_be_outside(name: str) -> bool:
    """Whether a name says torque or force, as of a weight, and not that a drive gives it."""
    words = in_words(name)
    return not OUTSIDE.isdisjoint(words) and OF_A_DRIVE.isdisjoint(words)


def is_analogue(name: str) -> bool:
    """Whether a name is that of a voltage as a converter counts it: pot, adc, A0."""
    return not ANALOGUE.isdisjoint(_words_of(name))


def in_words(name: str) -> list[str]:
    """The words of a name, in lower case."""
    plain = re.sub(r"(?<=[a-z])(?=[A-Z])", "_", name)
    return re.split(r"[^a-z]+", f"{name} {plain}".lower())


def label_of(name: str) -> set[str]:
    """The words of a name that say neither a quantity nor how it came about: a joint's own."""
    return {w for one in in_words(without_unit(name)) for w in _parts(one)} - _SAY_WHAT


def _with_roles(words: list[str]) -> list[str]:
    """The words that have a role, in a name of several."""
    if _qualified(words):
        words = ["command" if word in QUALIFIES else word for word in words]
    known = [word for word in words if word in ROLE_OF]
    quantities = {word for word in known if len(word) > 1} - MEASURED - {IS_PRESENT}
    if IS_PRESENT in known[:-1] and quantities:
        known.remove(IS_PRESENT)  # x_current_feedback is a current
    return known


def _qualified(words: list[str]) -> bool:
    """Whether a word is beside a quantity of its own: control_position, control_torque."""
    other = {ROLE_OF.get(word) for word in words if word not in QUALIFIES}
    return bool(QUALIFIES.intersection(words) and other & {"position", "velocity", "effort"})


def _asks_for_speed(words: list[str]) -> bool:
    """Whether words are those of a speed that was asked for, which no position follows."""
    roles = {ROLE_OF.get(word) for word in words}
    return "velocity" in roles and ("command" in roles or _qualified(words))


def _role(words: list[str]) -> str | None:
    """The whole name first, then its words from the last to the first."""
    whole = "_".join(words)
    if whole in ROLE_OF:
        return ROLE_OF[whole]
    known = _with_roles(words)
    found = [ROLE_OF[word] for word in reversed(known)]
    there = {*found} | ({OF_A_SERVO} & {*words})
    said = (role for together, role in TOGETHER if together <= there)
    return next(said, next(iter(found), None))
