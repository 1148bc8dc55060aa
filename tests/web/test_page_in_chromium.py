"""What a user does on the page, in a real browser, with the simulated robot behind it."""

from __future__ import annotations

import json
import subprocess
import sys
import time
from bisect import bisect_right
from pathlib import Path
from typing import Any

import pytest
from selenium.webdriver.common.by import By
from selenium.webdriver.common.keys import Keys

from deltactl.firmware_py.daemon.client import Client
from tests.web.conftest import (
    CIRCLE,
    DESK,
    PASSWORD,
    PATIENCE_S,
    PHONE,
    Browser,
    Open,
    WebPage,
    at_home,
    end_page,
    patient_robot,
    start_page,
    switch_off,
)


@pytest.fixture(scope="module")
def browser(simulated: WebPage, chromium: Open) -> Browser:
    """With the robot in 3D, whose scripts may write errors to the browser's log too."""
    return chromium(simulated.url, drawn=True)


def test_a_heart_from_switching_on_to_the_stop(browser: Browser, simulated: WebPage) -> None:
    """On, home, run a job, stop it, acknowledge: as a new user would, following the page."""
    switch_off(simulated)
    browser.tab("Robot")
    browser.says("next", "switch the robot on")
    browser.press("power_on")
    browser.says("next", "press home")
    browser.press("home")
    browser.says("state", "ready")
    browser.tab("Jobs")
    browser.press("run")
    browser.says("job", "heart")
    browser.says("state", "running")
    before = browser.text("counts")
    browser.wait(lambda: browser.text("counts") != before, "the counts stand still")
    browser.press("stop")
    browser.says("state", "stopped")
    browser.says("latched", "stopped on the page")
    counts = browser.text("counts")
    time.sleep(0.5)
    assert browser.text("counts") == counts
    browser.press("acknowledge")
    browser.says("state", "unhomed")
    assert not [line for line in browser.driver.get_log("browser") if line["level"] == "SEVERE"]


def test_jog_moves_by_its_step(browser: Browser) -> None:
    browser.press("power_off")
    browser.press("power_on")
    browser.press("home")
    browser.says("state", "ready")
    start = platform_mm(browser)
    browser.press("jog-z-1")
    browser.wait(lambda: platform_mm(browser)[2] < start[2] - 0.9, "the platform did not move")
    browser.says("state", "ready")
    there = platform_mm(browser)
    assert there == pytest.approx([start[0], start[1], start[2] - 1.0], abs=0.1)


def test_keys_jog_while_the_cross_has_them(browser: Browser, simulated: WebPage) -> None:
    at_home(simulated)
    browser.says("state", "ready")
    body = browser.driver.find_element(By.TAG_NAME, "body")
    start = platform_mm(browser)
    body.send_keys(Keys.PAGE_UP)
    cross = browser.find("cross")
    browser.driver.execute_script("arguments[0].focus()", cross)
    cross.send_keys(Keys.PAGE_DOWN)
    browser.wait(lambda: platform_mm(browser)[2] < start[2] - 0.9, "the platform did not move")
    browser.says("state", "ready")
    assert platform_mm(browser)[2] == pytest.approx(start[2] - 1.0, abs=0.1)


def test_going_to_a_point_and_a_job_of_ones_own_with_a_pause(
    browser: Browser, simulated: WebPage, tmp_path: Path
) -> None:
    at_home(simulated)
    browser.says("state", "ready")
    for name, value in (("x", "5"), ("z", "-445")):
        field = browser.find(f"goto-{name}")
        field.send_keys(Keys.CONTROL, "a")
        field.send_keys(value, Keys.TAB)
    browser.press("goto")
    browser.wait(lambda: near(platform_mm(browser), [5.0, 0.0, -445.0]), "it did not go there")
    browser.says("state", "ready")
    mine = tmp_path / "mine.yaml"
    mine.write_text(CIRCLE.format(name="mine", robot="zhao-2023.yaml", turns=8))
    browser.tab("Jobs")
    browser.open_file(mine)
    browser.wait(lambda: "name: mine" in browser.text("text"), "the editor does not show it")
    browser.press("run")
    browser.says("job", "mine")
    browser.press("pause")
    browser.says("state", "paused")
    browser.wait(lambda: stands_still(browser), "it goes on in spite of the pause")
    stands = browser.text("counts")
    browser.press("resume")
    browser.says("state", "running")
    browser.wait(lambda: browser.text("counts") != stands, "it does not go on")
    browser.press("cancel")
    browser.says("state", "ready")


