"""Pieces of work that do not need each other, on all cores; arrays let go of the interpreter."""

from __future__ import annotations

import os
from collections.abc import Callable, Iterable
from concurrent.futures import ThreadPoolExecutor
from functools import cache
from threading import current_thread
from typing import TypeVar

CORES = min(len(os.sched_getaffinity(0)), 4)
"""More would stand in line for the interpreter."""
NAME = "at-once"


Given = TypeVar("Given")
Made = TypeVar("Made")


def at_once(work: Callable[[Given], Made], items: Iterable[Given]) -> list[Made]:
    """Results in the order of the items; a piece of work that asks for the same gets it in turn."""
    if CORES < 2 or current_thread().name.startswith(NAME):
        return [work(item) for item in items]
    return list(_threads().map(work, items))


@cache
def _threads() -> ThreadPoolExecutor:
    return ThreadPoolExecutor(CORES, thread_name_prefix=NAME)


os.register_at_fork(after_in_child=_threads.cache_clear)
