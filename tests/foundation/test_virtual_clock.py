"""The virtual clock: time moves only by sleeping, tasks run in deadline order, always alike."""

from __future__ import annotations

import random

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from deltactl.foundation.clock import NS_PER_S, Task, VirtualClock, ns, sleep_s

Log = list[tuple[str, int]]


def ticking(clock: VirtualClock, log: Log, name: str, period_ns: int, count: int) -> Task:
    for turn in range(1, count + 1):
        log.append((name, clock.now_ns()))
        yield turn * period_ns
    log.append((name + " ends", clock.now_ns()))


def test_time_moves_only_by_sleeping() -> None:
    clock = VirtualClock(start_ns=7)
    assert clock.now_ns() == 7
    sleep_s(clock, 0.5)
    assert clock.now_ns() == 7 + NS_PER_S // 2
    clock.sleep_until_ns(3)  # in the past: no way back
    assert clock.now_ns() == 7 + NS_PER_S // 2


def test_hours_cost_nothing_and_lose_nothing() -> None:
    clock = VirtualClock()
    sleep_s(clock, 3 * 3600.0)
    assert clock.now_ns() == 3 * 3600 * NS_PER_S
    assert ns(0.006) == 6_000_000
    assert ns(1e-9) == 1


def test_tasks_wake_exactly_when_they_asked() -> None:
    clock, log = VirtualClock(), []
    clock.start("slow", ticking(clock, log, "slow", 30, 2))
    clock.start("fast", ticking(clock, log, "fast", 20, 3))
    clock.sleep_until_ns(50)
    assert log == [
        ("slow", 0), ("fast", 0), ("fast", 20), ("slow", 30), ("fast", 40),
    ]  # fmt: skip
    clock.sleep_until_ns(100)
    assert log[5:] == [("slow ends", 60), ("fast ends", 60)]
    assert clock.now_ns() == 100


def test_ties_go_by_who_asked_first() -> None:
    clock, log = VirtualClock(), []
    for name in "abc":
        clock.start(name, ticking(clock, log, name, 10, 2))
    clock.sleep_until_ns(10)
    assert [name for name, _ in log] == list("abcabc")


def test_a_wake_up_in_the_past_is_now() -> None:
    clock, seen = VirtualClock(start_ns=100), []

    def late() -> Task:
        yield 5
        seen.append(clock.now_ns())

    clock.start("late", late())
    clock.sleep_until_ns(100)
    assert seen == [100]


def test_tasks_may_start_tasks() -> None:
    clock, log = VirtualClock(), []

    def parent() -> Task:
        yield 10
        clock.start("child", ticking(clock, log, "child", 15, 2))
        yield 20
        log.append(("parent", clock.now_ns()))

    clock.start("parent", parent())
    clock.sleep_until_ns(40)
    assert log == [("child", 10), ("child", 15), ("parent", 20), ("child ends", 30)]


def test_sleeping_inside_a_task_lets_the_others_run() -> None:
    clock, log = VirtualClock(), []

    def sleeper() -> Task:
        log.append(("sleeper", clock.now_ns()))
        sleep_s(clock, 25e-9)
        log.append(("sleeper woke", clock.now_ns()))
        yield 30
        log.append(("sleeper ends", clock.now_ns()))

    clock.start("sleeper", sleeper())
    clock.start("other", ticking(clock, log, "other", 10, 4))
    clock.sleep_until_ns(50)
    assert log == [
        ("sleeper", 0), ("other", 0), ("other", 10), ("other", 20), ("sleeper woke", 25),
        ("other", 30), ("sleeper ends", 30), ("other ends", 40),
    ]  # fmt: skip
    assert clock.now_ns() == 50


def test_sleeps_nested_three_deep() -> None:
    clock, log = VirtualClock(), []

    def sleeper(name: str, first_ns: int, wake_ns: int) -> Task:
        yield first_ns
        clock.sleep_until_ns(wake_ns)
        log.append((name, clock.now_ns()))

    clock.start("outer", sleeper("outer", 1, 40))
    clock.start("middle", sleeper("middle", 2, 30))
    clock.start("inner", sleeper("inner", 3, 20))
    clock.sleep_until_ns(100)
    assert log == [("inner", 20), ("middle", 30), ("outer", 40)]


def test_stop_ends_a_task_and_runs_its_clean_up() -> None:
    clock, log = VirtualClock(), []

    def careful() -> Task:
        try:
            while True:
                log.append(("tick", clock.now_ns()))
                yield clock.now_ns() + 10
        finally:
            log.append(("cleaned", clock.now_ns()))

    handle = clock.start("careful", careful())
    clock.sleep_until_ns(15)
    assert not handle.done
    handle.stop()
    clock.sleep_until_ns(100)
    assert log == [("tick", 0), ("tick", 10), ("cleaned", 20)]
    assert handle.done
    assert handle.error is None


def failing(after_ns: int) -> Task:
    yield after_ns
    raise RuntimeError("broken")


def test_an_error_reaches_its_handler_and_leaves_the_others_running() -> None:
    clock, log, errors = VirtualClock(), [], []
    handle = clock.start("bad", failing(10), on_error=errors.append)
    clock.start("good", ticking(clock, log, "good", 10, 3))
    clock.sleep_until_ns(40)
    assert [str(error) for error in errors] == ["broken"]
    assert handle.done
    assert handle.error is errors[0]
    assert log[-1] == ("good ends", 30)


def test_an_error_nobody_handles_is_raised_where_it_ran() -> None:
    clock = VirtualClock()
    handle = clock.start("bad", failing(10))
    with pytest.raises(RuntimeError, match="broken"):
        clock.sleep_until_ns(40)
    assert clock.now_ns() == 10
    assert handle.done
    clock.sleep_until_ns(40)  # the clock itself goes on
    assert clock.now_ns() == 40


def busy_run(seed: int, naps_ns: list[int]) -> Log:
    """Tasks that wait random times, some by sleeping, and start further tasks."""
    clock, log = VirtualClock(), []
    chance = random.Random(seed)

    def wander(name: str, depth: int) -> Task:
        for turn in range(4):
            log.append((name, clock.now_ns()))
            if chance.random() < 0.3:
                clock.sleep_until_ns(clock.now_ns() + chance.randrange(50))
            if depth < 2 and chance.random() < 0.3:
                clock.start(f"{name}.{turn}", wander(f"{name}.{turn}", depth + 1))
            yield clock.now_ns() + chance.randrange(100)

    for index in range(5):
        clock.start(str(index), wander(str(index), 0))
    for nap_ns in naps_ns:
        before_ns = clock.now_ns()
        clock.sleep_until_ns(before_ns + nap_ns)
        assert clock.now_ns() >= before_ns + nap_ns
    return log


@settings(max_examples=25, deadline=None)
@given(st.integers(0, 10**6), st.lists(st.integers(0, 300), max_size=8))
def test_every_run_is_the_same_and_time_never_goes_back(seed: int, naps_ns: list[int]) -> None:
    log = busy_run(seed, naps_ns)
    assert log == busy_run(seed, naps_ns)
    times_ns = [time_ns for _, time_ns in log]
    assert times_ns == sorted(times_ns)
