"""The card that heals: nothing moves before a confirmation, and a stop leaves the old file."""

from __future__ import annotations

from pathlib import Path

import pytest

from deltactl.firmware_py.daemon.client import Client
from deltactl.firmware_py.named_files import CONFIG_FOLDER
from deltactl.foundation.errors import ConfigError
from tests.web.conftest import (
    Browser,
    Open,
    WebPage,
    end_page,
    patient_robot,
    start_page,
    switch_off,
)

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


@pytest.mark.study
def test_an_edited_copy_with_another_name_is_healed_by_a_heart_of_its_own(
    chromium: Open, tmp_path: Path
) -> None:
    """The daemon draws the heart of the healing, and refuses the example's: another machine."""
    mine, place = tmp_path / "mine.yaml", tmp_path / "d.sock"
    text = patient_robot(tmp_path).read_text(encoding="utf-8")
    text = text.replace("name: zhao-2023", "name: mine")
    mine.write_text(text.replace("forearm_m: 0.5 ", "forearm_m: 0.49 "), encoding="utf-8")
    page = start_page(tmp_path, "--simulate", "--robot", str(mine), "--socket", str(place))
    page.socket = place
    try:
        browser = chromium(page.url)
        browser.tab("Robot")
        browser.press("heal")
        browser.press("heal-now")
        moves = "the survey does not begin"
        browser.wait(lambda: "survey" in browser.text("heal-progress"), moves, SURVEYS_S)
        browser.wait(lambda: state(page) == "running", moves, SURVEYS_S)
        browser.press("stop")
        browser.wait(
            lambda: "old robot file is in force" in browser.text("heal-problem"), "no word"
        )
        switch_off(page)
        with Client(place) as client:
            client.power_on()
            client.home()
            with pytest.raises(ConfigError, match="is for robot file"):
                client.submit(CONFIG_FOLDER / "demo-heart.yaml")
            (heart,) = page.recordings.parent.rglob("heal/*/demo-heart.yaml")
            number = client.submit(heart)
            client.stop("seen")
            assert client.result(number) is None or client.result(number).name == "demo-heart"
    finally:
        end_page(page)
