"""Rare garbage collection, where there are many objects and little garbage.

Every collection looks at all the objects there are, those of the imported libraries included: a
tenth of the time of a diagnosis. In a fork it also writes to them, and so copies their pages.
"""

from __future__ import annotations

import gc
from collections.abc import Callable
from functools import wraps
from typing import ParamSpec, TypeVar

Given = ParamSpec("Given")
Made = TypeVar("Made")

SELDOM = (50_000, 20, 100)


def rarely_collected(work: Callable[Given, Made]) -> Callable[Given, Made]:
    """Run `work` with what is there before it left out of garbage collection, and the rest seldom
    collected.
    """

    @wraps(work)
    def held(*given: Given.args, **named: Given.kwargs) -> Made:
        before = gc.get_threshold()
        gc.freeze()
        gc.set_threshold(*SELDOM)
        try:
            return work(*given, **named)
        finally:
            gc.set_threshold(*before)
            gc.unfreeze()

    return held
