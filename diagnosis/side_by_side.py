"""Independent pieces of work side by side, in as many processes as there are cores for.

Threads do not help work of many small array operations, and processes that are started anew would
have to be sent all that a search holds in memory. A fork has it already.
"""

from __future__ import annotations

import os
import pickle
import signal
import warnings
from collections.abc import Callable, Iterator, Mapping, Sequence
from contextlib import contextmanager
from contextvars import ContextVar
from typing import BinaryIO, TypeVar

MOST = 4
"""Processes at once, this one counted: what each changes of the memory it has from here adds up."""
MOST_TASKS = 256
"""The number of a task is one byte."""

Made = TypeVar("Made")
_alone: ContextVar[bool] = ContextVar("alone", default=False)


@contextmanager
def alone() -> Iterator[None]:
    """Within it nothing is forked: the other cores are taken."""
    token = _alone.set(True)
    try:
        yield
    finally:
        _alone.reset(token)


def side_by_side(tasks: Sequence[Callable[[], Made]], known: Sequence[object] = ()) -> list[Made]:
    """What the tasks return, in their order: the same as one after the other, only sooner.

    A task must change nothing that others look at, and return what can be pickled, but for the
    `known` objects, which come back as themselves. What a task raises is raised; what a process
    took with it when it was killed is done again.
    """
    helpers = min(_cores(), len(tasks), MOST) - 1
    if helpers < 1 or _alone.get() or len(tasks) > MOST_TASKS:
        return [task() for task in tasks]
    by_id = {id(one): one for one in known}
    waiting, fill = os.pipe()
    os.write(fill, bytes(range(len(tasks))))
    os.close(fill)
    with alone():
        started = [_forked(waiting, tasks, by_id) for _ in range(helpers)]
        try:
            made = _worked_off(waiting, tasks)
            for _, answers in started:
                made.update(_answered(answers, by_id))
            return [made[k] if k in made else task() for k, task in enumerate(tasks)]
        finally:
            os.close(waiting)
            for pid, answers in started:
                answers.close()
                os.kill(pid, signal.SIGKILL)
                os.waitpid(pid, 0)


def only_here(say: Callable[[str], None]) -> Callable[[str], None]:
    """Say it in this process only: what shows it may hold a lock that a fork never gets."""
    here = os.getpid()

    def said(text: str) -> None:
        if os.getpid() == here:
            say(text)

    return said


def _cores() -> int:
    return len(os.sched_getaffinity(0)) if hasattr(os, "sched_getaffinity") else 1


def _worked_off(waiting: int, tasks: Sequence[Callable[[], Made]]) -> dict[int, Made]:
    """Tasks done, by their numbers, as long as one waits."""
    made = {}
    while number := os.read(waiting, 1):
        made[number[0]] = tasks[number[0]]()
    return made


def _forked(
    waiting: int, tasks: Sequence[Callable[[], Made]], known: Mapping[int, object]
) -> tuple[int, BinaryIO]:
    """A process that takes its share of the tasks: its number, and where its answers come."""
    answers, say = os.pipe()
    with warnings.catch_warnings():
        # Python 3.12 warns of threads that may hold a lock: a task only calculates.
        warnings.simplefilter("ignore", DeprecationWarning)
        pid = os.fork()
    if pid:
        os.close(say)
        return pid, open(answers, "rb")
    # A thread that is not here may have held the lock of standard error for ever.
    warnings.showwarning = _quiet
    try:
        made = _worked_off(waiting, tasks)
        with open(say, "wb") as out:
            _Sender(out, known).dump(made)
    finally:
        os._exit(0)


def _quiet(*_: object, **__: object) -> None:
    """Show no warning; one that is an error still ends the process."""


def _answered(answers: BinaryIO, known: Mapping[int, object]) -> dict[int, Made]:
    try:
        made: dict[int, Made] = _Receiver(answers, known).load()
    except (EOFError, pickle.UnpicklingError):
        return {}
    return made


class _Sender(pickle.Pickler):
    """Sends known objects as their number in memory, which a fork shares."""

    def __init__(self, out: BinaryIO, known: Mapping[int, object]):
        super().__init__(out, protocol=pickle.HIGHEST_PROTOCOL)
        self.known = known

    def persistent_id(self, obj: object) -> int | None:
        """The number of a known object."""
        return id(obj) if id(obj) in self.known else None


class _Receiver(pickle.Unpickler):
    """Puts the known objects back in their places."""

    def __init__(self, source: BinaryIO, known: Mapping[int, object]):
        super().__init__(source)
        self.known = known

    def persistent_load(self, pid: int) -> object:
        """The object of a number."""
        return self.known[pid]
