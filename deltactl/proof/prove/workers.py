"""Where cases are run: in this process, on a local cluster, or on a Dask scheduler's machines."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from contextlib import contextmanager
from typing import Any, cast

from deltactl.fleet.run import connected
from deltactl.foundation.errors import ConfigError, ServiceError
from deltactl.foundation.extras import how_to_install

Result = tuple[int, dict[str, Any]]
"""The place of a job in the list that was given, and what came of it."""
Task = Callable[[int, int], dict[str, Any]]
"""A seed and a number -> a result as JSON; must be importable where it runs."""
Job = tuple[Task, int, int]
Run = Callable[[Sequence[Job]], Iterator[Result]]
ALONE = ": one case after another, here"
NO_DASK = f"Dask is not installed ({how_to_install('proof')}){ALONE}"


def here(jobs: Sequence[Job]) -> Iterator[Result]:
    """One case after another in this process."""
    for place, (task, seed, number) in enumerate(jobs):
        yield place, task(seed, number)


@contextmanager
def workers(count: int, scheduler: str | None, say: Callable[[str], None]) -> Iterator[Run]:
    """A function that runs cases; 0 workers is this process, an address is a Dask scheduler.

    Raises ConfigError when the scheduler is named but cannot be had; the function it gives raises
    ServiceError at its end when workers lost cases.
    """
    if scheduler is None and count == 0:
        yield here
        return
    try:
        from distributed import as_completed
    except ImportError as error:
        if scheduler is not None:
            raise ConfigError(f"--scheduler {scheduler}: {NO_DASK.removesuffix(ALONE)}") from error
        say(NO_DASK)
        yield here
        return
    finished = cast(Callable[[Any], Iterator[Any]], as_completed)
    with connected(count, scheduler) as client:

        def spread(jobs: Sequence[Job]) -> Iterator[Result]:
            # The first have the highest priority: a proof that is cut off lacks only the last.
            waiting = {
                client.submit(task, seed, number, pure=False, priority=-place): place
                for place, (task, seed, number) in enumerate(jobs)
            }
            lost: list[str] = []
            for future in finished(list(waiting)):
                if future.status == "finished":
                    yield waiting[future], future.result()
                else:
                    number = jobs[waiting[future]][2]
                    lost.append(f"number {number}: {future.exception()}")
                future.release()
            if lost:
                raise ServiceError(
                    f"{len(lost)} did not finish on the workers ({lost[0]}); "
                    "the same command again runs only those"
                )

        yield spread
