"""Two runs on different seeds side by side: the table of the docs, and where the runs differ.

    python -m benchmarks.rivals.seeds FIRST.md SECOND.md [FIRST.md SECOND.md ...] [--svg FILE]

Reads tables that `python -m benchmarks.rivals` wrote, two a group. A share is printed as hits/cases
of either run, with ` !` where the 95 % interval of their difference (Newcombe, of both Wilson
intervals) leaves out zero. The drawing has the shares of both runs together.
"""

from __future__ import annotations

import argparse
import re
import sys
from collections.abc import Iterator, Sequence
from math import hypot
from pathlib import Path

from benchmarks.rivals.picture import SHARE, drawing
from benchmarks.rivals.table import DASH
from deltactl.proof.prove.reliability import wilson

Columns = dict[str, dict[str, str]]
"""Tool -> figure -> text."""
LINE = re.compile(r"^\|(.+)\|$", re.MULTILINE)


def read_table(file: Path) -> Columns:
    """The table in a file that the comparison wrote."""
    lines = [line.split("|") for line in LINE.findall(file.read_text(encoding="utf-8"))]
    (_, *tools), _, *rows = [[cell.strip() for cell in line] for line in lines]
    return {
        tool: {figure: cells[place] for figure, *cells in rows} for place, tool in enumerate(tools)
    }


def together(first: str, second: str) -> str:
    """A figure of two runs."""
    pair = SHARE.match(first), SHARE.match(second)
    if None in pair:
        return DASH if {first, second} == {DASH} else f"{first}+{second}"
    one, other = ((int(own[1]), int(own[2])) for own in pair if own)
    text = f"{one[0]}/{one[1]}+{other[0]}/{other[1]}"
    return text if agree(one, other) else f"{text} !"


def agree(one: tuple[int, int], other: tuple[int, int]) -> bool:
    """Whether two shares, as hits and cases, may be one."""
    (p, low, high), (q, below, above) = ((k / n, *wilson(k, n)) for k, n in (one, other))
    less = p - q - hypot(p - low, above - q)
    more = p - q + hypot(high - p, q - below)
    return less <= 0.0 <= more


def pooled(first: str, second: str) -> str:
    """The share of both runs; of others none."""
    shares = [own for text in (first, second) if (own := SHARE.match(text))]
    hits, cases = (sum(int(own[place]) for own in shares) for place in (1, 2))
    if not cases:
        return DASH
    low, high = wilson(hits, cases)
    return f"{hits} of {cases} [{low:.2f}, {high:.2f}]"


def rows(first: Columns, second: Columns) -> Iterator[list[str]]:
    """Rows of the table: the figure, then a text a tool."""
    yield ["", *first]
    yield ["---"] * (1 + len(first))
    figures = dict.fromkeys(name for own in (*first.values(), *second.values()) for name in own)
    for figure in figures:
        texts = [[own.get(tool, {}).get(figure, DASH) for own in (first, second)] for tool in first]
        yield [figure, *(together(*pair) for pair in texts)]


def main(words: Sequence[str] | None = None) -> int:
    """Print a table a pair of files, and how many shares of the two runs differ."""
    parser = argparse.ArgumentParser(
        prog="python -m benchmarks.rivals.seeds", description=(__doc__ or "").splitlines()[0]
    )
    parser.add_argument("files", type=Path, nargs="+", help="tables, two a group")
    parser.add_argument("--svg", type=Path, help="draw names right and false claims here")
    options = parser.parse_args(words)
    if len(options.files) % 2:
        parser.error("two files a group")
    drawn: list[Columns] = []
    tables = [read_table(file) for file in options.files]
    for first, second in zip(tables[::2], tables[1::2], strict=True):
        texts = list(rows(first, second))
        shares = [text for row in texts for text in row if "/" in text]
        print("\n".join(f"|{'|'.join(row)}|" for row in texts))
        differ = sum(text.endswith("!") for text in shares)
        print(f"\n{differ} of {len(shares)} shares differ between the two runs\n")
        drawn.append(
            {
                tool: {name: pooled(own[name], second[tool].get(name, DASH)) for name in own}
                for tool, own in first.items()
            }
        )
    if options.svg:
        options.svg.write_text(drawing(drawn, brief=True), encoding="utf-8")
    return 0


if __name__ == "__main__":
    sys.exit(main())
