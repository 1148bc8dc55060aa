"""Logs of whole arms: angles and efforts of all joints, in columns as their makers call them."""

from __future__ import annotations

import math
import re
from collections.abc import Collection, Iterable, Mapping, Sequence
from dataclasses import dataclass, field, replace

import numpy as np

from deltactl.foundation.printable import count
from deltactl.recording.foreign.found import Inspection
from deltactl.recording.foreign.joints import CARTESIAN, one_joint
from deltactl.recording.foreign.mapping import Source
from deltactl.recording.foreign.names import (
    BY_NAME,
    TORQUES,
    Guess,
    in_words,
    of_role,
    read_name,
    without_unit,
)
from deltactl.recording.foreign.notes import Note, not_about
from deltactl.recording.foreign.options import GUESSES
from deltactl.recording.foreign.shapes import Table, is_whole
from deltactl.recording.format.messages import MOTORS
from deltactl.recording.tables.chain_tables import columns_of
from deltactl.recording.tables.flat import TARGET

QUANTITIES = {
    "theta": ("actual_q", "q", "present_position", "position", "pos", "theta"),
    "velocity": ("actual_qd", "dq", "present_velocity", "velocity", "vel"),
    "effort": (
        *("actual_current", "tau_j", "present_current", "present_load"),
        *("effort", "torque", "current", "load"),
    ),
}
"""Words of what was measured of each joint, the surest first: of UR (RTDE guide), libfranka
(RobotState), Dynamixel and Feetech (control tables), ROS (sensor_msgs/JointState) and LeRobot."""
ROLES = {"theta": "position", "velocity": "velocity", "effort": "effort"}
"""What other names have to say, where all joints are numbered."""
RANKS = {(role, word): n for role, own in QUANTITIES.items() for n, word in enumerate(own)}
OTHER = len(RANKS)
_NUMBERED = re.compile(r"(.*?[^\d._\[])[._\[]?(\d+)\]?")
_ANY = "|".join(sorted({word for _, word in RANKS}, key=len, reverse=True))
_BEHIND = re.compile(rf"(.*[./])?({_ANY})[._/]([A-Za-z][^./]*)")
_BEFORE = re.compile(rf"(.*[./])?([A-Za-z][^./]*?)[._/]({_ANY})")
COUNTS = 4096
"""Counts of a turn of Dynamixel X and Feetech STS servos; half of them is their zero."""
AS_DEGREES = "the joints go up to {:.4g}: all of them are taken for degrees"
AS_COUNTS = (
    "whole numbers up to {:.0f}: all joints are taken for counts, 4096 a turn and 2048 at zero"
)


@dataclass(frozen=True, slots=True)
class _Group:
    """One quantity of all joints: columns by the joint's number or name."""

    role: str
    rank: int
    """How little its name says."""
    columns: dict[str, str] = field(default_factory=dict)

    @property
    def joints(self) -> list[str]:
        """In the order of their numbers, else of the columns."""
        numbered = all(map(str.isdecimal, self.columns))
        return sorted(self.columns, key=int) if numbered else [*self.columns]


def as_arm(seen: Inspection) -> Inspection | None:
    """A table as that of an arm whose URDF is at hand; None where it has not angles and efforts of
    more joints than a delta has.
    """
    groups = _of_all_joints(seen.table)
    if groups is None:
        return None
    unit, counted, words = _unit(seen.table, groups["theta"].columns.values())
    if counted:
        groups.pop("velocity", None)  # whose counts are others
    order = groups["theta"].joints
    guesses = {
        one.columns[joint]: Guess(one.columns[joint], role, str(n), unit, BY_NAME)
        for role, one in groups.items()
        for n, joint in enumerate(order, 1)
    }
    columns = {
        one.name: _source(one, counted)
        for one in guesses.values()
        if counted or one.source != one.name or _shown(one, counted) is not None
    }
    others = seen.table.keys() - {*of_role(seen.guesses, "t")}
    kept = not_about(seen.warnings, others)
    shown = {name: replace(one, unit=_shown(one, counted)) for name, one in guesses.items()}
    return _whole(seen, shown, "angles and efforts", [*kept, *words], columns)


