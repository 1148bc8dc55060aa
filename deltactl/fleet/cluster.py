"""Where recordings are diagnosed: here, on local processes, or on a Dask scheduler's machines."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Iterator
from contextlib import contextmanager
from typing import Any

from deltactl.foundation.errors import ConfigError
from deltactl.foundation.extras import needs

AHEAD = 4
"""So many recordings a worker wait with the scheduler: memory does not grow with the fleet."""
PROFILER = "distributed.worker.profile.enabled"
"""Off where the workers are ours: a hundred times a second it notes the stack of what runs, and
keeps that for a thousand seconds. Deep in a diagnosis that is some 2 MB more a recording."""
Call = tuple[Any, tuple[Any, ...]]
"""A key, and the arguments of the task."""
Run = Callable[[Callable[..., Any], Iterable[Call]], Iterator[tuple[Any, Any]]]


@contextmanager
def cluster(workers: int, scheduler: str | None) -> Iterator[Run]:
    """A function that runs a task on many arguments and gives (key, result) as they come.

    0 workers is this process. Raises ConfigError when nobody answers at the address.
    """
    if scheduler is None and workers == 0:
        yield lambda task, calls: ((key, task(*given)) for key, given in calls)
        return
    with needs("fleet", "deltactl diagnose --fleet"):
        from distributed import as_completed
    with connected(workers, scheduler) as client:
        yield _spread(client, as_completed)


@contextmanager
def connected(workers: int, scheduler: str | None) -> Iterator[Any]:
    """A Dask client of the scheduler at an address, or of so many processes here.

    Raises ConfigError when nobody answers at the address.
    """
    import dask
    import distributed

    make: Any = distributed  # its constructors have no types
    if scheduler is not None:
        try:
            client = make.Client(scheduler, timeout="10s")
        except (OSError, ValueError) as error:
            raise ConfigError(
                f"--scheduler {scheduler}: nobody answers there; start `dask scheduler` and give "
                "the address it prints"
            ) from error
        with client:
            yield client
        return
    with (
        dask.config.set({PROFILER: False}),
        make.LocalCluster(n_workers=workers, threads_per_worker=1, dashboard_address=":0") as local,
        make.Client(local) as client,
    ):
        yield client


def _spread(client: Any, as_completed: Any) -> Run:
    def run(task: Callable[..., Any], calls: Iterable[Call]) -> Iterator[tuple[Any, Any]]:
        threads = max(1, sum(client.nthreads().values()))
        waiting = iter(calls)
        finished = as_completed()
        keys: dict[str, Any] = {}

        def send() -> None:
            for key, given in waiting:
                future = client.submit(task, *given, pure=False, retries=1)
                keys[future.key] = key
                finished.add(future)
                return

        for _ in range(AHEAD * threads):
            send()
        for future in finished:
            send()
            key = keys.pop(future.key)
            if future.status == "finished":
                yield key, future.result()
            else:
                yield key, {"error": f"{key}: its worker failed: {future.exception()}"}
            future.release()

    return run
