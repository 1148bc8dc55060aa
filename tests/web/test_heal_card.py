"""The card that heals: nothing moves before a confirmation, and a stop leaves the old file."""

from __future__ import annotations

from deltactl.firmware_py.daemon.client import Client
from tests.web.conftest import Browser, WebPage, switch_off

SURVEYS_S = 120.0


def state(page: WebPage) -> str:
    assert page.socket is not None
    with Client(page.socket) as client:
        return client.status().state


def test_heal_asks_first_and_a_stop_leaves_the_old_file(
    simulated: WebPage, browser: Browser
) -> None:
    page = simulated
    robot_file = page.recordings.parent / "zhao-2023.yaml"
    old = robot_file.read_text(encoding="utf-8")
    switch_off(page)
    browser.tab("Robot")
    browser.says("state", "off")
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
