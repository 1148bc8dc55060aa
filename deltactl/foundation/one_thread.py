"""One thread for the arithmetic libraries, where their products are small.

Two threads spend their time waiting for each other then (twice the time on a busy machine), and
they add in another order, so that neither a seed nor a recording would give the same twice on
machines with different cores.
"""

from __future__ import annotations

import os
from collections.abc import Callable
from functools import wraps
from typing import ParamSpec, TypeVar

Given = ParamSpec("Given")
Made = TypeVar("Made")


def one_thread(work: Callable[Given, Made]) -> Callable[Given, Made]:
    """Run `work` with the BLAS held to one thread."""

    @wraps(work)
    def held(*given: Given.args, **named: Given.kwargs) -> Made:
        from threadpoolctl import threadpool_limits  # a robot has no need of it

        with threadpool_limits(limits=1, user_api="blas"):
            return work(*given, **named)

    return held


def one_thread_in_this_program() -> None:
    """Hold OpenBLAS to one thread here and in child processes; before numpy is loaded.

    Its other threads wait by spinning: beside a control loop that inverts small matrices a hundred
    times a second each of them took a whole core. What the user has set stays.
    """
    os.environ.setdefault("OPENBLAS_NUM_THREADS", "1")
