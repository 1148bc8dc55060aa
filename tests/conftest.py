"""What all tests share: the `--hardware` switch, and which tests watch the real clock.

A test that can also run on the robot takes its backend as a parameter,
`pytest.param("hardware", marks=pytest.mark.hardware)` beside `"fake"`; without `--hardware`
that half is skipped, so the same contract is checked on both.

Tests that hold something to the real clock are marked `realtime` here, by place: beside other
tests on a small machine they would measure the other tests. `make test` runs them by themselves.
"""

from __future__ import annotations

import gc
import os
from collections.abc import Iterator
from functools import cache
from pathlib import Path

import hypothesis  # first: what gc.freeze hides later, its plugin of trio warns of
import pytest

hypothesis.settings.register_profile("repeatable", derandomize=True, deadline=None)
hypothesis.settings.register_profile("explore", deadline=None)
# That a test fails is enough there: no simpler example is searched for.
QUICK = (hypothesis.Phase.explicit, hypothesis.Phase.generate)
hypothesis.settings.register_profile("mutants", derandomize=True, deadline=None, phases=QUICK)
hypothesis.settings.load_profile(os.environ.get("HYPOTHESIS_PROFILE", "repeatable"))
"""The same cases each time, so that a change is not blamed for what was always wrong; new ones are
drawn on request."""

APART = {
    "newcomer": "takes minutes and downloads packages: make newcomer",
    "release": "builds and downloads packages: make release-check",
    "study": "takes minutes: make studies",
}
"""Marks of tests that `make test` leaves out, and why."""
REAL_TIME = (
    "tests/cli/test_heal_interrupted.py",
    "tests/daemon/test_daemon_end_to_end.py",
    "tests/faults/test_fault_campaign.py",
    "tests/foundation/test_real_clock.py",
    "tests/hil/",
    "tests/steps/test_pulse_process.py",
    "tests/steps/test_through_lgpio.py",
    "TestPulseProcess",
)
"""Parts of the names of tests."""
PAGE = ("simulated", "signed_in", "chromium")
"""Fixtures of tests/web: the page with its robot, which keeps time, and a browser that looks at it.
One process has them: a second page and a second browser would cost as much as all their tests.
"""


@pytest.fixture(autouse=True, scope="session")
def commands_made_once() -> Iterator[None]:
    """A process of one's own makes the commands once; Typer does so for each call in this one."""
    import typer.main
    import typer.testing

    made = cache(typer.main.get_command)
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(typer.main, "get_command", made)
        patch.setattr(typer.testing, "_get_command", made)
        yield


def pytest_collection_finish() -> None:
    """What all tests import stays: the collector need not look through it again and again."""
    gc.freeze()


def pytest_addoption(parser: pytest.Parser) -> None:
    group = parser.getgroup("deltactl")
    group.addoption(
        "--hardware",
        action="store_true",
        default=False,
        help="also run the tests marked 'hardware', on a Raspberry Pi with the robot wired up",
    )
    group.addoption(
        "--move",
        action="store_true",
        default=False,
        help="let the hardware tests energise the drives and move the robot; put the arms"
        " against their stops first, and keep a hand on the e-stop",
    )
    group.addoption(
        "--robot",
        default="zhao-2023.yaml",
        help="robot file whose pins and addresses the hardware tests use",
    )


def pytest_ignore_collect(collection_path: Path, config: pytest.Config) -> bool | None:
    """Of the tests against the clock alone, the files that have some: to import all takes longer
    than many a folder takes to run.
    """
    if config.getoption("-m") != "realtime" or collection_path.suffix != ".py":
        return None
    place = collection_path.as_posix()
    if any(part in place for part in REAL_TIME):
        return None
    text = collection_path.read_text(encoding="utf-8")
    words = ("mark.realtime", *REAL_TIME, *(PAGE if "tests/web/" in place else ()))
    return not any(part in text for part in words)


def fixtures_of(item: pytest.Item) -> list[str]:
    return item.fixturenames if isinstance(item, pytest.Function) else []


def pytest_collection_modifyitems(config: pytest.Config, items: list[pytest.Item]) -> None:
    for item in items:
        of_the_page = item.nodeid.startswith("tests/web/") and set(PAGE) & set(fixtures_of(item))
        if of_the_page or any(part in item.nodeid for part in REAL_TIME):
            item.add_marker(pytest.mark.realtime)
    for mark, why in APART.items():
        if mark not in config.getoption("-m"):
            for item in items:
                if item.get_closest_marker(mark):
                    item.add_marker(pytest.mark.skip(reason=why))
    if config.getoption("--hardware"):
        return
    skip = pytest.mark.skip(reason="needs the robot: run pytest --hardware on its Raspberry Pi")
    for item in items:
        if item.get_closest_marker("hardware"):
            item.add_marker(skip)
