"""How the command line talks: rich tables for people, one JSON value for machines."""

from __future__ import annotations

import json
import math
import sys
from collections.abc import Callable, Iterable, Iterator
from contextlib import contextmanager
from typing import Any

from rich.console import Console, ConsoleOptions, RenderableType
from rich.segment import Segment
from rich.table import Table

from deltactl.foundation.printable import is_printable, printable

NO_ROBOT = (
    "No daemon answers (the program that drives a real robot), and this is not a Raspberry Pi:"
    " {} the simulated robot."
)
"""Where a command that moves robots goes on without one."""


class PlainConsole(Console):
    """A console on which nobody's text moves the cursor: what cannot be printed is written out."""

    def render(
        self, renderable: RenderableType, options: ConsoleOptions | None = None
    ) -> Iterable[Segment]:
        """See Console; control codes of rich itself are let through."""
        for segment in super().render(renderable, options):
            if segment.control or is_printable(segment.text, layout=True):
                yield segment
            else:
                yield Segment(printable(segment.text, layout=True), segment.style)


console = PlainConsole(highlight=False, markup=False)
errors = PlainConsole(stderr=True, highlight=False, markup=False)


def say(text: str) -> None:
    """One line as it is: not broken at the window's edge, so that a path can be copied."""
    console.print(text, soft_wrap=True)


def tell(text: str, on: Console = console) -> None:
    """A sentence, nothing to be copied: broken between words in a terminal, one line elsewhere."""
    on.print(text, soft_wrap=not on.is_terminal)


def warn(text: str) -> None:
    """One line beside the answer, on standard error."""
    errors.print(text, soft_wrap=True)


@contextmanager
def waiting(first: str, hidden: bool) -> Iterator[Callable[[str], None]]:
    """A spinner on standard error: what is being done, for how long; call it with the next step.

    `hidden`: nothing is shown, as anywhere but in a terminal, where it would leave an empty line.
    """
    from rich.progress import Progress, SpinnerColumn, TextColumn, TimeElapsedColumn

    shown = (SpinnerColumn(), TextColumn("{task.description}"), TimeElapsedColumn())
    disable = hidden or not errors.is_terminal
    with Progress(*shown, console=errors, transient=True, disable=disable) as progress:
        bar = progress.add_task(first)

        def show(text: str) -> None:
            progress.update(bar, description=text)

        yield show


def print_json(value: object) -> None:
    """Exactly one JSON document on standard output; NaN becomes null."""
    json.dump(_finite(value), sys.stdout, indent=2, default=str)
    sys.stdout.write("\n")


def _finite(value: Any) -> Any:
    if isinstance(value, dict):
        return {key: _finite(inner) for key, inner in value.items()}
    if isinstance(value, list | tuple):
        return [_finite(inner) for inner in value]
    if isinstance(value, float) and not math.isfinite(value):
        return None
    return value


def facts(title: str, rows: list[tuple[str, str]]) -> Table:
    """A two-column table of named facts."""
    table = Table(title=title, title_justify="left", show_header=False, box=None, pad_edge=False)
    table.add_column(style="bold")
    table.add_column()
    for name, value in rows:
        table.add_row(name, value)
    return table


def millimetres(value_m: float) -> str:
    """A length for people."""
    return "-" if not math.isfinite(value_m) else f"{value_m * 1e3:.{decimals([value_m])}f} mm"


FEWEST_DECIMALS, MOST_DECIMALS = 2, 6


def decimals(lengths_m: Iterable[float], digits: int = 2) -> int:
    """Decimals in mm with which the smallest length still shows so many digits."""
    sizes = [abs(one) * 1e3 for one in lengths_m if math.isfinite(one) and one != 0.0]
    if not sizes:
        return FEWEST_DECIMALS
    needed = digits - 1 - math.floor(math.log10(min(sizes)))
    return min(max(needed, FEWEST_DECIMALS), MOST_DECIMALS)


def duration(seconds: float | None) -> str:
    """A duration for people."""
    if seconds is None:
        return "-"
    if seconds < 60:
        return f"{seconds:.1f} s"
    minutes, rest = divmod(round(seconds), 60)
    return (
        f"{minutes} min {rest:02d} s" if minutes < 60 else f"{minutes // 60} h {minutes % 60} min"
    )
