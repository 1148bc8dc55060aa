"""The processes of the program: where their code lies, threads, garbage collection."""

from __future__ import annotations

import gc
import os
from collections.abc import Callable
from functools import wraps
from pathlib import Path
from typing import ParamSpec, TypeVar

PACKAGE = Path(__file__).resolve().parents[1]
"""The folder `deltactl`, which holds code, robot files, networks and services."""
IMPORT_ROOT = PACKAGE.parent
"""The folder that `deltactl` is imported from: the working copy, or site-packages."""


def importable(environment: dict[str, str]) -> dict[str, str]:
    """Return `environment` with this program first on the path of a Python process that it starts.

    `python -P -m deltactl...` then runs the same code, however the parent was started.
    """
    path = [str(IMPORT_ROOT), environment.get("PYTHONPATH", "")]
    return environment | {"PYTHONPATH": ":".join(filter(None, path))}


Given = ParamSpec("Given")
Made = TypeVar("Made")


def one_thread(work: Callable[Given, Made]) -> Callable[Given, Made]:
    """Run `work` with the BLAS held to one thread.

    Where products are small, two threads spend their time waiting for each other (twice the time on
    a busy machine), and they add in another order: neither a seed nor a recording would give the
    same twice on machines with different cores.
    """

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


SELDOM = (50_000, 20, 100)


def rarely_collected(work: Callable[Given, Made]) -> Callable[Given, Made]:
    """Run `work` with what is there before it left out of garbage collection, and the rest seldom
    collected: at the end, so that what it leaves in cycles takes no memory beside the next.

    Every collection looks at all the objects there are, those of the imported libraries included: a
    tenth of the time of a diagnosis. In a fork it also writes to them, and so copies their pages.
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
            gc.collect()
            gc.unfreeze()

    return held
