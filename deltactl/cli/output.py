"""How the command line talks: rich tables and sentences for people, one JSON value for machines."""

from __future__ import annotations

import json
import math
import re
import sys
from collections.abc import Callable, Iterable, Iterator
from contextlib import contextmanager
from typing import Any

from rich.console import Console, ConsoleOptions, RenderableType
from rich.segment import Segment
from rich.table import Table
from rich.text import Text

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
    """A sentence beside the answer, on standard error."""
    tell(text, errors)


@contextmanager
def waiting(first: str, hidden: bool) -> Iterator[Callable[[str], None]]:
    """A spinner on standard error: what is being done, for how long; call it with the next step.

    `hidden`: nothing is shown, as anywhere but in a terminal, where it would leave an empty line.
    """
    from rich.progress import Progress, SpinnerColumn, TextColumn, TimeElapsedColumn

    shown = (SpinnerColumn(), TextColumn("{task.description}"), TimeElapsedColumn())
    disable = hidden or not errors.is_terminal or errors.is_dumb_terminal
    with Progress(*shown, console=errors, transient=True, disable=disable) as progress:
        bar = progress.add_task(first)

        def show(text: str) -> None:
            progress.update(bar, description=text)

        yield show


@contextmanager
def bar(
    first: str = "", hidden: bool = False, total: int | None = None, took: bool = False
) -> Iterator[Callable[[int, int, str], None]]:
    """A bar on standard error: call it with what is done, of how many, and a word on it.

    hidden: nothing is shown, as anywhere but in a terminal, where it would leave an empty line.
    took: with the time it took so far.
    """
    from rich import progress as parts

    elapsed = (parts.TimeElapsedColumn(),) if took else ()
    shown = (parts.BarColumn(), parts.MofNCompleteColumn(), *elapsed, parts.TimeRemainingColumn())
    disable = hidden or not errors.is_terminal or errors.is_dumb_terminal
    with parts.Progress(
        *shown,
        parts.TextColumn("{task.description}"),
        console=errors,
        transient=True,
        disable=disable,
    ) as bars:
        task = bars.add_task(first, total=total)

        def show(done: int, of: int, text: str) -> None:
            bars.update(task, completed=done, total=of, description=text)

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
    sizes = [
        abs(length_m) * 1e3 for length_m in lengths_m if math.isfinite(length_m) and length_m != 0.0
    ]
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


_LEAD = re.compile(r"\s*(?:- |\d+\. )?")
"""What precedes a sentence: spaces, a bullet, a number."""
_TOGETHER = re.compile(r"((?<!\S)[(+\u2212-]?[\d.]+) (?=[^\W\d]|%)|\u00a0")
"""Between a number and its unit, and between thousands, no line is broken."""
_KEPT = "\ue000"
NARROWEST = 20


def print_wrapped(lines: Iterable[str]) -> None:
    """Print lines of rich markup, each broken at the window's edge with a hanging indent."""
    for line in lines:
        for part in wrapped(Text.from_markup(line), console.width):
            console.print(part, soft_wrap=True)


def broken(text: str) -> list[str]:
    """A sentence: in a window lines broken between words, elsewhere one line."""
    if not console.is_terminal:
        return [text]
    return [part.plain for part in wrapped(Text(text), console.width)]


def lines_of(texts: Iterable[str], width: int) -> int:
    """Lines in a window of what `say` prints, unbroken so that it can be copied."""
    return sum(max(-(-len(text) // width), 1) for text in texts)


NARROWEST_SCREEN, WIDEST_SCREEN = 60, 100


def screen_width() -> int:
    """Columns of an answer, whatever the window has."""
    return min(max(console.width, NARROWEST_SCREEN), WIDEST_SCREEN)


def wrapped(text: Text, width: int) -> list[Text]:
    """A line as lines of at most `width` characters, wherever words are no longer than that."""
    found = _LEAD.match(text.plain)
    indent = found.end() if found else 0
    if indent == len(text) or width - indent < NARROWEST:
        return [text]
    lead, body = text.divide([indent]) if indent else (Text(), text)
    body.plain = _TOGETHER.sub(lambda found: (found[1] or "") + _KEPT, body.plain)
    made = []
    for number, part in enumerate(body.wrap(console, width - indent)):
        part.rstrip()
        part.plain = part.plain.replace(_KEPT, " ")
        made.append(Text.assemble(Text(" " * indent) if number else lead, part))
    return made
