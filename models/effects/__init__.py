"""The vocabulary: every effect that can be named, as an operator at a port of the chain.

A new effect is one file of this folder with an `EFFECT` and its `CARD`; nothing else names it.
"""

from __future__ import annotations

from collections.abc import Iterable
from importlib import import_module
from pkgutil import iter_modules

from deltactl.foundation.errors import ConfigError
from deltactl.models.effects.card import (
    Compensated,
    Confusion,
    EffectCard,
    Rule,
    Search,
    StandIn,
    Trait,
    Words,
)
from deltactl.models.effects.kind import PORT_TEXT, EffectKind, Memory, Parameter, Port, Values

CARDS: dict[str, EffectCard] = {}
"""The card of every effect by name, also of those that act on no delta, and of `unknown`."""
VOCABULARY: dict[str, EffectKind] = {}
"""Effects of a delta by name. Those of single axes are with their chains."""
TABLES: dict[str, EffectKind] = {}
"""What a robot file may say of errors that have no name. No diagnosis looks for these."""


def register(cards: Iterable[EffectCard]) -> None:
    """Make effects known to all that ask: delta's by port and place in its list, others after."""
    for card in sorted(cards, key=_place):
        CARDS[card.name] = card
        if card.kind is not None:
            (TABLES if card.table else VOCABULARY)[card.name] = card.kind


def _place(card: EffectCard) -> tuple[int, int, str]:
    last = max(Port).value + 1
    return (card.kind.port.value if card.kind else last, card.listed, card.name)


def _cards_of_this_folder() -> Iterable[EffectCard]:
    for info in iter_modules(__path__):
        module = import_module(f"{__name__}.{info.name}")
        yield from getattr(module, "CARDS", ())
        if hasattr(module, "CARD"):
            yield module.CARD


def card_of(name: str) -> EffectCard:
    """The card of an effect; an empty one of a name that is not known."""
    return CARDS.get(name) or EffectCard(name)


def has(name: str, trait: Trait) -> bool:
    """Whether an effect has what a trait says."""
    return trait in card_of(name).traits


def with_trait(*traits: Trait) -> tuple[str, ...]:
    """Names of the effects that have one of some traits."""
    return tuple(name for name, card in CARDS.items() if card.traits & {*traits})


def column_of(place: str) -> tuple[str, float]:
    """The effect that a column of a single machine shows, and its log odds (`EffectCard.log_odds`).

    Raises LookupError where no card has such a column.
    """
    for name, card in CARDS.items():
        if place in card.log_odds:
            return name, card.log_odds[place]
    raise LookupError(f"no effect has the column '{place}'")


def stand_ins(place: str, effect: str) -> tuple[tuple[str, StandIn], ...]:
    """Other effects that a column may be instead of the one that it is called after."""
    return tuple(
        (confusion.other if confusion.other != effect else name, confusion.stands_in[place])
        for name, card in CARDS.items()
        for confusion in card.confusions
        if place in confusion.stands_in
    )


def found_by(search: Search) -> EffectKind:
    """The effect of a delta that a search finds."""
    fits = ((name, CARDS[name].fit) for name in VOCABULARY)
    return next(VOCABULARY[name] for name, fit in fits if fit and fit.searched is search)


def compensated(*ways: Compensated) -> frozenset[str]:
    """Names of the effects that jobs take into account in one of these ways."""
    return frozenset(name for name, card in CARDS.items() if card.compensated in ways)


def confusion(one: str, other: str) -> Confusion | None:
    """What separates two effects, on whichever card it is; None where neither knows the other."""
    return card_of(one).confusion(other) or card_of(other).confusion(one)


def effect_kind(name: str) -> EffectKind:
    """An effect of the vocabulary, or a table. Raises ConfigError naming those there are."""
    if name in TABLES:
        return TABLES[name]
    if name not in VOCABULARY:
        there = ", ".join(sorted([*VOCABULARY, *TABLES]))
        raise ConfigError(f"effect '{name}' must be one of {there}")
    return VOCABULARY[name]


register(_cards_of_this_folder())

__all__ = [
    "CARDS",
    "PORT_TEXT",
    "TABLES",
    "VOCABULARY",
    "Compensated",
    "EffectCard",
    "EffectKind",
    "Memory",
    "Parameter",
    "Port",
    "Rule",
    "Search",
    "Trait",
    "Values",
    "Words",
    "card_of",
    "column_of",
    "compensated",
    "confusion",
    "effect_kind",
    "found_by",
    "has",
    "register",
    "stand_ins",
    "with_trait",
]
