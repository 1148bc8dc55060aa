"""The second set of unknowns, and which of them may be looked at while the diagnosis is made.

Half are kept out of sight: whoever tunes the diagnosis runs, reads and plots only those that are
seen. They alternate in the alphabet, so that nobody chose.
"""

from __future__ import annotations

from dataclasses import dataclass

from deltactl.proof.hidden import bounded, forces, gathering
from deltactl.proof.hidden.oddities import ODDITIES, Build


@dataclass(frozen=True)
class NewKind:
    """How it is built in, whether it may be looked at, and whether a level curve can show it."""

    build: Build
    seen: bool
    curves: bool


NEW = {
    "belt_creep": NewKind(gathering.belt_creep, True, True),
    "coarse_steps": NewKind(bounded.coarse_steps, False, False),
    "drag": NewKind(forces.drag, True, False),
    "dust": NewKind(gathering.dust, False, True),
    "elastic_cable": NewKind(forces.elastic_cable, True, True),
    "gusts": NewKind(forces.gusts, False, True),
    "magnet": NewKind(forces.magnet, True, False),
    "mean_filter": NewKind(bounded.mean_filter, False, False),
    "motor_heat": NewKind(gathering.motor_heat, True, False),
    "multipath": NewKind(bounded.multipath, False, False),
    "saturation": NewKind(bounded.saturation, True, False),
    "spring_to_frame": NewKind(forces.spring_to_frame, False, True),
    "sticky": NewKind(bounded.sticky, True, False),
    "wear": NewKind(gathering.wear, False, False),
}
SEEN = tuple(name for name, kind in NEW.items() if kind.seen)
UNSEEN = tuple(name for name, kind in NEW.items() if not kind.seen)
SURVEY_ONLY = tuple(name for name, kind in NEW.items() if not kind.curves)
UNKNOWN: dict[str, Build] = {**ODDITIES, **{name: kind.build for name, kind in NEW.items()}}
"""All that is in no vocabulary. Earlier seeds draw from `ODDITIES` alone, which stays as it is."""
