"""Options that no command has, with the nearest that there is beside them."""

from __future__ import annotations

import difflib
import sys

import typer
from typer.main import get_command

CLOSE = 0.6
"""As difflib means it: two letters exchanged or missing, of a short word too."""


def unknown_option(error: typer.TyperException) -> str:
    """What is wrong with an option that the command has not; empty where that is not it."""
    typed = getattr(error, "option_name", "")
    command = getattr(getattr(error, "ctx", None), "command", None)
    if not typed or command is None or "No such option" not in error.format_message():
        return ""
    options = {name for one in command.params for name in one.opts if name.startswith("--")}
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
