"""One cause at all three arms at once, with one size: equal homes, equal lags, equal lengths.

Such a group is what a single other cause is often mistaken for: three equal homes for an offset
of the z sensor, three equal lags for late sensors, longer upper arms for a payload's sag. In
JSON a group is given as its members, each marked `together`.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

from deltactl.diagnosis.plants.candidate import Candidate, Term
from deltactl.models.effects import CARDS, EffectKind
from deltactl.models.effects.flow import Flow
from deltactl.models.effects.kind import Memory, Values


def _grouped() -> dict[str, str]:
    """Effects that may be the same at all three arms, and what their group is called."""
    grouped = [(card.group, name) for name, card in CARDS.items() if card.group is not None]
    return {name: group.name for group, name in sorted(grouped, key=lambda one: one[0].order)}


def groups_of(candidates: Sequence[Candidate]) -> list[Candidate]:
    """A candidate for each effect that all arms may have alike, moved as one."""
    found = []
    for effect, name in _grouped().items():
        members = [one for one in candidates if one.effect == effect]
        if len(members) < 2:
            continue
        kind = replace(_together(members[0].kind), components=(name,))
        names = tuple(one.component for one in members)
        found.append(replace(members[0], kind=kind, component=name, members=names))
    return found


def _together(kind: EffectKind) -> EffectKind:
    """The same effect on every component."""

    def operate(flow: Flow, _: int, values: Values, memory: Memory) -> None:
        for component in kind.components:
            own = memory.setdefault(component, {})
            kind.operate(flow, kind.index(component), values, own)

    return replace(kind, operate=operate)


def apart(terms: Sequence[Term], candidates: Sequence[Candidate]) -> tuple[Term, ...]:
    """The terms with every group replaced by its members of the same size.

    A member that is there by itself keeps what it adds to the group.
    """
    by_key = {(one.effect, one.component): one for one in candidates}
    result = [term for term in terms if not term.candidate.members]
    for term in terms:
        for member in term.candidate.members:
            key = (term.candidate.effect, member)
            own = [i for i, t in enumerate(result) if t.candidate.key == key]
            if own:
                result[own[0]] = result[own[0]].moved_to(result[own[0]].at + term.at)
            else:
                result.append(Term(by_key[key], term.at.copy()))
    return tuple(result)
