"""Numbers of things in words."""

from __future__ import annotations


def count(number: int, one: str, more: str | None = None) -> str:
    """'one finding', '3 findings'."""
    if number == 1:
        return f"one {one}"
    return f"{number} {more or one + 's'}"
