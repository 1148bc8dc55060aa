"""What a report gives to be drawn, as data; drawing itself is tested with the charts."""

from __future__ import annotations

import copy
from collections.abc import Callable, Sequence
from typing import Any

import pytest

from deltactl.charts import document


def nothing_drawn(specs: Sequence[dict[str, Any]]) -> tuple[str, bool]:
    """Instead of `deltactl.charts.document.document`, in tests of what stands around the charts."""
    return "{}", False


def charts_of(write: Callable[[], str]) -> dict[str, dict[str, Any]]:
    """The charts of the page that `write` makes, by title."""
    seen: list[dict[str, Any]] = []

    def spy(specs: Sequence[dict[str, Any]]) -> tuple[str, bool]:
        seen.extend(copy.deepcopy(list(specs)))
        return nothing_drawn(specs)

    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(document, "document", spy)
        write()
    return {spec["title"]: spec for spec in seen}