@pytest.mark.study
def test_what_follows_a_diagnosis_is_a_click_away(
    browser: Browser, simulated: WebPage, tmp_path: Path
) -> None:
    """The answer is laid beside a recording as the page's own worker leaves it there."""
    at_home(simulated)
    its = simulated.recordings / "web" / "made" / "asked"
    its.mkdir(parents=True, exist_ok=True)
    lines = ["Play.", "Do this", "- Mend it.", *(f"{n}  play" for n in range(20)), "", "More."]
    found = {"verdict": "explained", "lines": lines, "heads": lines[:2],
             "components": ["motor2"]}  # fmt: skip
    (its / "diagnosis.json").write_text(json.dumps(found))
    (its / "corrected.yaml").write_text("name: better\n")
    (its / "next.yaml").write_text(CIRCLE.format(name="telling", robot="robot.yaml", turns=8))
    (its / "robot.yaml").write_text(patient_robot(tmp_path).read_text())
    (simulated.recordings / "asked.mcap").write_bytes(b"not a recording")
    send = {"behavior": "allow", "downloadPath": str(tmp_path)}
    browser.driver.execute_cdp_cmd("Browser.setDownloadBehavior", send)
    browser.tab("Recordings")
    browser.wait(lambda: "asked" in listed(browser), "the recording is not listed")
    browser.says("answer", "explained")
    assert "- Mend it." in browser.driver.page_source
    last = '//*[@data-testid="screen"]//*[.="More."]'
    browser.wait(lambda: browser.driver.find_element(By.XPATH, last).is_displayed(),
                 "the last line of the answer is nowhere")  # fmt: skip
    (simulated.recordings / "later.mcap").write_bytes(b"nor this")
    browser.wait(lambda: "later" in listed(browser), "a new recording is not listed")
    assert listed(browser)[:2] == ["later", "asked"]
    (simulated.recordings / "later.mcap").unlink()
    browser.wait(lambda: "later" not in listed(browser), "a deleted recording is still listed")
    assert browser.text("answer") == "explained"
    press_text(browser, "Correct it")
    browser.wait(lambda: (tmp_path / "corrected.yaml").is_file(), "nothing was saved")
    press_text(browser, "The experiment that would tell more")
    browser.wait(lambda: "name: telling" in browser.text("text"), "the editor does not show it")
    assert "robot: zhao-2023.yaml" in browser.text("text")
    browser.tab("Recordings")
    press_text(browser, "Show it on the robot")
    browser.says("blamed", "red: motor2, named by the diagnosis of asked")
    browser.press("blame-clear")
    browser.wait(lambda: not browser.find("blamed").is_displayed(), "it stays red")
    browser.says("state", "ready")
    browser.tab("Recordings")
    browser.press("diagnose")
    browser.wait(lambda: "asked.mcap" in browser.driver.page_source, "no line about it")
    (simulated.recordings / "asked.mcap").unlink()


SHOWN = """
const { scene, renderer } = getElement(document.querySelector(".nicegui-scene")) ?? {};
const plots = getElement(document.querySelector(".plots"))?.chart?.getOption()?.series;
const row = (name) => plots.find((one) => one.id === name).data;
if (!scene || !plots || !row("cursor 0")[0]) return null;
return {
  slider: Number(document.querySelector('[data-testid="time"]').ariaValueNow),
  cursor: row("cursor 0")[0][0],
  pictures: renderer.info.render.frame,
  drawn_mm: scene.getObjectByName("platform").position.toArray().map((part) => 1e3 * part),
  t_s: row("x").map((pair) => pair[0]),
  xyz_mm: ["x", "y", "z"].map((name) => row(name).map((pair) => pair[1])),
};"""


