"""Tables of several joints, of which one at a time is an axis: numbered, or called by names."""

from __future__ import annotations

import itertools
import math
import re
import statistics
from collections.abc import Collection, Iterable, Iterator, Mapping, Sequence

import numpy as np

from deltactl.recording.column_measures import travel
from deltactl.recording.foreign.guess import LETTERED
from deltactl.recording.foreign.names import (
    MEASURED,
    SEEN,
    Taken,
    is_of_joint,
    label_of,
    of_role,
    read_name,
)
from deltactl.recording.foreign.options import GUESSES
from deltactl.recording.foreign.shapes import Table, correlation
from deltactl.recording.foreign.units import LONE, UNIT_OF
from deltactl.recording.format.messages import MOTORS
from deltactl.recording.reading.run import FloatArray
from deltactl.recording.tables.binary_tables import JOINTS

_NUMBERED = re.compile(r"(.*?[^\d._\[])[._\[]?(\d+)\]?([._][^\d]+)?")
_BEFORE = re.compile(r"(?P<axis>[^\W\d_]+\d*)[_. ](?P<of>.+)")
_BEHIND = re.compile(r"(?P<of>.+)[_. ](?P<axis>[^\W\d_]+)")
CARTESIAN = frozenset("xyzw")
"""Labels of what is no joint."""
NORMALISED = 100.0
"""LeRobot scales the way of a joint to this, up and down, unless it is set to use degrees."""
Group = Mapping[str, str]
"""Columns of one quantity by the number or name of the joint."""


def one_joint(
    table: dict[str, FloatArray], chosen: Collection[str], lone: bool = False
) -> tuple[dict[str, FloatArray], list[str]]:
    """The columns without those of other joints, and the names of these.

    chosen: columns that somebody named; their joint is kept, else the one that departs most from
    its command. Joints numbered one to three are the motors of a delta, unless somebody named one
    as a single axis.
    """
    others: dict[str, None] = {}
    beside = _beside_commands(table)
    most = 1 if lone else MOTORS
    found = [beside] if beside else [_numbered(table, most), *_labelled(table), *_axes(table)]
    sought = {*chosen}
    for groups in found:
        wanted = _wanted(groups, table, sought)
        for group in groups:  # one that the wanted joint has not is of the others alone
            kept = wanted or next(iter(group))
            others |= {name: None for j, name in group.items() if j != kept and name not in chosen}
            sought |= {group[kept]} if kept in group else set()
    return {name: one for name, one in table.items() if name not in others}, list(others)


def _wanted(groups: Sequence[Group], table: Table, chosen: Collection[str]) -> str | None:
    """The joint that is looked at; None where none of them moves."""
    named = next((j for group in groups for j, name in group.items() if name in chosen), None)
    motion = [group for group in groups if _role(group) in LONE]
    return named or _most_departing(motion if len(motion) > 1 else groups, table)


def of_other_joints(table: Table, found: Taken) -> list[str]:
    """Names of columns that are commands as well, of joints without numbers: shoulder, elbow.

    A second command of one joint has no word of its own: command_position, control_position.
    """
    if not any(guess.name == "command" for guess in found.values()):
        return []
    own = {w for n, one in found.items() if one.role in LONE for w in label_of(n)}
    others = [one for one in table if one not in found and read_name(one).role == "command"]
    return [one for one in others if label_of(one) - own and not _of_the_same(table, one, found)]


def _of_the_same(table: Table, name: str, found: Taken) -> bool:
    """Whether a command rests, or is the speed that goes with a command that is known: v_des."""
    if not np.nanstd(table[name]) > 0.0:
        return True
    slopes = [np.gradient(table[n]) for n, one in found.items() if one.name == "command"]
    return any(correlation(table[name], slope) >= GUESSES.alike_slope for slope in slopes)


def _role(group: Group) -> str | None:
    return read_name(next(iter(group.values()))).role


def _most_departing(groups: Sequence[Group], table: Table) -> str | None:
    """The joint whose reading departs most from its command for how far it goes, beside what all
    of them are late by; the first where none does clearly more, or without commands. None where
    none moves: a column of it rests, or is a copy of another.
    """
    still = _still(groups, table)
    moving = dict.fromkeys(j for group in groups for j in group if j not in still)
    asked = next((group for group in groups if _role(group) == LONE[0]), {})
    read = _read_of(asked, groups)
    pairs = {j: (table[asked[j]], table[read[j]]) for j in moving if j in asked and j in read}
    if not pairs:
        return next(iter(moving), None)
    late = statistics.median_low([_late(*pair) for pair in pairs.values()])
    apart = {joint: _departure(*pair, late) for joint, pair in pairs.items()}
    first, most = next(iter(apart)), max(apart, key=lambda joint: apart[joint])
    return most if apart[most] > GUESSES.as_far * apart[first] else first


