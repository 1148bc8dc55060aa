"""What every effect of the vocabulary is: an operator at a port of the chain, with parameters."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass, field
from enum import IntEnum
from typing import Any

import numpy as np

from deltactl.foundation.errors import ConfigError
from deltactl.models.effects.flow import Flow
from deltactl.models.robot import FloatArray


class Port(IntEnum):
    """counts -> motor -> gear -> arm -> linkage -> platform -> sensor -> clock."""

    MOTOR = 1
    GEAR = 2
    ARM = 3
    LINKAGE = 4
    PLATFORM = 5
    SENSOR = 6
    CLOCK = 7
    ENCODER = 8
    """Beside the chain: what an angle encoder on the arm makes of the true angle."""


PORT_TEXT: dict[Port, str] = {
    Port.MOTOR: "motor and drive",
    Port.GEAR: "gearbox and shaft",
    Port.ARM: "arm angle",
    Port.LINKAGE: "linkage",
    Port.PLATFORM: "platform",
    Port.SENSOR: "distance sensor",
    Port.CLOCK: "time stamps",
    Port.ENCODER: "angle encoder",
}


Values = Mapping[str, FloatArray]
"""Parameter name -> value, shape () for numbers and (3,) for vectors."""
Memory = dict[str, Any]
"""What an operator remembers from block to block; empty at the start."""
Operate = Callable[[Flow, int, Values, Memory], None]
"""Changes the flow in place, for the component of the given index (0 for the only one)."""

MOTORS = ("motor1", "motor2", "motor3")
ARM_NAMES = ("arm1", "arm2", "arm3")
RANGES = ("range_x", "range_y", "range_z")
EVERY_JOINT = -1


@dataclass(frozen=True, slots=True)
class Parameter:
    """One parameter in SI units; `low` and `high` are the bounds of what is plausible."""

    name: str
    unit: str
    low: float
    high: float
    starts: tuple[float, ...] = (0.0,)
    """Where to start a fit: one value, or several where the operator is not smooth."""
    step: float = 1e-4
    """Step for a numerical derivative, small against what can be seen."""
    default: float | None = None
    """Value when it is not given; None: it must be."""
    size: int = 1
    """How many numbers."""
    up_to: bool = False
    """`size` is the most there may be; two at least."""
    reciprocal: bool = False
    """A fit moves in 1 / value, where the effect is linear."""
    typical: float | None = None
    """Median size where a machine has the effect, in SI units: how far it is from `nothing` (of
    1 / value where `reciprocal`). Sizes of faults spread by a factor of some three either way:
    a log-normal prior, as a fault of no size is none."""
    spread: float | None = None
    """Prior standard deviation of what is no size: of log(value) for periods, frequencies, times of
    warming and drags, of a place (a height), of 1 / stiffness beside a play."""


EXACT = 1e-4
"""One percent of the size: what is left beside the right one of most effects is noise."""


@dataclass(frozen=True, slots=True)
class Discrepancy:
    """How far the operator of an effect may be from the thing itself.

    Where the ends of a bar are is geometry: what a wrong length leaves is noise. A bearing, a
    spring or a stop is messier than any operator with two numbers, and what it leaves must not be
    taken for a second effect. So a further effect has to explain a share of what those there do.
    """

    in_pose: float = EXACT
    """Share of what the effect explains that its operator may leave, in what follows the pose."""
    elsewhere: float = EXACT
    """The same in all else."""
    leads_to: Mapping[str, float] = field(default_factory=dict)
    """The same for an effect that follows from this one's physics."""
    gives_way: Mapping[str, float] = field(default_factory=dict)
    """Standard deviation of a parameter that is not as fixed as the operator has it."""


@dataclass(frozen=True, slots=True)
class EffectKind:
    """One entry of the vocabulary.

    `nothing` names the parameter (and its value) at which the effect vanishes. `says` is a
    sentence with {component} and parameter names in braces, made by `sentence`.
    """

    name: str
    port: Port
    components: tuple[str, ...]
    parameters: tuple[Parameter, ...]
    operate: Operate
    says: Callable[[str, Mapping[str, Any]], str]
    order: int = 0
    """Order within the port."""
    smooth: bool = True
    event: bool = False
    """Happens once at its time and does not come back in another run."""
    nothing: float = 0.0
    """Value of the main (first) parameter with which nothing happens."""
    penalty: float = 0.0
    """Chi-square that naming it costs beside its coordinates: the rarer of two that fit alike."""
    odds: float = 0.02
    """Prior odds that a machine has it at one component. One to two faults among some seventy
    places; `penalty` is what makes one kind rarer than another."""
    discrepancy: Discrepancy = Discrepancy()
    pose_alone: bool = False
    """The same whenever the machine is in the same place: play and lag are not, so what play
    leaves cannot look like a wrong length."""
    local: bool = False
    """Acts now and then only, so that its operator misleads only near where it acts."""
    itself: Mapping[str, tuple[float, float]] = field(default_factory=dict)
    """Parameter -> the range in which the effect does what it is called after."""
    physical: float = float("inf")
    """Largest main size that such a thing has; beyond it, something else acts."""
    refuses: Callable[[Values], str] | None = None
    """Why values that are in bounds one by one do not fit together; empty where they do."""

    @property
    def main(self) -> Parameter:
        """The parameter that says how large the effect is."""
        return self.parameters[0]

    def index(self, component: str) -> int:
        """Number of a component: 0..2 for one of three, EVERY_JOINT for a common one.

        Raises ConfigError naming the components there are.
        """
        if component not in self.components:
            raise ConfigError(
                f"effect {self.name}: component '{component}' must be one of "
                f"{', '.join(self.components)}"
            )
        last = component[-1]
        if last in "123":
            return int(last) - 1
        return "xyz".index(last) if component.startswith("range_") else EVERY_JOINT

    def sentence(self, component: str, values: Mapping[str, Any]) -> str:
        """The effect in plain words with its size."""
        return self.says(component, values)


def scalar(values: Values, name: str) -> float:
    """A parameter that is one number."""
    return float(np.asarray(values[name]))


def joints(index: int) -> slice:
    """Columns an effect acts on: one joint or all of them."""
    return slice(None) if index == EVERY_JOINT else slice(index, index + 1)


def adds(signal: str, parameter: str) -> Operate:
    """An effect that adds its size to the component's column of a signal of the flow."""

    def operate(flow: Flow, index: int, values: Values, memory: Memory) -> None:
        getattr(flow, signal)[:, index] += scalar(values, parameter)

    return operate


def scales(signal: str, parameter: str) -> Operate:
    """An effect that multiplies the component's column of a signal by its size."""

    def operate(flow: Flow, index: int, values: Values, memory: Memory) -> None:
        getattr(flow, signal)[:, index] *= scalar(values, parameter)

    return operate
