"""How long threads wanted to run and had no core: what other work on the machine costs."""

from __future__ import annotations

import contextlib
from pathlib import Path

NS_PER_S = 1e9


def waited_s(*processes: int) -> dict[str, float]:
    """Seconds that each thread of these processes has waited for a core so far.

    /proc/PID/task/TID/schedstat, second field (Documentation/scheduler/sched-stats.rst).
    Processes that have ended have no threads.
    """
    found = {}
    for process in processes:
        for task in Path(f"/proc/{process}/task").glob("*/schedstat"):
            with contextlib.suppress(OSError, IndexError):
                found[task.parent.name] = int(task.read_text().split()[1]) / NS_PER_S
    return found


def all_waits_s(before: dict[str, float], after: dict[str, float]) -> float:
    """What all threads together have waited between two looks.

    Together, because a thread that has the interpreter and no core holds up all others.
    """
    return sum(value - before.get(thread, 0.0) for thread, value in after.items())