def _still(groups: Sequence[Group], table: Table) -> set[str]:
    """Joints of which a column rests, or is a copy of another."""
    still = {joint for group in groups for joint, name in group.items() if not _moves(table[name])}
    for one, other in itertools.combinations(groups, 2):
        both = one.keys() & other.keys()
        still |= {j for j in both if np.array_equal(table[one[j]], table[other[j]], equal_nan=True)}
    return still


def departing_motor(table: Table, found: Taken) -> str | None:
    """The reading of the motor of three that departs most from its command; None where there are
    not three of both, or a platform is seen: then it is a delta.
    """
    named = {one.name: one.source for one in found.values()}
    numbers = [str(n + 1) for n in range(MOTORS)]
    asked, read = (
        {n: named[name] for n in numbers if (name := f"{role}_{n}") in named}
        for role in ("command", "theta")
    )
    if len(asked) < MOTORS or len(read) < MOTORS or of_role(found, "pos", "range"):
        return None
    return read[_most_departing([asked, read], table) or numbers[0]]


def _read_of(asked: Group, groups: Sequence[Group]) -> Group:
    """What came of commands: readings before what says nothing, the rather the more words they
    share; none where none is there.
    """
    words = label_of(next(iter(asked.values()), ""))
    others = [g for g in groups if g is not asked and _role(g) in (LONE[1], None) and _is_used(g)]

    def rank(group: Group) -> tuple[bool, int]:
        return _role(group) is None, -len(words & label_of(next(iter(group.values()))))

    return min(others, key=rank, default={})


def _is_used(group: Group) -> bool:
    return read_name(next(iter(group.values()))).used


def _late(asked: FloatArray, read: FloatArray) -> float:
    """Rows by which a reading follows its command."""
    slope = np.gradient(asked)
    return float(np.nansum((asked - read) * slope) / max(np.nansum(slope**2), 1e-300))


def _departure(asked: FloatArray, read: FloatArray, late: float) -> float:
    """How far a reading is from its command, beside its noise and where their zeros are the same,
    as a share of how far it goes.
    """
    apart, way = read - asked + late * np.gradient(asked), max(travel(read), 1e-300)
    apart = apart[np.isfinite(apart)]
    if len(apart) < GUESSES.fewest_in_common:
        return 0.0
    middle = float(np.median(apart))
    apart = apart - middle * (abs(middle) > GUESSES.zeros_apart * way)
    noise = float(np.var(np.diff(apart, 2))) / 6.0
    return math.sqrt(max(float(np.mean(apart**2)) - noise, 0.0)) / way


def _moves(values: FloatArray) -> bool:
    return bool(np.nanmax(values) > np.nanmin(values)) if np.isfinite(values).any() else False


def _numbered(names: Iterable[str], most: int) -> Sequence[Group]:
    """Columns of more joints than one machine has, or commands and readings of two: no delta has
    either.
    """
    stems = _by_stem(names)
    many: list[Group] = [group for group in stems.values() if len(group) > most]
    two = {stem: group for stem, group in stems.items() if len(group) == 2}
    found = many or (list(two.values()) if _asked_and_read(two) else [])
    fewer = [group for group in stems.values() if group not in found]
    return found + [g for g in fewer if found and _role(g) in ("velocity", "effort")]


def _by_stem(names: Iterable[str]) -> dict[str, dict[str, str]]:
    """Numbered columns, by the rest of their name and by their number."""
    stems: dict[str, dict[str, str]] = {}
    for name in names:
        if numbered := _NUMBERED.fullmatch(name):
            behind = re.split(r"[\W_]+", numbered[3] or "")  # one of several may slide: J3_cmd_mm
            stem = "_".join([numbered[1], *(one for one in behind if one.lower() not in UNIT_OF)])
            stems.setdefault(stem, {}).setdefault(numbered[2], name)
    return stems


def _axes(names: Collection[str]) -> Iterator[Sequence[Group]]:
    """Columns of axes with a word or letter of their own, before or behind the same quantities:
    X_SetPosition and Y_SetPosition, left_cmd and right_cmd, pos_x and pos_y.
    """
    for at in (_BEFORE, _BEHIND):
        whole = {one: group for one, group in _by_axis(names, at).items() if _asked_and_read(group)}
        if len(whole) < 2 or _may_be_arms(whole):
            continue
        if not _asked_and_read(set.intersection(*map(set, whole.values()))):
            continue
        stems = dict.fromkeys(stem for group in whole.values() for stem in group)
        yield [{one: g[stem] for one, g in whole.items() if stem in g} for stem in stems]


