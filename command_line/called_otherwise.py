"""Commands that people type and that are called otherwise here: they are told what to type."""

from __future__ import annotations

from typing import Any

from typer.core import TyperGroup

CALLED: dict[str, str] = {
    "inspect": "deltactl diagnose TABLE.csv --inspect",
    "simulate": "deltactl run JOB.yaml --simulate",
    "calibrate": "deltactl sensors --calibrate z=0.412",
    "move": "deltactl goto X Y Z",
    "start": "deltactl on",
    "serve": "deltactl web",
}


class Commands(TyperGroup):
    """The commands of the program."""

    def resolve_command(self, ctx: Any, args: list[str]) -> Any:
        """Which one is meant; ends with exit status 2 where there is none."""
        if args[0] in CALLED and args[0] not in self.commands:
            ctx.fail(f"No such command '{args[0]}'; type: {CALLED[args[0]]}")
        return super().resolve_command(ctx, args)
