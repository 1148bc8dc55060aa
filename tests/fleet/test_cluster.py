"""The processes that are started here for a fleet."""

from __future__ import annotations

from functools import partial
from typing import Any

import pytest

from deltactl.fleet.run import connected


def callbacks(dask_worker: Any) -> set[str]:
    """What a worker does again and again."""
    return set(dask_worker.periodic_callbacks)


def test_workers_here_keep_no_call_stacks(monkeypatch: pytest.MonkeyPatch) -> None:
    """Dask's profiler keeps those of a thousand seconds, and so hundreds of megabytes."""
    distributed = pytest.importorskip("distributed")
    here = partial(distributed.LocalCluster, processes=False)
    monkeypatch.setattr(distributed, "LocalCluster", here)
    with connected(1, None) as client:
        (found,) = client.run(callbacks).values()
    assert "heartbeat" in found
    assert not {"profile", "profile-cycle"} & found
