"""Independent pieces of work side by side, in as many processes as there are cores for.

Threads do not help work of many small array operations, and processes that are started anew would
have to be sent all that a search holds in memory. A fork has it already.

Tasks may themselves have work to do side by side. There is a seat for every core; who finds one
free forks a helper, who has nothing left to do gives its own back (as `make` does with its jobs).
"""

from __future__ import annotations

import os
import pickle
import signal
import warnings
from collections.abc import Callable, Iterator, Mapping, Sequence
from contextlib import contextmanager
from contextvars import ContextVar
from select import select
from typing import Any, BinaryIO, Generic, TypeVar

MOST_PROCESSES = 4
"""Processes at once, this one counted: what each changes of the memory it has from here adds up."""
MOST_TASKS = 256
"""The number of a task is one byte."""

Made = TypeVar("Made")
_alone: ContextVar[bool] = ContextVar("alone", default=False)
_seats: ContextVar[_Seats | None] = ContextVar("seats", default=None)


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
    cores = min(_cores(), MOST_PROCESSES)
    if cores < 2 or _alone.get() or not 1 < len(tasks) <= MOST_TASKS:
        return [task() for task in tasks]
    seats = _seats.get()
    if seats is not None:
        return _Work(tasks, known, seats).done()
    seats = _Seats(cores - 1)
    token = _seats.set(seats)
    try:
        return _Work(tasks, known, seats).done()
    finally:
        _seats.reset(token)
        seats.close()


def only_here(say: Callable[[str], None]) -> Callable[[str], None]:
    """Say it in this process only: what shows it may hold a lock that a fork never gets."""
    here = os.getpid()

    def said(text: str) -> None:
        if os.getpid() == here:
            say(text)

    return said


def _cores() -> int:
    return len(os.sched_getaffinity(0)) if hasattr(os, "sched_getaffinity") else 1


class _Heap:
    """Bytes that several processes take from, one by one, without waiting for more."""

    def __init__(self, given: bytes):
        self._take, self._put = os.pipe()
        os.set_blocking(self._take, False)
        self.put(given)

    def put(self, given: bytes) -> None:
        """Add some."""
        os.write(self._put, given)

    def take(self) -> int | None:
        """One of them; None when there are none."""
        try:
            return os.read(self._take, 1)[0]
        except BlockingIOError:
            return None

    @property
    def any_left(self) -> bool:
        """Whether there is one, for whoever comes first."""
        return bool(select([self._take], [], [], 0.0)[0])

    def close(self) -> None:
        """Let go of it."""
        os.close(self._take)
        os.close(self._put)


class _Seats:
    """One for each core; this process has the first."""

    def __init__(self, others: int):
        self._free = _Heap(bytes(others))
        self._have = True

    def take(self) -> bool:
        """Take a free one for a helper."""
        return self._free.take() is not None

    def put_back(self) -> None:
        """Nobody came to sit on the one that was taken."""
        self._free.put(bytes(1))

    def leave(self) -> None:
        """Give the own one back: there is nothing to do here for now."""
        if self._have:
            self._free.put(bytes(1))
        self._have = False

    def come_back(self) -> None:
        """Go on, with a seat if one is free."""
        self._have = self._have or self.take()

    def sit(self) -> None:
        """A helper's: it was given one."""
        self._have = True

    def close(self) -> None:
        """Nobody needs them any more."""
        self._free.close()


class _Work(Generic[Made]):
    """Tasks that wait, and the helpers that were started for them."""

    def __init__(self, tasks: Sequence[Callable[[], Made]], known: Sequence[object], seats: _Seats):
        self.tasks, self.seats = tasks, seats
        self.known: Mapping[int, object] = {id(one): one for one in known}
        self.waiting = _Heap(bytes(range(len(tasks))))
        self.helpers: list[tuple[int, BinaryIO]] = []

    def done(self) -> list[Made]:
        """All of it."""
        try:
            made = self._worked_off(self._call_helpers)
            self.seats.leave()
            for _, answers in self.helpers:
                made.update(_receive(answers, self.known) or {})
            self.seats.come_back()
            return [made[k] if k in made else task() for k, task in enumerate(self.tasks)]
        finally:
            self.waiting.close()
            for pid, answers in self.helpers:
                answers.close()
                os.kill(pid, signal.SIGKILL)
                os.waitpid(pid, 0)

    def _worked_off(self, meanwhile: Callable[[], None]) -> dict[int, Made]:
        """Tasks done, by their numbers, as long as one waits."""
        made: dict[int, Made] = {}
        while (number := self.waiting.take()) is not None:
            meanwhile()
            made[number] = self.tasks[number]()
        return made

    def _call_helpers(self) -> None:
        """One for every free seat, as long as a task waits."""
        while self.waiting.any_left and self.seats.take():
            try:
                self.helpers.append(self._forked())
            except OSError:  # no room for a process more
                self.seats.put_back()
                break

    def _forked(self) -> tuple[int, BinaryIO]:
        """A process that takes its share of the tasks: its number, and where its answers come."""
        answers, say = os.pipe()
        with warnings.catch_warnings():
            # Python 3.12 warns of threads that may hold a lock: a task only calculates.
            warnings.simplefilter("ignore", DeprecationWarning)
            try:
                pid = os.fork()
            except OSError:
                os.close(answers)
                os.close(say)
                raise
        if pid:
            os.close(say)
            return pid, open(answers, "rb")
        # A thread that is not here may have held the lock of standard error for ever.
        warnings.showwarning = _quiet
        try:
            self.seats.sit()
            try:
                made = self._worked_off(lambda: None)
            finally:
                self.seats.leave()
            with open(say, "wb") as out:
                _Sender(out, self.known).dump(made)
        finally:
            os._exit(0)


def _quiet(*_: object, **__: object) -> None:
    """Show no warning; one that is an error still ends the process."""


def _receive(source: BinaryIO, known: Mapping[int, object]) -> Any:
    """What was sent; None when it did not come to its end."""
    try:
        return _Receiver(source, known).load()
    except (EOFError, pickle.UnpicklingError):
        return None


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
