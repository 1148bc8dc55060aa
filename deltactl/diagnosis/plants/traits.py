"""What of a machine says which tests make sense on it; the engine itself names no machine."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass, field

from deltactl.diagnosis.plants.candidate import Candidate
from deltactl.diagnosis.plants.contract import Model


def _always(input_location: str, covariate: str, coarse: bool) -> bool:
    return True


@dataclass(frozen=True, slots=True)
class Traits:
    """The defaults are those of a machine with one joint and no events."""

    events: Mapping[str, Callable[[float], Candidate]] = field(default_factory=dict)
    """Input location -> the event that may come there, at a time [s]: a jump that stays."""
    repeating: tuple[str, ...] = ()
    """Channels that may repeat an old value."""
    own_place: Mapping[str, str] = field(default_factory=dict)
    """Input location -> covariate of its own place; an error may depend on the way it came."""
    sensible: Callable[[str, str, bool], bool] = _always
    """Whether a model error at an input location may follow a covariate; coarse: with few knots."""
    units: Mapping[str, str] = field(default_factory=dict)
    """Input location -> unit of what enters there."""
    build_effects: frozenset[str] = frozenset()
    """Effects that every machine built with care has a little of."""
    exactly: Mapping[str, str] = field(default_factory=dict)
    """Effect -> another one that it can be exactly, on every motion, at the same component."""
    exactly_together: Mapping[str, tuple[int, str, str]] = field(default_factory=dict)
    """Effect -> how many of it together can be exactly which other one, at which component."""


PLAIN = Traits()


def traits_of(model: Model) -> Traits:
    """Those of a machine; the plain ones where it states none."""
    traits = getattr(model, "traits", PLAIN)
    assert isinstance(traits, Traits)
    return traits
