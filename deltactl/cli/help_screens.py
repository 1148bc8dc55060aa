"""The help of every command in two screens: `--help` shows what is usual, `--help-all` the rest."""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import contextmanager
from functools import cache, partial
from typing import Any

import typer
from typer.core import TyperCommand
from typer.main import get_command

RUN, BY_HAND, REPAIR = "Run", "By hand", "Diagnose and repair"
LEARN, SERVICE = "Learn", "Service"
"""The panels of commands, in the order in which the help shows them."""
MORE = "More options"
"""The panel of options that most people never need: an option in any panel with a name is shown by
`--help-all` alone."""
COMPLETION = ("install_completion", "show_completion")
"""Options that Typer adds by itself."""
VALUES = {
    "Path": "FILE",
    "int": "NUMBER",
    "float": "NUMBER",
    "str": "TEXT",
    "int range": "NUMBER",
    "float range": "NUMBER",
}
"""Placeholder of an option's value, by its type."""


def takes_no_value(option: Any) -> bool:
    """Whether an option is switched on by being named."""
    return option.param_type_name == "option" and bool(option.is_flag or option.count)


def value_of(option: Any) -> str:
    """Placeholder of an option's value, as FILE."""
    return VALUES.get(str(option.bare_type()).removeprefix("list[").removesuffix("]"), "VALUE")


def _shown(value: str, ctx: Any) -> str:
    return value


def options_of(command: Any) -> list[Any]:
    """The options that a command declares, without those for help."""
    return [one for one in command.params if one.param_type_name == "option"]


class TwoScreens:
    """What commands and groups share: `--help-all`, and a first screen without the rare options."""

    params: list[Any]
    epilog: str | None

    def __init__(self, *args: Any, **kwargs: Any):
        super().__init__(*args, **kwargs)
        for parameter in self.params:
            if not parameter.type_descriptor.is_choice:
                shown = "" if takes_no_value(parameter) else value_of(parameter)
                parameter.display_type_rich = partial(_shown, shown)

    def get_params(self, ctx: Any) -> list[Any]:
        """See typer; with --help-all, which the help names only where it shows more."""
        inherited: Any = super()
        return [*inherited.get_params(ctx), _help_all(hidden=not self._rare())]

    def get_help_option(self, ctx: Any) -> Any:
        """See typer; it takes no value, and the help says so."""
        inherited: Any = super()
        option = inherited.get_help_option(ctx)
        option.metavar = ""
        return option

    def format_help(self, ctx: Any, formatter: Any) -> None:
        """See typer; the rare options are shown when all of them are asked for."""
        inherited: Any = super()
        whole = ctx.meta.get(MORE, False)
        with self._first_screen(ctx, whole):
            inherited.format_help(ctx, formatter)

    @contextmanager
    def _first_screen(self, ctx: Any, whole: bool) -> Iterator[None]:
        rare = [] if whole else self._rare()
        before = self.epilog
        if rare:
            options = "1 more option" if len(rare) == 1 else f"{len(rare)} more options"
            self.epilog = f"{options}: {ctx.command_path} --help-all"
        for option in rare:
            option.hidden = True
        try:
            yield
        finally:
            self.epilog = before
            for option in rare:
                option.hidden = False

    def _rare(self) -> list[Any]:
        for option in options_of(self):
            if option.name in COMPLETION:
                option.rich_help_panel = MORE
        return [one for one in options_of(self) if one.rich_help_panel]


class Command(TwoScreens, TyperCommand):
    """A command whose help has two screens."""


@cache
def _help_all(hidden: bool) -> Any:
    """The option that shows the help with the rare options; hidden where there are none."""

    def show(ctx: typer.Context, asked: bool) -> None:
        if asked and not ctx.resilient_parsing:
            ctx.meta[MORE] = True
            print(ctx.get_help(), end="")
            ctx.exit()

    shown = typer.Option(
        False,
        "--help-all",
        help="Show all options and exit.",
        callback=show,
        is_eager=True,
        expose_value=False,
        hidden=hidden,
    )

    def holder(help_all: bool = shown) -> None: ...

    made = typer.Typer(add_completion=False)
    made.command()(holder)
    (option,) = options_of(get_command(made))
    option.metavar = ""
    return option