@pytest.mark.study
def test_playback_moves_slider_cursor_and_platform_together(
    browser: Browser, simulated: WebPage
) -> None:
    at_home(simulated)
    assert simulated.socket is not None
    with Client(simulated.socket) as client:
        number = client.submit_text(
            CIRCLE.format(name="played", robot="zhao-2023.yaml", turns=2), "played.yaml"
        )
        browser.wait(lambda: client.result(number), "the circle does not end")
    browser.tab("Recordings")
    browser.wait(lambda: listed(browser)[:1] and listed(browser)[0].startswith("played"),
                 "the run is not listed")  # fmt: skip
    browser.press("play-it")
    browser.find("play", 3 * PATIENCE_S).click()
    browser.wait(lambda: shown(browser), "neither drawing nor cursor", 3 * PATIENCE_S)
    browser.wait(lambda: shown(browser)["slider"] > 0.5, "the slider does not move")
    browser.press("play")
    knob = browser.find("time").find_element(By.CSS_SELECTOR, "[tabindex]")
    for _ in range(2):
        browser.wait(lambda: together(browser), lambda: f"not in step: {where(shown(browser))}")
        knob.send_keys(Keys.ARROW_RIGHT * 40)
    browser.wait(lambda: draws_nothing(browser), "it is drawn again though nothing moves")
    browser.press("play-it")
    browser.wait(lambda: not browser.find("playback").is_displayed(), "it stays open")


def test_the_drawing_follows_the_window_although_it_was_out_of_sight(browser: Browser) -> None:
    browser.tab("Recordings")
    browser.find("own-recording")
    browser.driver.set_window_size(620, 700)
    time.sleep(0.5)
    browser.tab("Robot")
    width = "return document.querySelector('.scene-box canvas')?.clientWidth ?? 0"
    try:
        browser.wait(lambda: 450 < browser.driver.execute_script(width) <= 620,
                     lambda: f"it is {browser.driver.execute_script(width)} wide")  # fmt: skip
    finally:
        browser.driver.set_window_size(*DESK)


def shown(browser: Browser) -> Any:
    """What slider, plots and drawing of the page show now."""
    return browser.driver.execute_script(SHOWN)


def draws_nothing(browser: Browser) -> bool:
    """Whether no picture is drawn in half a second."""
    before = shown(browser)["pictures"]
    time.sleep(0.5)
    return bool(shown(browser)["pictures"] == before)


def where(shown: dict[str, Any]) -> tuple[float, float, list[float], list[float]]:
    """Time of slider and of cursor, the platform drawn and as its curves have it [mm]."""
    place = max(0, bisect_right(shown["t_s"], shown["slider"]) - 1)
    recorded = [row[place] for row in shown["xyz_mm"]]
    return shown["slider"], shown["cursor"], shown["drawn_mm"], recorded


def together(browser: Browser) -> bool:
    """Whether all three are at one time of the run."""
    slider_s, cursor_s, drawn, recorded = where(shown(browser))
    return slider_s == pytest.approx(cursor_s, abs=0.011) and near(drawn, recorded)


def listed(browser: Browser) -> list[str]:
    """The names in the list of recordings, from the top."""
    place = '[data-testid="recording"]'
    return [one.text for one in browser.driver.find_elements(By.CSS_SELECTOR, place)]


def press_text(browser: Browser, words: str) -> None:
    """Click the button that says this."""
    place = f'//button[contains(., "{words}")]'
    browser.wait(lambda: browser.driver.find_elements(By.XPATH, place), f"no button {words!r}")
    browser.driver.find_element(By.XPATH, place).click()


def stands_still(browser: Browser) -> bool:
    """Whether the counts are the same some updates later; a slow browser draws what came before."""
    counts = browser.text("counts")
    time.sleep(0.3)
    return browser.text("counts") == counts


def near(point: list[float], other: list[float]) -> bool:
    return all(abs(a - b) < 0.1 for a, b in zip(point, other, strict=True))


