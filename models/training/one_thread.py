"""One thread for the arithmetic libraries while a network is trained.

The products of a training are small: two threads spend their time waiting for each other (twice
the time on a busy machine), and they add in another order, so that a seed would not repeat a file.
"""

from __future__ import annotations

from collections.abc import Callable
from functools import wraps
from typing import ParamSpec, TypeVar

from threadpoolctl import threadpool_limits

Given = ParamSpec("Given")
Made = TypeVar("Made")


def one_thread(work: Callable[Given, Made]) -> Callable[Given, Made]:
    """Run `work` with the BLAS held to one thread."""

    @wraps(work)
    def held(*given: Given.args, **named: Given.kwargs) -> Made:
        with threadpool_limits(limits=1, user_api="blas"):
            return work(*given, **named)

    return held
