"""The card that heals: nothing moves before a confirmation, and a stop leaves the old file."""

from __future__ import annotations

import json
from pathlib import Path

import pytest
import yaml

from deltactl.firmware_py.daemon.client import Client, daemon_answers
from deltactl.firmware_py.named_files import CONFIG_FOLDER
from deltactl.foundation.errors import ConfigError
from deltactl.repair.healing_state import Healing, digest_of, exchange
from deltactl.web.behind.healings import healing_folder
from deltactl.web.heal_card import UNDONE
from tests.rigs.faults.stand import wait_for
from tests.web.conftest import (
    Browser,
    Open,
    WebPage,
    at_home,
    end_page,
    patient_robot,
    start_page,
    switch_off,
)

SURVEYS_S, ENDS_S = 120.0, 30.0


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


def test_the_simulated_robot_ends_with_a_page_that_is_killed(tmp_path: Path) -> None:
    place = tmp_path / "d.sock"
    page = start_page(tmp_path, "--simulate", "--socket", str(place))
    assert daemon_answers(place)
    page.process.kill()
    page.process.wait()
    assert wait_for(lambda: not place.exists(), ENDS_S) is not None, "the daemon runs on"


def test_undo_puts_the_old_file_back_and_says_so(chromium: Open, tmp_path: Path) -> None:
    mine, place = patient_robot(tmp_path), tmp_path / "d.sock"
    old = mine.read_text(encoding="utf-8")
    page = start_page(tmp_path, "--simulate", "--robot", str(mine), "--socket", str(place))
    page.socket = place
    try:
        at_home(page)
        with Client(place) as client:
            status = client.status()
        folder = healing_folder(page.recordings / "web", status)
        folder.mkdir(parents=True)
        begun = Healing(robot_file=mine, job=mine, old_sha256=digest_of(mine))
        exchange(folder, begun, old.replace("forearm_m: 0.5 ", "forearm_m: 0.501 "))
        shown = {"outcome": "healed", "lines": ["Healed: it is only said."]}
        (folder / "shown.json").write_text(json.dumps(shown), encoding="utf-8")
        browser = chromium(page.url)
        browser.tab("Robot")
        browser.says("heal-answer", "it is only said")
        browser.press("heal-undo")
        browser.wait(lambda: UNDONE in browser.driver.page_source, "does not say that it is undone")
        browser.wait(lambda: not browser.find("heal-undo").is_displayed(), "still to be undone")
        assert mine.read_text(encoding="utf-8") == old
        assert browser.text("heal-answer") == ""
        browser.says("state", "ready")
    finally:
        end_page(page)


HEALS_S = 1800.0
"""A survey, a drawing before and after at least, and a diagnosis beside other programs."""
OFF_RAD = 0.012
STEPS = ("homing", "survey", "diagnosis", "as it was", "corrected", "keeping")
"""What the page says of each step, in its order."""


@pytest.mark.study
@pytest.mark.timeout(2 * HEALS_S)
def test_a_robot_is_healed_by_the_button_and_undone_by_another(
    chromium: Open, tmp_path: Path
) -> None:
    mine, place = patient_robot(tmp_path), tmp_path / "d.sock"
    off = {"effect": "home_offset", "component": "motor2", "parameters": {"angle": OFF_RAD}}
    built = yaml.safe_dump({"as_built": {"effects": [off]}})
    old = mine.read_text(encoding="utf-8") + "\n" + built
    mine.write_text(old, encoding="utf-8")
    page = start_page(tmp_path, "--simulate", "--robot", str(mine), "--socket", str(place))
    page.socket = place
    try:
        browser = chromium(page.url)
        browser.tab("Robot")
        browser.press("heal")
        browser.press("heal-now")
        told: list[str] = []

        def ended() -> bool:
            if (says := browser.text("heal-progress").partition(" ")[2]) not in ("", *told[-1:]):
                told.append(says)
                if "survey" in says:  # whoever comes to look sees it too
                    browser.driver.refresh()
                    browser.tab("Robot")
            return bool(browser.text("heal-answer") or browser.text("heal-problem"))

        browser.wait(ended, lambda: f"no end after {told}", HEALS_S)
        assert browser.text("heal-answer").startswith("healed:"), browser.text("heal-problem")
        seen = [next((n for n, text in enumerate(told) if step in text), -1) for step in STEPS]
        assert seen == sorted(seen), told
        assert min(seen) >= 0, told
        (found,) = yaml.safe_load(mine.read_text(encoding="utf-8"))["effects"]
        assert (found["effect"], found["component"]) == ("home_offset", "motor2")
        assert found["parameters"]["angle"] == pytest.approx(OFF_RAD, abs=2e-4)
        assert "press undo" in browser.text("heal-answer")
        browser.press("heal-report")
        browser.wait(lambda: len(browser.driver.window_handles) == 2, "no report")
        browser.driver.switch_to.window(browser.driver.window_handles[1])
        browser.wait(lambda: "motor2" in browser.driver.page_source, "an empty report")
        browser.driver.close()
        browser.driver.switch_to.window(browser.driver.window_handles[0])
        browser.press("heal-undo")
        browser.wait(lambda: not browser.find("heal-undo").is_displayed(), "still to be undone")
        assert mine.read_text(encoding="utf-8") == old
        browser.says("state", "ready")
        assert browser.text("heal-answer") == ""
    finally:
        end_page(page)
