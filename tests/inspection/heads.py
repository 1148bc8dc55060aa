"""Tables below the heads of `heads.yaml`: an axis, an arm or a delta that moves as logs show it.

A reading follows its command two rows late and with noise; an effort goes with acceleration and
the sign of speed; the other columns of the log do not depend on the motion.
"""

from __future__ import annotations

import itertools
import re
from collections.abc import Iterator
from functools import cache
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np
import yaml

from deltactl.models.linkage import Linkage, forward
from deltactl.models.robot import Geometry

Array = np.ndarray
ROWS = 400
LATE_ROWS = 2
_SET = re.compile(r"\{([^}]*)\}")
_SIGNAL = re.compile(r"([a-z_]+?)(\d?)")
LINEAR = ("m", "mm")
AMPLITUDE = {True: 0.08, False: 0.9}
"""How far a slide goes [m], and a joint [rad]."""
IN_SI = {"m": 1.0, "mm": 1e-3, "rad": 1.0, "deg": np.pi / 180, "turn": 2 * np.pi}
GEOMETRY = Geometry(base_radius_m=0.2, platform_radius_m=0.05, upper_arm_m=0.2, forearm_m=0.45)


class Head(NamedTuple):
    """A head of a log, with what its columns are."""

    program: str
    rate_hz: float
    columns: dict[str, str]
    right: dict[str, list[str | None]]
    """Column of the contract, or `kind` -> what is right for it."""
    unsaid: bool
    form: dict[str, Any]


def heads(path: Path) -> Iterator[Head]:
    for one in yaml.safe_load(path.read_text(encoding="utf-8")):
        columns = {
            name: f"{words} @{joint}"
            for pattern, words in one.pop("columns").items()
            for joint, name in enumerate(_spelled(pattern))
        }
        columns = {name: columns[name] for name in one.pop("order", columns)}
        right = {role: is_ if isinstance(is_, list) else [is_] for role, is_ in one["is"].items()}
        yield Head(one["program"], one["rate_hz"], columns, right, one.get("unsaid", False), one)


def write(head: Head, path: Path) -> None:
    """The table as its program writes it."""
    separator, decimal = head.form.get("separator", ","), head.form.get("decimal", ".")
    cells = [list(_cells(head, name, decimal)) for name in head.columns]
    names = [re.sub(r"^Time\.\d$", "Time", name) for name in head.columns]
    lines = list(head.form.get("before", []))
    if head.form.get("labels"):
        cells = [
            [f"{name}:{one}" for one in below] for name, below in zip(names, cells, strict=True)
        ]
        rows = [separator.join(row) for row in zip(*cells, strict=True)]
    else:
        rows = [separator.join(row) for row in zip(*cells, strict=True)]
        lines += [] if head.form.get("headless") else [separator.join(names)]
    path.write_text("\n".join([*lines, *rows]) + "\n", encoding="utf-8")


def truth(head: Head, column: str) -> Array:
    """Values of a column, in SI units."""
    words = head.columns[column].split()
    return _motion(*_named(words[0]), words[1], int(words[-1][1:]), head.rate_hz)


def _spelled(pattern: str) -> list[str]:
    if (found := _SET.search(pattern)) is None:
        return [pattern]
    first, dots, last = found[1].partition("..")
    inside = range(int(first), int(last) + 1) if dots else first.split(",")
    return [pattern.replace(found[0], str(one)) for one in inside]


def _named(word: str) -> tuple[str, int]:
    match = _SIGNAL.fullmatch(word)
    assert match is not None
    return match[1], max(int(match[2] or 1) - 1, 0)


def _cells(head: Head, name: str, decimal: str) -> Iterator[str]:
    kind, *rest = head.columns[name].split()
    if kind == "text":
        return itertools.repeat("" if rest[0] == '""' else rest[0], ROWS)
    digits = 17 if kind == "time" else 10
    return (f"{one:.{digits}g}".replace(".", decimal) for one in _values(head, name, kind, rest))


