"""An effect with values, ready to act on a flow."""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from dataclasses import dataclass, field

import numpy as np

from deltactl.foundation.errors import ConfigError
from deltactl.models.effects import EffectKind, effect_kind
from deltactl.models.effects.flow import Flow
from deltactl.models.effects.kind import Memory, Parameter, Port
from deltactl.models.robot import EffectEntry, FloatArray


@dataclass(slots=True)
class Active:
    """One effect on one component with all its parameters in SI units."""

    kind: EffectKind
    component: str
    values: dict[str, FloatArray]
    memory: Memory = field(default_factory=dict)

    def act(self, flow: Flow) -> None:
        """Change the flow at this effect's port."""
        self.kind.operate(flow, self.kind.index(self.component), self.values, self.memory)


def activate(
    kind: EffectKind, component: str, given: Mapping[str, float | tuple[float, ...] | FloatArray]
) -> Active:
    """An effect with its parameters checked and defaults filled in.

    Raises ConfigError for an unknown component or parameter, a missing one, a vector of the
    wrong size, or a value out of bounds.
    """
    kind.index(component)
    where = f"effect {kind.name} on {component}"
    known = {parameter.name for parameter in kind.parameters}
    for name in given:
        if name not in known:
            raise ConfigError(
                f"{where}: parameter '{name}' must be one of {', '.join(sorted(known))}"
            )
    values: dict[str, FloatArray] = {}
    for parameter in kind.parameters:
        value = given.get(parameter.name, parameter.default)
        if value is None:
            raise ConfigError(f"{where}: parameter '{parameter.name}' [{parameter.unit}] is needed")
        array = np.asarray(value, dtype=np.float64)
        if not _has_size(array, parameter):
            most = "2 to " if parameter.up_to else ""
            raise ConfigError(
                f"{where}: '{parameter.name}' must be {most}{parameter.size} number(s)"
            )
        if not ((array >= parameter.low) & (array <= parameter.high)).all():
            raise ConfigError(
                f"{where}: '{parameter.name}' must be between {parameter.low:g} and "
                f"{parameter.high:g} {parameter.unit} (got {array.tolist()})"
            )
        values[parameter.name] = array
    if kind.refuses is not None and (why := kind.refuses(values)):
        raise ConfigError(f"{where}: {why}")
    return Active(kind, component, values)


def _has_size(array: FloatArray, parameter: Parameter) -> bool:
    if parameter.up_to:
        return array.ndim == 1 and 2 <= len(array) <= parameter.size
    return array.shape == ((parameter.size,) if parameter.size > 1 else ())


def of_entries(entries: Iterable[EffectEntry]) -> list[Active]:
    """Effects as a robot file names them."""
    return [activate(effect_kind(e.effect), e.component, e.parameters) for e in entries]


def at(effects: Iterable[Active], port: Port) -> list[Active]:
    """The effects at one port, in the order in which they act."""
    return sorted((e for e in effects if e.kind.port is port), key=lambda e: e.kind.order)
