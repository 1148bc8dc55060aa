"""Work side by side: the same answers as one after the other, whatever becomes of a helper."""

from __future__ import annotations

import errno
import os
import signal
from contextvars import ContextVar
from functools import partial
from pathlib import Path

import pytest

from deltactl.diagnosis.estimation import side_by_side as module
from deltactl.diagnosis.estimation.side_by_side import alone, only_here, side_by_side


@pytest.fixture(autouse=True)
def _two_cores(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(module, "_cores", lambda: 2)
    monkeypatch.setattr(module, "_alone", ContextVar("alone", default=False))


class Held:
    """Something that cannot be pickled."""

    def __init__(self) -> None:
        self.function = lambda: 1


def _in_a_helper(parent: int) -> bool:
    return os.getpid() != parent


def test_answers_come_in_the_order_of_the_tasks() -> None:
    tasks = [partial(pow, 2, k) for k in range(40)]
    assert side_by_side(tasks) == [2**k for k in range(40)]


def test_a_second_process_takes_its_share() -> None:
    assert len(set(side_by_side([partial(_busy, k) for k in range(40)]))) == 2


def _busy(_: int) -> int:
    sum(range(200_000))
    return os.getpid()


def test_a_task_has_its_own_done_side_by_side_when_the_others_have_ended() -> None:
    def long() -> set[int]:
        return set(side_by_side([partial(_busy, k) for k in range(60)]))

    used, _ = side_by_side([long, set])
    assert len(used) == 2


def test_tasks_of_tasks_of_tasks_come_in_their_order() -> None:
    def tree(depth: int, name: str) -> str:
        if not depth:
            return name
        parts = side_by_side([partial(tree, depth - 1, f"{name}{k}") for k in range(4)])
        return f"({' '.join(parts)})"

    with alone():
        expected = tree(3, "")
    assert tree(3, "") == expected


def test_alone_nothing_is_forked() -> None:
    with alone():
        assert set(side_by_side([partial(_busy, k) for k in range(8)])) == {os.getpid()}


def test_known_objects_come_back_as_themselves() -> None:
    held, parent = Held(), os.getpid()

    def task(k: int) -> tuple[int, Held, None]:
        sum(range(200_000))
        return k, held, None

    made = side_by_side([partial(task, k) for k in range(20)], [held])
    assert os.getpid() == parent
    assert all(one[1] is held and one[2] is None for one in made)


def test_what_cannot_be_sent_is_done_again_here() -> None:
    def task(_: int) -> Held:
        sum(range(200_000))
        return Held()

    assert len(side_by_side([partial(task, k) for k in range(20)])) == 20


def test_what_a_task_raises_is_raised() -> None:
    def task(k: int) -> int:
        if k == 7:
            raise ValueError("seven")
        return k

    with pytest.raises(ValueError, match="seven"):
        side_by_side([partial(task, k) for k in range(20)])


def test_what_a_killed_helper_took_is_done_again() -> None:
    parent = os.getpid()

    def task(k: int) -> int:
        sum(range(200_000))
        if _in_a_helper(parent):
            os.kill(os.getpid(), signal.SIGKILL)
        return k

    assert side_by_side([partial(task, k) for k in range(20)]) == list(range(20))


def test_without_room_for_a_process_more_it_is_done_here(monkeypatch: pytest.MonkeyPatch) -> None:
    def no_room() -> int:
        raise OSError(errno.EAGAIN, "no room")

    before = len(os.listdir("/proc/self/fd"))
    monkeypatch.setattr(os, "fork", no_room)
    assert set(side_by_side([partial(_busy, k) for k in range(8)])) == {os.getpid()}
    assert len(os.listdir("/proc/self/fd")) == before


def test_what_a_helper_took_that_was_killed_within_a_task_of_its_own_is_done_again() -> None:
    parent = os.getpid()

    def leaf(k: int) -> int:
        sum(range(200_000))
        if _in_a_helper(parent):
            os.kill(os.getpid(), signal.SIGKILL)
        return k

    def branch(k: int) -> list[int]:
        return side_by_side([partial(leaf, 10 * k + i) for i in range(6)])

    made = side_by_side([partial(branch, k) for k in range(6)])
    assert made == [[10 * k + i for i in range(6)] for k in range(6)]


def test_progress_is_told_by_the_first_process_alone() -> None:
    told: list[str] = []
    say = only_here(told.append)

    def task(k: int) -> tuple[bool, int]:
        sum(range(200_000))
        before = len(told)
        say(f"task {k}")
        return os.getpid() == parent, len(told) - before

    parent = os.getpid()
    made = side_by_side([partial(task, k) for k in range(40)])
    assert all(here == bool(grown) for here, grown in made)
    assert not all(here for here, _ in made)


def test_no_process_and_no_file_is_left_behind() -> None:
    def left() -> tuple[int, str]:
        children = Path(f"/proc/self/task/{os.getpid()}/children")
        return len(os.listdir("/proc/self/fd")), children.read_text()

    before = left()
    for _ in range(5):
        side_by_side([partial(abs, -k) for k in range(6)])
    assert left() == before