def as_chain(seen: Inspection, joints: Sequence[str]) -> Inspection | None:
    """The table as that of a chain with these joints; None where it lacks one of their columns.

    A chain reads its columns by their own names: by the place of the joint, or its name.
    """
    guesses = {
        name: Guess(name, stem, str(number), None, BY_NAME)
        for stem in ("theta", "command", "velocity", "effort")
        for number, (_, others) in enumerate(columns_of(joints, stem), 1)
        if (name := next((one for one in others if one in seen.table), None)) is not None
    }
    roles = ("theta", "command", "effort")
    of_all = {role for role in roles if len(of_role(guesses, role)) == len(joints)}
    placed = any(map(TARGET.fullmatch, seen.table)) and not of_all.isdisjoint(("theta", "command"))
    if not (placed or of_all >= {"theta", "effort"}):
        return None
    efforts = "efforts" if "effort" in of_all else "places of a target"
    return _whole(seen, guesses, f"{efforts} and angles", [], {})


def _whole(
    seen: Inspection,
    guesses: dict[str, Guess],
    what: str,
    warnings: list[str],
    columns: dict[str, Source],
) -> Inspection:
    """A table as that of all joints together. what: of each of them. columns: beside the time."""
    clock = {name: one for name, one in seen.mapping.columns.items() if name == "t"}
    joints = max(int(one.index or 0) for one in guesses.values())
    return replace(
        seen,
        guesses={name: seen.guesses[name] for name in of_role(seen.guesses, "t")} | guesses,
        kind="chain",
        motion=None,
        kind_why=f"{what} of {count(joints, 'joint')}",
        zero=None,
        mapping=seen.mapping.model_copy(update={"columns": clock | columns, "unit": None}),
        warnings=warnings,
        asked=None,
    )


def fitted_to(
    seen: Inspection, joints: Sequence[str], rad_per_count: Sequence[float | None] = ()
) -> tuple[Inspection, str]:
    """The table of an arm read for a chain with these joints, and why it is none of that chain.

    rad_per_count: of joints that have a drive, whose columns stay counts.
    """
    named = joint_names(seen)
    there = named or [str(n) for n in range(1, len(of_role(seen.guesses, "theta")) + 1)]
    if why := _why_of_no_chain(named, len(there), joints):
        return seen, why
    place = {str(there.index(j) + 1): str(n) for n, j in enumerate(joints if named else there, 1)}
    driven = {f"theta_{n}" for n, rad in enumerate(rad_per_count, 1) if rad is not None}
    return _in_counts(_renumbered(seen, place), driven), ""


def _why_of_no_chain(named: Sequence[str], there: int, joints: Sequence[str]) -> str:
    """Why a table with columns of so many joints is none of a chain; named: those with names."""
    if missing := [joint for joint in joints if named and joint not in named]:
        return f"it has no column of joint {missing[0]}, but of {', '.join(named)}"
    if named or there == len(joints):
        return ""
    return (
        f"it has columns of {there} joints, and the robot file has {len(joints)}; its `joints` are"
        " to be those of the columns, in their order"
    )


def _renumbered(seen: Inspection, place: Mapping[str, str]) -> Inspection:
    """The table with other numbers of its joints, new by old; those without one are left out."""
    guesses = {
        name: replace(one, index=place.get(one.index)) if one.index else one
        for name, one in seen.guesses.items()
        if one.index is None or one.index in place
    }
    new = {one.name: guesses[name].name for name, one in seen.guesses.items() if name in guesses}
    columns = {new[name]: one for name, one in seen.mapping.columns.items() if name in new}
    mapping = seen.mapping.model_copy(update={"columns": columns})
    return replace(seen, guesses=guesses, mapping=mapping)


def _in_counts(seen: Inspection, driven: Collection[str]) -> Inspection:
    """The table with some columns as the counts that they are, and no doubt of their unit."""
    columns = {
        name: Source.model_validate({"from": one.from_}) if name in driven else one
        for name, one in seen.mapping.columns.items()
    }
    counted = [name for name, one in seen.guesses.items() if one.name in driven]
    mapping = seen.mapping.model_copy(update={"columns": columns})
    return replace(seen, mapping=mapping, warnings=not_about(seen.warnings, counted))


def joint_names(seen: Inspection) -> list[str]:
    """Names of the joints in the order of their columns; empty where they are numbered."""
    angles = sorted(of_role(seen.guesses, "theta"), key=lambda n: int(seen.guesses[n].index or 0))
    parts = [_parted(name) for name in angles]
    names = [part[2] for part in parts if part is not None]
    return [] if any(map(str.isdecimal, names)) else names


