"""A table of a reproduction, for the screen, for Markdown and for the report."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

from deltactl.charts.page import paragraph, table


@dataclass(frozen=True)
class Sheet:
    """Columns from `numbers_from` on are numbers; `note` stands below."""

    title: str
    head: Sequence[str]
    rows: Sequence[Sequence[str]]
    numbers_from: int = 1
    note: str = ""

    def text(self) -> str:
        """For the screen: aligned columns that no window's edge breaks."""
        lines = [self.head, *self.rows]
        widths = [max(len(line[column]) for line in lines) for column in range(len(self.head))]
        drawn = [
            "  ".join(
                cell.rjust(width) if column >= self.numbers_from else cell.ljust(width)
                for column, (cell, width) in enumerate(zip(line, widths, strict=True))
            ).rstrip()
            for line in lines
        ]
        rule = "─" * (sum(widths) + 2 * len(widths) - 2)
        body = "\n".join([drawn[0], rule, *drawn[1:]])
        return f"{self.title}\n\n{body}\n" + (f"{self.note}\n" if self.note else "")

    def markdown(self) -> str:
        """For docs."""
        ruler = [
            "---:" if column >= self.numbers_from else "---" for column in range(len(self.head))
        ]
        lines = [self.head, ruler, *self.rows]
        body = "\n".join("| " + " | ".join(line) + " |" for line in lines)
        return f"**{self.title}**\n\n{body}\n" + (f"\n{self.note}\n" if self.note else "")

    def html(self) -> str:
        """For the report."""
        note = paragraph(self.note, "note") if self.note else ""
        return table(self.head, self.rows, self.numbers_from, self.title) + note
