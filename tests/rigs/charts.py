"""What a report gives to be drawn, as data."""

from __future__ import annotations

import copy
from collections.abc import Callable, Sequence
from typing import Any

import pytest

from charts import document


def charts_of(write: Callable[[], str]) -> dict[str, dict[str, Any]]:
    """The charts of the page that `write` makes, by title."""
    seen: list[dict[str, Any]] = []
    draw = document.document

    def spy(specs: Sequence[dict[str, Any]]) -> tuple[str, bool]:
        seen.extend(copy.deepcopy(list(specs)))
        return draw(specs)

    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(document, "document", spy)
        write()
    return {spec["title"]: spec for spec in seen}
