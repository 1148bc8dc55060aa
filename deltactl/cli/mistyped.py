"""Commands and options that are mistyped or called otherwise here, and what to type instead."""

from __future__ import annotations

import difflib
import sys
from itertools import pairwise, takewhile
from typing import Any

import typer
from typer.core import TyperGroup
from typer.main import get_command

CLOSE = 0.6
"""As difflib means it: two letters exchanged or missing, of a short word too."""


def unknown_option(error: typer.TyperException) -> str:
    """What is wrong with an option that the command has not; empty where that is not it."""
    typed = getattr(error, "option_name", "")
    command = getattr(getattr(error, "ctx", None), "command", None)
    if not typed or command is None or "No such option" not in error.format_message():
        return ""
    options = {
        name for parameter in command.params for name in parameter.opts if name.startswith("--")
    }
    if close := _nearest(typed, options):
        return f"No such option: {typed}; did you mean '{close}'?"
    if "--set" in options and (close := _nearest(typed, _set_keys())):
        return f"No such option: {typed}; did you mean '--set {close[2:].replace('-', '_')}=...'?"
    return f"No such option: {typed}"


def typed_command(app: typer.Typer) -> str:
    """'deltactl run', by what was typed: some errors do not know of which command they are."""
    commands = getattr(get_command(app), "commands", {})
    name = next((word for word in sys.argv[1:] if word in commands), "")
    return f"deltactl {name}".strip()


def _nearest(typed: str, names: set[str]) -> str:
    bare = {name.strip("-"): name for name in sorted(names)}
    close = difflib.get_close_matches(typed.strip("-"), bare, n=1, cutoff=CLOSE)
    return bare[close[0]] if close else ""


def _set_keys() -> set[str]:
    """What --set takes beside columns, as somebody might make options of it."""
    from deltactl.recording.foreign.mapping import OF_THE_TABLE

    return {f"--{name.replace('_', '-')}" for name in OF_THE_TABLE}


CALLED: dict[str, str] = {
    "inspect": "deltactl diagnose TABLE.csv --inspect",
    "simulate": "deltactl run JOB.yaml --simulate",
    "calibrate": "deltactl sensors --calibrate z=0.412",
    "move": "deltactl goto X Y Z",
    "start": "deltactl on",
    "serve": "deltactl web",
}

VALUES = {"Path": "FILE", "int": "NUMBER", "float": "NUMBER", "str": "TEXT"}
"""Placeholder for the value of an option, by its type."""


class Commands(TyperGroup):
    """The commands of the program."""

    def resolve_command(self, ctx: Any, args: list[str]) -> Any:
        """Which one is meant; ends with exit status 2 where there is none."""
        if args[0] in CALLED and args[0] not in self.commands:
            ctx.fail(f"No such command '{args[0]}'; type: {CALLED[args[0]]}")
        if args[0] in self.commands:
            command = self.commands[args[0]]
            if wrong := _option_without_value(command, args):
                type(ctx)(command, info_name=args[0], parent=ctx).fail(wrong)
        return super().resolve_command(ctx, args)


def _option_without_value(command: Any, args: list[str]) -> str:
    """What is wrong where an option lacks its value, or has another option there; else empty."""
    options = [parameter for parameter in command.params if parameter.param_type_name == "option"]
    names = {name for option in options for name in option.opts}
    valued = {name: option for option in options if not _alone(option) for name in option.opts}
    typed = list(takewhile(lambda word: word != "--", args))
    for name, value in pairwise(typed):
        if name in valued and value in names:
            return f"Option '{name}' needs a value, and '{value}' is another option"
    if (last := typed[-1]) in valued and typed == args:
        option = valued[last]
        stands_for = VALUES.get(_named_type(option), "VALUE")
        return f"Option '{last}' needs a value, as {last} {stands_for} ({option.help.rstrip('.')})"
    return ""


def _alone(option: Any) -> bool:
    """Whether an option takes no value."""
    return bool(option.is_flag or option.count)


def _named_type(option: Any) -> str:
    """The type of one value, as `Path`."""
    return str(option.bare_type()).removeprefix("list[").removesuffix("]")
