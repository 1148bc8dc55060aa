"""One hidden cause: what it is, where it sits, how large it is; the form of answers.json."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, field
from typing import Any

import numpy as np

from deltactl.proof.recorded import Machine

Value = float | list[float]
Parameters = dict[str, Value]
Draw = Callable[[np.random.Generator, float], Parameters]
Apply = Callable[[Machine, int, Parameters], None]

MOTORS = ("motor1", "motor2", "motor3")
ARMS = ("arm1", "arm2", "arm3")
RANGES = ("range_x", "range_y", "range_z")


@dataclass(frozen=True)
class Kind:
    """A kind of cause: where it can sit, how large it is drawn, what it does to a machine.

    `draw(rng, strength)` gives parameters by their names in the contract; strength 1 is
    moderate. `apply(machine, index, parameters)` builds it into component number `index`.
    """

    effect: str
    components: tuple[str, ...]
    units: dict[str, str]
    """Values of the parameters in the contract, the main one first."""
    draw: Draw
    apply: Apply
    order: int = 0
    """Kinds that need what others have set come later."""
    event: bool = False
    """Happens once: it is not in the holdout run."""

    @property
    def main(self) -> str:
        """The parameter that says how large it is."""
        return next(iter(self.units))


@dataclass(frozen=True)
class Hidden:
    """One cause as it was built in."""

    effect: str
    where: str
    parameters: Parameters
    main: str
    unit: str
    when: float | None = None
    also_where: tuple[str, ...] = ()
    depends_on: tuple[str, ...] = ()
    memory: bool | None = None
    kind: str = ""
    """Which oddity, for an unknown."""
    through: tuple[tuple[str, str], ...] = ()
    """Named effects by which an unknown shows, with their components: right to name, not needed."""
    known_size: tuple[str, ...] = field(default=())
    """Parameters whose true value the contract defines; only these are scored."""

    def answer(self) -> dict[str, Any]:
        """As in the practice recordings' answers.json, with more keys."""
        line: dict[str, Any] = {
            "effect": self.effect,
            "where": self.where,
            "value": self.parameters.get(self.main),
            "unit": self.unit,
            "parameters": {name: self.parameters[name] for name in self.known_size},
        }
        if self.when is not None:
            line["when"] = self.when
        if self.effect == "unknown":
            line["kind"] = self.kind
            line["also_where"] = list(self.also_where)
            line["depends_on"] = list(self.depends_on)
            line["memory"] = self.memory
            if self.through:
                line["through"] = [list(name) for name in self.through]
        return line


def number(value: Value) -> float:
    """A parameter that is one number."""
    if isinstance(value, list):
        raise TypeError(f"one number expected, not {value}")
    return value


def either_sign(rng: np.random.Generator, low: float, high: float) -> float:
    """Uniform in size, of either sign."""
    return float(rng.choice([-1.0, 1.0]) * rng.uniform(low, high))


def split_interval(rng: np.random.Generator, seconds: float) -> float:
    """A moment in the middle half of a recording."""
    return float(rng.uniform(0.25 * seconds, 0.75 * seconds))
