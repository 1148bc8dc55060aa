"""A wrong file is refused in time proportional to it, with twenty mistakes at most."""

from __future__ import annotations

import gc
import time
from pathlib import Path

import pytest

from deltactl.firmware_py.file_access import FileAccess
from deltactl.firmware_py.planning.prepared import read_robot_here
from deltactl.firmware_py.program.includes import read_whole
from deltactl.foundation.errors import ConfigError
from tests.rigs.large_requests import JOB, JOBS, MB, ROBOT_FILE, WRONG

SMALL, LARGE = MB // 5, 4 * MB
SMALL_S, LARGE_S = 1.0, 4.0
"""CPU time; a quarter of it is usual. Five thousand unknown keys, 40 kB, once took 135 s."""
TRIES = 3
"""The least time counts: CPU time doubles where the other half of a core is busy."""
MOST_LINES = 50
"""Twenty mistakes of the file, as many of what else is wrong, and how many more there are."""
LEGIT_POSES = 60_000


def refusal(path: Path, job: bool, most_s: float = LARGE_S) -> tuple[str, float]:
    """The message for a file, empty for one that is right, and the least CPU time of the tries.

    A try that took less than `most_s` is the last.
    """
    least_s = float("inf")
    for _ in range(TRIES):
        says, took_s = one_refusal(path, job)
        least_s = min(least_s, took_s)
        if least_s < most_s:
            break
    return says, least_s


def one_refusal(path: Path, job: bool) -> tuple[str, float]:
    """The message for a file, and the CPU time that it took.

    Without the collector, as in the process that reads files for the daemon: it would look through
    all that these tests have imported.
    """
    says = ""
    gc.disable()
    begun_s = time.process_time()
    try:
        if job:
            read_whole(path, FileAccess(most_bytes=4 * 2**20))
        else:
            read_robot_here(path, FileAccess(most_bytes=4 * 2**20))
    except ConfigError as error:
        says = str(error)
    finally:
        gc.enable()
    return says, time.process_time() - begun_s


@pytest.mark.parametrize("name", WRONG)
def test_a_robot_file_of_each_kind(name: str, tmp_path: Path) -> None:
    path, added = tmp_path / "robot.yaml", WRONG[name](SMALL)
    text = ROBOT_FILE.read_text()
    path.write_text(added + text if added.startswith("%") else text + added)
    says, took_s = refusal(path, job=False, most_s=SMALL_S)
    assert took_s < SMALL_S
    assert says or name in ("comments", "blank lines")
    assert len(says.splitlines()) <= MOST_LINES
    assert len(says) < 20_000


@pytest.mark.parametrize("name", JOBS)
def test_a_job_of_each_kind(name: str, tmp_path: Path) -> None:
    path = tmp_path / "job.yaml"
    path.write_text(JOB + JOBS[name](SMALL))
    says, took_s = refusal(path, job=True, most_s=SMALL_S)
    assert took_s < SMALL_S
    assert says
    assert len(says.splitlines()) <= MOST_LINES


@pytest.mark.study
@pytest.mark.parametrize("name", ["names near a key", "empty lists"])
def test_one_of_four_megabytes(name: str, tmp_path: Path) -> None:
    path = tmp_path / "robot.yaml"
    path.write_text(ROBOT_FILE.read_text() + WRONG[name](LARGE))
    says, took_s = refusal(path, job=False)
    assert says
    assert took_s < LARGE_S


@pytest.mark.study
def test_the_first_mistakes_of_a_long_file_are_listed_with_their_lines(tmp_path: Path) -> None:
    """So is the one mistake that comes late; what only a part would break is not made up."""
    path = tmp_path / "job.yaml"
    head = JOB + "path:\n  shape: joints\n  angles_deg:\n"
    rows = ["  - [30.0, 31.0, 32.0]"] * LEGIT_POSES
    path.write_text(head + "\n".join(rows) + "\n")
    assert refusal(path, job=True)[0] == ""
    begins = len(head.splitlines()) + 1
    late = 50_000
    path.write_text(head + "\n".join([*rows[:late], "  - [30.0, x, 32.0]", *rows[late:]]) + "\n")
    says = refusal(path, job=True)[0].splitlines()
    assert len(says) == 1
    assert f"job.yaml:{begins + late}: path.angles_deg.{late}.1: " in says[0]
    path.write_text(head + "\n".join(["  - [30.0, x, 32.0]"] * LEGIT_POSES) + "\n")
    says = refusal(path, job=True)[0].splitlines()
    assert [int(one.split(":")[1]) for one in says[:20]] == list(range(begins, begins + 20))
    assert "at least" in says[20]


def test_how_many_more_is_said_exactly_where_it_is_known(tmp_path: Path) -> None:
    path = tmp_path / "robot.yaml"
    path.write_text(ROBOT_FILE.read_text() + "".join(f"qk{n}: 1\n" for n in range(33)))
    assert refusal(path, job=False)[0].endswith("and 13 more mistakes")