def _values(head: Head, name: str, word: str, rest: list[str]) -> Array:
    t_s = np.arange(ROWS) / head.rate_hz
    joint, drawn = int(rest[-1][1:]), _drawn(name)
    amount = float(rest[0]) if re.fullmatch(r"[\d.]+", rest[0]) else 0.0
    start = float(rest[1]) if len(rest) > 2 else 0.0
    match word:
        case "time":
            ticks = {"s": 1.0, "ms": 1e3, "us": 1e6, "ns": 1e9}[rest[0]]
            return start * (ticks if ticks == 1e9 else 1.0) + np.round(t_s * ticks, 6)
        case "whole":
            return start + np.floor(t_s)
        case "nanos":
            return np.round(t_s % 1.0 * 1e9)
        case "count":
            return amount + np.arange(ROWS)
        case "constant":
            return np.full(ROWS, amount)
        case "supply":
            return amount * (1.0 + 0.002 * drawn)
        case "drift":
            return amount + 2.0 * (1.0 - np.exp(-t_s / t_s[-1])) + 0.02 * drawn
        case "noise":
            return amount * drawn
        case "pulse":
            return np.round(amount * np.abs(drawn))
    role, further = _named(word)
    joint += further
    if role in ("effort", "asked_effort", "whole_effort"):
        late = LATE_ROWS if role != "asked_effort" else 0
        pull = amount * np.interp(np.arange(ROWS) - late, np.arange(ROWS), _pull(joint))
        pull = pull + 0.03 * amount * drawn if role != "asked_effort" else pull
        return np.round(pull) if role == "whole_effort" else pull
    unit = rest[0]
    size = _motion(role, further, unit, int(rest[-1][1:]), head.rate_hz)
    if unit.startswith("counts/"):
        scaled = size / (2.0 * np.pi) * float(unit.removeprefix("counts/"))
        return scaled if "." in unit else np.round(scaled)
    if unit == "rpm":
        return size * 30.0 / np.pi
    return size / IN_SI[unit]


def _motion(role: str, further: int, unit: str, joint: int, rate_hz: float) -> Array:
    """A column of motion [rad, m, or the same a second]."""
    joint += further
    far, rows = AMPLITUDE[unit in LINEAR], np.arange(ROWS)
    if role in ("arm", "asked_arm", "place"):
        angles = np.stack([0.4 + 0.4 * _asked(n) for n in range(3)], axis=1)
        late = np.stack([_late(one) for one in angles.T], axis=1)
        if role == "place":
            place = forward(Linkage.of(GEOMETRY), late).position_m[:, joint]
            return place + 1e-5 * _drawn(f"place {joint}")
        return (
            angles[:, joint]
            if role == "asked_arm"
            else late[:, joint] + 2e-5 * _drawn(f"arm {joint}")
        )
    asked = _asked(joint)
    seen = _late(asked) + _noise("reading", joint)
    speed = np.gradient(_late(asked)) * rate_hz
    if role in ("distance", "range"):
        steps = 0.15 + 0.8 * np.floor(rows / ROWS * 16) / 16
        return steps + (0.004 * _drawn("range") + 0.01 * steps if role == "range" else 0.0)
    signals = {
        "command": asked,
        "reading": seen,
        "motor": seen + 0.002 * np.sign(speed) + _noise("motor", joint),
        "platform": seen + 0.02 * _asked(joint + 1),
        "asked_platform": asked + 0.02 * _asked(joint + 1),
        "error": asked - seen,
        "speed": speed + 0.01 * np.std(speed) * _drawn(f"speed {joint}"),
        "asked_speed": np.gradient(asked) * rate_hz,
        "accel": np.gradient(np.gradient(asked)) * rate_hz**2,
        "target": np.round(2.0 * _asked(joint)[np.minimum(rows // 50 * 50 + 49, ROWS - 1)]) / 2.0,
    }
    return far * signals[role]


def _asked(joint: int) -> Array:
    at = 2.0 * np.pi * np.arange(ROWS) / ROWS
    return 0.7 * np.sin((2.3 + 0.4 * joint) * at + joint) + 0.3 * np.sin(5.1 * at - 2.0 * joint)


def _late(values: Array) -> Array:
    rows = np.arange(ROWS)
    return np.interp(rows - LATE_ROWS, rows, values)


def _noise(what: str, joint: int) -> Array:
    return 0.0005 * _drawn(f"{what} {joint}")


def _pull(joint: int) -> Array:
    """Acceleration, the sign of speed and a little of speed, at most about 1."""
    speed = np.gradient(_asked(joint))
    change = np.gradient(speed)
    return (
        0.5 * change / np.max(np.abs(change))
        + 0.3 * np.tanh(20.0 * speed / np.max(np.abs(speed)))
        + 0.2 * speed / np.max(np.abs(speed))
    )


@cache
def _drawn(what: str) -> Array:
    return np.random.default_rng(list(what.encode())).standard_normal(ROWS)