def _may_be_arms(labels: Collection[str]) -> bool:
    """Whether axes are called as the arms of a delta are."""
    return len(labels) == MOTORS and {one[-1] for one in labels} <= set("0123abcABC")


def _by_axis(names: Iterable[str], at: re.Pattern[str]) -> dict[str, dict[str, str]]:
    """Columns by their axis, and by their quantity."""
    axes: dict[str, dict[str, str]] = {}
    for found in filter(None, map(at.fullmatch, names)):
        if _is_label(found["axis"]):
            axes.setdefault(found["axis"], {})[found["of"]] = found[0]
    return axes


def _is_label(word: str) -> bool:
    """Whether a word may be that of an axis: no unit, and nothing that was asked for or read."""
    plain = word.rstrip("xyzXYZ")  # which at the end of other names is a place
    spelled = word if len(word) == 1 else word.lower()  # S is an axis, s is none
    return read_name(plain).role is None and spelled not in MEASURED | SEEN | UNIT_OF.keys()


def _labelled(names: Collection[str]) -> Iterator[Sequence[Group]]:
    """Commands and readings of joints that have the same names: action.elbow and state.elbow, or
    elbow.desired and elbow.actual.
    """
    below: dict[str, dict[str, str]] = {}
    for name in names:
        for dot in re.finditer(r"\.", name):
            before, behind = name[: dot.start()], name[dot.end() :]
            below.setdefault(before, {})[behind] = name
            below.setdefault(behind, {})[before] = name
    alike: dict[frozenset[str], dict[str, Group]] = {}
    for stem, group in below.items():
        if (
            len(group) > 1
            and not {one.lower() for one in group} <= CARTESIAN
            and not any(map(_is_number_or_speed, group))
        ):
            alike.setdefault(frozenset(group), {})[stem] = group
    yield from (list(groups.values()) for groups in alike.values() if _asked_and_read(groups))


def _is_number_or_speed(label: str) -> bool:
    """Whether what comes after a dot is no joint's name: a number, or a speed beside a position."""
    return label.isdigit() or read_name(label).role == "velocity"


def _beside_commands(names: Iterable[str]) -> Sequence[Group]:
    """Commands called as their readings but for a word, of joints with names of their own, or more
    than a delta has: DesRoll and Roll, left_s0 and left_s0_cmd.
    """
    labels = _by_what_asks(names)
    read = labels.pop("", {})
    groups = [{j: n for j, n in group.items() if j in read} for group in labels.values()]
    own = [g for g in groups if len(g) > 1 and all(map(is_of_joint, g)) and not _may_be_arms(g)]
    asked = next((group for group in groups if group in own or len(group) > MOTORS), {})
    if len({joint.rstrip("0123456789") for joint in asked}) < 2:
        return []  # joints with one name and numbers
    return [asked, {joint: read[joint] for joint in asked}]


def _by_what_asks(names: Iterable[str]) -> dict[str, dict[str, str]]:
    """Columns by the words that say a command, none for a reading, and by their other words."""
    labels: dict[str, dict[str, str]] = {}
    for name in names:
        words = re.split(r"[_. ]|(?<=[a-z])(?=[A-Z])", name)
        asks = [word for word in words if read_name(word).role == "command"]
        if len(asks) < len(words):
            label = "_".join(word for word in words if word not in asks)
            first, last = (words[end].lower() in MEASURED for end in (0, -1))
            own = "_".join(words[first : len(words) - last])
            if not asks and own and read_name(own).role is None:
                label = own  # ActualAz beside TargetAz, elbow_present beside elbow_goal
            labels.setdefault("_".join(asks), {}).setdefault(label, name)
    return labels


def _asked_and_read(stems: Iterable[str]) -> bool:
    """Whether some of the stems are called as commands, and others as readings."""
    roles = {read_name(stem).role for stem in stems}
    return "position" in roles and bool(roles & (LETTERED - {"position"}))


def of_data_set(table: Table) -> tuple[dict[str, str], list[str]]:
    """Units of the joints of a LeRobot data set by column, as far as their values show them, and
    what to be warned of.
    """
    joints = [name for name in table if name.startswith(tuple(f"{one}." for one in JOINTS))]
    if not joints:
        return {}, []
    farthest = max(float(np.nanmax(np.abs(table[name]))) for name in joints)
    if farthest <= GUESSES.widest_rad:
        return {}, []
    units = dict.fromkeys(joints, "deg")
    if farthest > NORMALISED:
        return units, [f"the joints go up to {farthest:g}: all of them are taken for degrees"]
    return units, [
        f"no joint goes beyond {NORMALISED:g} ({farthest:.4g} at most): all are taken for degrees;"
        " if they are LeRobot's normalised values of -100 to 100, put what one is [rad] in place of"
        " [deg] into the printed command, as *0.02"
    ]
