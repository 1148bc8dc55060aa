"""The machine's clock keeps the same promises, only in real time."""

from __future__ import annotations

import threading

from deltactl.foundation.clock import RealClock, Task, ns


def test_never_wakes_early() -> None:
    clock = RealClock()
    wake_ns = clock.now_ns() + ns(0.02)
    clock.sleep_until_ns(wake_ns)
    assert clock.now_ns() >= wake_ns
    clock.sleep_until_ns(wake_ns - ns(1.0))  # in the past: at once


def test_tasks_run_beside_the_caller_and_never_early() -> None:
    clock, finished, early = RealClock(), threading.Event(), []

    def task() -> Task:
        for _ in range(5):
            wake_ns = clock.now_ns() + ns(0.002)
            yield wake_ns
            early.append(clock.now_ns() < wake_ns)
        finished.set()

    clock.start("ticks", task())
    assert finished.wait(30.0)
    assert early == [False] * 5


def test_stop_and_errors_end_the_thread() -> None:
    clock, cleaned, failed = RealClock(), threading.Event(), threading.Event()

    def endless() -> Task:
        try:
            while True:
                yield clock.now_ns() + ns(0.001)
        finally:
            cleaned.set()

    def broken() -> Task:
        yield clock.now_ns()
        raise RuntimeError("broken")

    handle = clock.start("endless", endless())
    handle.stop()
    assert cleaned.wait(30.0)
    bad = clock.start("broken", broken(), on_error=lambda _: failed.set())
    assert failed.wait(30.0)
    assert str(bad.error) == "broken"
