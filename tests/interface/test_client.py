"""The daemon's robot from Python: jog, run, status, stop."""

from __future__ import annotations

import threading
from collections.abc import Iterator
from pathlib import Path

import numpy as np
import pytest

import deltactl as dc
from deltactl.foundation.errors import ConfigError, MotionError, NotReady, ServiceError
from tests.rigs.served import Served, served

STEP_M = 1.5e-4
"""About what a whole step of a motor moves this platform."""


@pytest.fixture(scope="module")
def robot(tmp_path_factory: pytest.TempPathFactory) -> Iterator[Served]:
    """A simulated robot that is homed, and its socket."""
    with served(tmp_path_factory.mktemp("daemon")) as one:
        yield one


@pytest.fixture
def client(robot: Served) -> Iterator[dc.Client]:
    """A connection to it."""
    robot.ready()
    with dc.Client(robot.socket) as one:
        yield one


def test_jog_moves_by_metres(client: dc.Client) -> None:
    before = next(client.status())
    assert before.state == "ready"
    assert before.position_m is not None
    assert client.jog(x_m=0.004, z_m=-0.003, speed_mps=0.2).outcome == "done"
    after = next(client.status()).position_m
    moved = np.subtract(after, before.position_m)
    np.testing.assert_allclose(moved, [0.004, 0.0, -0.003], atol=2 * STEP_M)


def test_what_is_refused_does_not_move(client: dc.Client) -> None:
    before = next(client.status()).counts
    with pytest.raises(ConfigError, match="how far"):
        client.jog()
    with pytest.raises(MotionError, match="out of reach"):
        client.jog(z_m=-0.9)
    assert next(client.status()).counts == before


def test_the_status_goes_on_while_a_job_runs_until_it_is_stopped(
    client: dc.Client, robot: Served, tmp_path: Path
) -> None:
    job = tmp_path / "round.yaml"
    job.write_text(
        "name: round\nrobot: mine.yaml\n"
        "path: {shape: circle, centre_m: [0.0, 0.0, -0.31], radius_m: 0.02, turns: 50}\n"
        "timing: {mode: accelerated, speed_mps: 0.05}\ninverse_kinematics: {kind: geometry}\n"
    )
    ended = []
    runs = threading.Thread(target=lambda: ended.append(client.run(job)))
    runs.start()
    seen = set()
    with dc.Client(robot.socket) as other:
        for now in other.status(rate_hz=20.0):
            seen.add(now.state)
            # What was sent before the stop may still come after it: it is stopped once.
            if "stopping" not in seen and now.state == "running" and now.progress > 0.0:
                seen.add("stopping")
                with pytest.raises(NotReady, match="running"):
                    other.jog(x_m=0.001)
                other.stop("enough")
            if now.state == "stopped":
                break
    runs.join(30.0)
    assert {"running", "stopped"} <= seen
    assert (ended[0].outcome, "enough" in ended[0].why) == ("stopped", True)
    with pytest.raises(NotReady, match="home"):
        client.jog(x_m=0.001)
    client.acknowledge()
    client.home()
    assert next(client.status()).state == "ready"


def test_without_a_daemon_one_line_says_so(tmp_path: Path) -> None:
    with pytest.raises(ServiceError, match="no daemon"):
        next(dc.Client(tmp_path / "no.sock").status())