def effort_column(seen: Inspection) -> str | None:
    """The first column of efforts where its name does not say that it is a torque or a force."""
    first = next(iter(of_role(seen.guesses, "effort")), "")
    return None if TORQUES.intersection(in_words(first)) else first


def angle_of_one(seen: Inspection) -> str:
    """The column of the angle of the joint that a diagnosis of one joint begins with: that which
    departs most from its command, else the first.
    """
    read = {name: one for name, one in seen.table.items() if np.isfinite(one).any()}
    kept, _ = one_joint(read, ())
    angles = of_role(seen.guesses, "theta")
    return next((name for name in angles if name in kept), angles[0])


def unit_of_angles(seen: Inspection) -> str | None:
    """The unit in which the angles of all joints are read; None for counts."""
    source = seen.mapping.columns.get("theta_1")
    if source is not None and "scale" in source.model_fields_set:
        return None
    return seen.guesses[of_role(seen.guesses, "theta")[0]].unit or "rad"


def _of_all_joints(table: Table) -> dict[str, _Group] | None:
    """Angles, efforts and, where there are any, velocities of the same joints."""
    groups: dict[tuple[str, str], _Group] = {}
    for name in table:
        if (parted := _parted(name)) is not None and np.isfinite(table[name]).any():
            role, stem, joint, rank = parted
            groups.setdefault((role, stem), _Group(role, rank)).columns.setdefault(joint, name)
    found: dict[str, _Group] = {}
    for role in ("theta", "effort", "velocity"):
        own = [one for one in groups.values() if one.role == role and len(one.columns) > MOTORS]
        if "theta" in found:
            own = [one for one in own if one.columns.keys() == found["theta"].columns.keys()]
        if own:
            found[role] = min(own, key=lambda one: one.rank)
    return found if {"theta", "effort"} <= found.keys() else None


def _parted(column: str) -> tuple[str, str, str, int] | None:
    """Role of a column that is one of several joints', its stem, the joint, and how little the
    name says; None of any other.
    """
    name = without_unit(column)
    if numbered := _NUMBERED.fullmatch(name):
        word = re.split(r"[./]", numbered[1])[-1].lower()
        said = read_name(numbered[1])
        asked = read_name(numbered[1].removesuffix(word)).role == "command"
        for role, other in ROLES.items():
            if (role, word) in RANKS and not asked:
                return role, numbered[1], numbered[2], RANKS[role, word]
            if said.role == other and said.used and not said.asked:
                return role, numbered[1], numbered[2], OTHER
        return None
    if behind := _BEHIND.fullmatch(name):
        before, word, joint = behind.groups()
    elif ahead := _BEFORE.fullmatch(name):
        before, joint, word = ahead.groups()
    else:
        return None
    if joint in CARTESIAN or read_name(before or "").role == "command":
        return None
    role = next(role for role, own in RANKS if own == word)
    return role, f"{before or ''}{word}", joint, RANKS[role, word]


def _unit(table: Table, angles: Iterable[str]) -> tuple[str | None, bool, list[str]]:
    """Unit of the angles, whether they are counts, and what is to be said of it."""
    names = list(angles)
    said = read_name(names[0]).unit
    farthest = max(float(np.nanmax(np.abs(table[name]))) for name in names)
    if said is not None or farthest <= GUESSES.widest_rad:
        return said, False, []
    if all(is_whole(table[name]) for name in names):
        return None, True, [Note(AS_COUNTS.format(farthest), names)]
    return "deg", False, [Note(AS_DEGREES.format(farthest), names)]


def _shown(one: Guess, counted: bool) -> str | None:
    """The unit of a column of a joint."""
    if one.role == "effort" or counted:
        return None
    return one.unit if one.role == "theta" or one.unit is None else f"{one.unit}/s"


def _source(one: Guess, counted: bool) -> Source:
    """Where a column of a joint comes from."""
    given = {"from": one.source, "unit": _shown(one, counted) or "1"}
    if counted and one.role == "theta":
        turn = 2.0 * math.pi
        return Source.model_validate(
            given | {"scale": round(turn / COUNTS, 12), "offset": -round(turn / 2.0, 12)}
        )
    return Source.model_validate(given)