def platform_mm(browser: Browser) -> list[float]:
    return [float(part) for part in browser.text("position").split()[:3]]


def test_a_job_that_fails_its_check_is_one_line_and_is_not_run(
    browser: Browser, simulated: WebPage
) -> None:
    browser.tab("Jobs")
    editor = ".cm-content"
    browser.wait(lambda: browser.driver.find_elements(By.CSS_SELECTOR, editor), "no editor")
    browser.driver.execute_script(
        "document.querySelector('.cm-content').focus();"
        "document.execCommand('selectAll'); document.execCommand('insertText', false,"
        " 'name: far\\nrobot: ../zhao-2023.yaml\\npath: {shape: points, points_m: [[0,0,-9]]}\\n')"
    )
    before = len(list(simulated.recordings.glob("*.mcap")))
    browser.press("run")
    browser.says("verdict", "names files without folders")
    assert len(list(simulated.recordings.glob("*.mcap"))) == before
    browser.tab("Robot")
    browser.says("state", "ready")


def test_on_a_phone_stop_and_state_are_in_sight(simulated: WebPage, chromium: Open) -> None:
    phone = chromium(simulated.url, PHONE)
    phone.says("next", "")
    installable = phone.driver.execute_cdp_cmd("Page.getInstallabilityErrors", {})
    assert installable == {"installabilityErrors": []}
    stop = phone.find("stop")
    inner = phone.driver.execute_script("return [innerWidth, innerHeight, scrollX]")
    for tab in ("Jobs", "Recordings", "Robot"):
        phone.tab(tab)
        place = stop.rect
        height = phone.driver.execute_script(
            "return document.elementFromPoint(arguments[0], arguments[1]).closest('button')"
            "?.dataset.testid", place["x"] + place["width"] / 2,
            phone.driver.execute_script("return arguments[0].getBoundingClientRect().y", stop) + 20,
        )  # fmt: skip
        assert height == "stop", f"something covers the stop button on {tab}"
        phone.says("small-name", "zhao-2023")
        wide = phone.driver.execute_script("return document.documentElement.scrollWidth")
        assert wide <= inner[0] + 1, f"{tab} is wider than the phone"


def test_a_viewer_sees_all_and_can_stop_but_not_start(
    simulated: WebPage, signed_in: WebPage, chromium: Open
) -> None:
    """On a page of its own beside the other, for the same robot, with passwords."""
    at_home(simulated)
    viewer = chromium(signed_in.url)
    assert viewer.driver.current_url.endswith("/login")
    viewer.driver.find_element(By.NAME, "name").send_keys("hall")
    viewer.driver.find_element(By.NAME, "password").send_keys(f"{PASSWORD}\n")
    viewer.says("state", "ready")
    assert not viewer.driver.find_elements(By.CSS_SELECTOR, '[data-testid="home"]')
    viewer.press("stop")
    viewer.says("latched", "by hall", 5.0)


@pytest.mark.study
def test_two_browsers_and_a_daemon_that_comes_goes_and_comes_again(
    chromium: Open, tmp_path: Path
) -> None:
    place = tmp_path / "d.sock"
    page = start_page(tmp_path, "--socket", str(place))
    call = [sys.executable, "-P", "-m", "deltactl.cli.main", "service", "daemon",
            str(patient_robot(tmp_path)), "--simulate", "--socket", str(place),
            "--recordings", str(page.recordings)]  # fmt: skip
    try:
        one, other = chromium(page.url), chromium(page.url)
        one.says("state", "no daemon")
        one.says("next", "no daemon answers")
        for _ in range(2):
            daemon = subprocess.Popen(call, stderr=subprocess.DEVNULL)
            try:
                one.says("state", "off", 60.0)
                one.press("power_on")
                other.says("state", "unhomed")
                other.press("stop")
                one.says("latched", "stopped on the page")
            finally:
                daemon.terminate()
                daemon.wait(20.0)
            other.says("state", "no daemon")
    finally:
        end_page(page)
