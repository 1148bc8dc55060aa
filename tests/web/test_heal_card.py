"""The card that heals: nothing moves before a confirmation, and a stop leaves the old file."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from pathlib import Path

import pytest

from deltactl.firmware_py.daemon.client import Client
from tests.web.conftest import Browser, WebPage, end_page, patient_robot, start_page, switch_off

Open = Callable[..., Browser]
SURVEYS_S = 120.0


@pytest.fixture(scope="module")
def page(tmp_path_factory: pytest.TempPathFactory) -> Iterator[WebPage]:
    folder = tmp_path_factory.mktemp("heal-page")
    place = folder / "d.sock"
    words = ("--simulate", "--robot", str(patient_robot(folder)), "--socket", str(place))
    made = start_page(folder, *words)
    made.socket = place
    yield made
    end_page(made)


def state(page: WebPage) -> str:
    assert page.socket is not None
    with Client(page.socket) as client:
        return client.status().state


def test_heal_asks_first_and_a_stop_leaves_the_old_file(page: WebPage, chromium: Open) -> None:
    robot_file = page.recordings.parent / "zhao-2023.yaml"
    old = robot_file.read_text(encoding="utf-8")
    browser = chromium(page.url)
    browser.press("heal")
    browser.find("heal-now")
    assert state(page) == "off"
    browser.press("heal-now")
    moves = "the survey does not begin"
    browser.wait(lambda: "survey" in browser.text("heal-progress"), moves, SURVEYS_S)
    browser.wait(lambda: state(page) == "running", moves, SURVEYS_S)
    assert not browser.find("heal").is_enabled()
    browser.press("stop")
    browser.wait(lambda: "old robot file is in force" in browser.text("heal-problem"), "no word")
    assert state(page) == "stopped"
    assert robot_file.read_text(encoding="utf-8") == old
    switch_off(page)
    browser.wait(lambda: "go on" in browser.text("heal"), "cannot go on")
    browser.wait(lambda: browser.find("heal").is_enabled(), "cannot go on")
    assert not browser.find("heal-undo").is_displayed()


def test_an_example_of_the_package_is_not_healed(tmp_path: Path, chromium: Open) -> None:
    place = tmp_path / "d.sock"
    page = start_page(tmp_path, "--simulate", "--socket", str(place))
    try:
        browser = chromium(page.url)
        browser.press("heal")
        browser.press("heal-now")
        browser.wait(lambda: "example" in browser.text("heal-problem"), "is healed", SURVEYS_S)
    finally:
        end_page(page)
