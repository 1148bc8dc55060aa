"""All commands of the program, those in groups too."""

from __future__ import annotations

from collections.abc import Iterator
from functools import cache
from typing import Any

from typer.main import get_command

from deltactl.cli.main import app


@cache
def whole_group() -> Any:
    """The program's group of commands, which takes a tenth of a second to make."""
    return get_command(app)


def every_command(group: Any = None, name: str = "") -> Iterator[tuple[str, Any]]:
    """What is typed behind `deltactl`, and the command; a group before its commands."""
    for word, command in (group or whole_group()).commands.items():
        yield f"{name}{word}", command
        if hasattr(command, "commands"):
            yield from every_command(command, f"{name}{word} ")


def found(words: list[str]) -> tuple[Any, list[str]]:
    """The command that words behind `deltactl` name, and its arguments. Raises KeyError."""
    command = whole_group()
    while hasattr(command, "commands") and words and not words[0].startswith("-"):
        command, words = command.commands[words[0]], words[1:]
    return command, words
