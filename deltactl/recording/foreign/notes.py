"""Warnings about columns of a foreign table, which know the columns that they are about."""

from __future__ import annotations

from collections.abc import Collection, Iterable, Sequence
from typing import Literal, Self


class Note(str):
    """A warning about columns of the file."""

    columns: frozenset[str]

    def __new__(cls, says: str, columns: Iterable[str]) -> Self:
        """says: the whole text. columns: those that it is about."""
        note = super().__new__(cls, says)
        note.columns = frozenset(columns)
        return note

    @classmethod
    def on(cls, columns: Sequence[str], says: str) -> Self:
        """The columns by their names, and what is to be said of them."""
        return cls(f"{', '.join(columns)}: {says}", columns)


def not_about(warnings: Iterable[str], columns: Collection[str]) -> list[str]:
    """The warnings but those about one of the columns."""
    return [
        one for one in warnings if not (isinstance(one, Note) and one.columns.intersection(columns))
    ]


def about_any(warnings: Iterable[str], columns: Collection[str]) -> list[str]:
    """The warnings about one of the columns, and those that are about none of the file."""
    return [
        one for one in warnings if not (isinstance(one, Note) and one.columns.isdisjoint(columns))
    ]


class Hint(Note):
    """A warning of what a column was taken for, with what else may be chosen.

    The text is for whoever types the command that reads the table. kind: whether the `unit` or the
    `name` of the columns is to be chosen. choice: what to choose. command: what to type for it.
    """

    kind: Literal["unit", "name"]
    choice: str
    command: str
    chosen: str
    """The same for whoever chooses on a page."""

    @classmethod
    def of(
        cls,
        says: str,
        kind: Literal["unit", "name"],
        columns: Sequence[str],
        choice: str,
        command: str,
    ) -> Self:
        """says: what they were taken for, and if what something else is to be chosen."""
        hint = cls.on(columns, f"{says}, {command}")
        hint.kind, hint.choice, hint.command = kind, choice, command
        hint.chosen = f"{', '.join(columns)}: {says}, choose {choice}"
        return hint
