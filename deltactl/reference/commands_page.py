"""The page of all commands: usage, help, arguments and options, as `--help-all` shows them."""

from __future__ import annotations

from collections.abc import Iterator
from pathlib import Path
from typing import Any

from typer.main import get_command

from deltactl.cli.help_screens import takes_no_value, value_of
from deltactl.cli.main import app
from deltactl.reference.key_tables import table

INTRODUCTION = (
    "Every command prints this with `--help-all`, and its usual options with `--help`. "
    "`deltactl --install-completion` completes names on the Tab key. The exit status is 0, or 2 "
    "for a mistake in the command or a file; a command that has another says so."
)


def commands_page() -> str:
    """Markdown of the page, the commands in the order of the help."""
    return "\n\n".join(["# Commands", INTRODUCTION, *_sections(get_command(app), "deltactl", 2)])


def _sections(group: Any, typed: str, level: int) -> Iterator[str]:
    for word in group.list_commands(None):
        command = group.commands[word]
        if command.hidden:
            continue
        yield from _section(command, f"{typed} {word}", level)
        if hasattr(command, "commands"):
            yield from _sections(command, f"{typed} {word}", level + 1)


def _section(command: Any, typed: str, level: int) -> Iterator[str]:
    yield f"{'#' * level} `{typed}`"
    yield (command.help or "").strip()
    shown = [one for one in command.params if not getattr(one, "hidden", False)]
    arguments = [one for one in shown if one.param_type_name == "argument"]
    if arguments:
        yield table(("argument", "meaning"), [_argument(one) for one in arguments])
    options = [one for one in shown if one.param_type_name == "option"]
    if options:
        yield table(("option", "value", "meaning"), [_option(one) for one in options])


def _argument(argument: Any) -> tuple[str, str]:
    name = (argument.metavar or argument.name).upper()
    return f"`{name}`" if argument.required else f"`[{name}]`", argument.help or ""


def _option(option: Any) -> tuple[str, str, str]:
    names = ", ".join(f"`{name}`" for name in (*option.opts, *option.secondary_opts))
    return names, _value(option), option.help or ""


def _value(option: Any) -> str:
    """What is typed behind an option, and what holds without it."""
    if takes_no_value(option):
        return ""
    kind = option.type_descriptor
    typed = " or ".join(f"`{one}`" for one in kind.choices) if kind.is_choice else value_of(option)
    given = option.default if isinstance(option.default, int | float | str | Path) else None
    return f"{typed}, else {given}" if given not in (None, "") else typed
