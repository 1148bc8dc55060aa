"""A mistake made by hand."""

from __future__ import annotations

from typing import NamedTuple


class Named(NamedTuple):
    """What it is, its file, what stands there, and what is put in its place."""

    what: str
    path: str
    was: str
    now: str
