"""Commands and options that are mistyped or called otherwise here, and what to type instead."""

from __future__ import annotations

import difflib
import sys
from itertools import pairwise, takewhile
from typing import Any, ClassVar

import typer
from typer.core import TyperGroup
from typer.main import get_command

from deltactl.cli.help_screens import TwoScreens, options_of, takes_no_value, value_of
from deltactl.cli.old_spellings import as_now

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
    "simulate": "deltactl run JOB.yaml --simulate",
    "calibrate": "deltactl status sensors --calibrate z=0.4",
    "move": "deltactl goto X Y Z",
    "start": "deltactl power on",
    "serve": "deltactl web",
}


class Commands(TwoScreens, TyperGroup):
    """The commands of the program, or of one of its groups."""

    def resolve_command(self, ctx: Any, args: list[str]) -> Any:
        """Which one is meant; ends with exit status 2 where there is none."""
        if args[0] in self.commands:
            command = self.commands[args[0]]
            if wrong := _of_the_group_alone(ctx, args[0]) or _option_without_value(command, args):
                type(ctx)(command, info_name=args[0], parent=ctx).fail(wrong)
        elif meant := self.elsewhere(args[0]):
            ctx.fail(f"No such command '{args[0]}'; {meant}")
        return super().resolve_command(ctx, args)

    def elsewhere(self, typed: str) -> str:
        """What is to be typed instead of a command that is not here; empty if that is unknown."""
        return ""


class Program(Commands):
    """The commands of the program: those in their old spelling too."""

    order: ClassVar[list[str]] = []
    """In which the help shows them."""

    def list_commands(self, ctx: Any) -> list[str]:
        """See typer."""
        return sorted(self.commands, key=self.order.index)

    def parse_args(self, ctx: Any, args: list[str]) -> list[str]:
        """See typer; an old spelling is read as the new one, which is named."""
        kinds = getattr(self.commands["init"], "commands", ())
        if not ctx.resilient_parsing:
            args = as_now(args, kinds)
        return super().parse_args(ctx, args)

    def elsewhere(self, typed: str) -> str:
        """What it is called here, or in which group it is."""
        if typed in CALLED:
            return f"type: {CALLED[typed]}"
        if difflib.get_close_matches(typed, self.commands, n=1, cutoff=CLOSE):
            return ""
        inner = {
            name: f"deltactl {group} {name}"
            for group, command in self.commands.items()
            for name in getattr(command, "commands", ())
        }
        close = difflib.get_close_matches(typed, inner, n=1, cutoff=CLOSE)
        return f"did you mean '{inner[close[0]]}'?" if close else ""


def _of_the_group_alone(ctx: Any, name: str) -> str:
    """What is wrong where options of a group were typed before one of its commands; else empty."""
    typed = [
        option.opts[-1]
        for option in options_of(ctx.command)
        if option.expose_value
        and str(ctx.get_parameter_source(option.name)).endswith("COMMANDLINE")
    ]
    if not typed or ctx.parent is None:
        return ""
    return f"{typed[0]}: is an option of {ctx.command_path}; leave it out, or {name}"


def _option_without_value(command: Any, args: list[str]) -> str:
    """What is wrong where an option lacks its value, or has another option there; else empty."""
    options = options_of(command)
    names = {name for option in options for name in option.opts}
    valued = {
        name: option for option in options if not takes_no_value(option) for name in option.opts
    }
    typed = list(takewhile(lambda word: word != "--", args))
    for name, value in pairwise(typed):
        if name in valued and value in names:
            return f"Option '{name}' needs a value, and '{value}' is another option"
    if (last := typed[-1]) in valued and typed == args:
        option = valued[last]
        says = option.help.rstrip(".")
        return f"Option '{last}' needs a value, as {last} {value_of(option)} ({says})"
    return ""
