"""Several jobs at once, and buttons that cannot be pressed now, in a real browser."""

from __future__ import annotations

import re
from pathlib import Path

from selenium.webdriver.common.by import By

from deltactl.firmware_py.daemon.client import Client
from tests.web.conftest import CIRCLE, PHONE, Browser, Open, WebPage, at_home, switch_off


def run(browser: Browser, folder: Path, name: str, turns: int) -> None:
    """Open a job of one's own and run it."""
    path = folder / f"{name}.yaml"
    path.write_text(CIRCLE.format(name=name, robot="zhao-2023.yaml", turns=turns))
    browser.tab("Jobs")
    browser.open_file(path)
    browser.wait(lambda: f"name: {name}" in browser.text("text"), "the editor does not show it")
    browser.press("run")
    browser.wait(lambda: browser.find("job").is_displayed(), "Run does not turn to the tab Robot")


def waiting(browser: Browser) -> list[str]:
    """The jobs that wait, as listed."""
    place = '[data-testid="waiting"]'
    return [one.text for one in browser.driver.find_elements(By.CSS_SELECTOR, place)]


def seconds_left(browser: Browser) -> float:
    """As the page says."""
    browser.says("left", "s left")
    return float(browser.text("left").split(",")[1].split()[0])


def test_jobs_wait_in_order_and_one_can_be_left_out(
    browser: Browser, simulated: WebPage, tmp_path: Path
) -> None:
    assert simulated.socket is not None
    at_home(simulated)
    run(browser, tmp_path, "first", 20)
    browser.says("job", "first")
    run(browser, tmp_path, "second", 8)
    browser.wait(lambda: waiting(browser) == ["1. then second"], "the second does not wait")
    run(browser, tmp_path, "third", 8)
    both = ["1. then second", "2. then third"]
    browser.wait(lambda: waiting(browser) == both, lambda: f"{waiting(browser)} wait")
    left_s = seconds_left(browser)
    assert left_s > 3.0
    browser.wait(lambda: seconds_left(browser) < left_s - 1.0, "the time left stands still")
    with Client(simulated.socket) as client:
        out, _ = client.status().queued_ids
    browser.press("leave-out-1")
    browser.wait(lambda: waiting(browser) == ["1. then third"], lambda: f"{waiting(browser)} wait")
    with Client(simulated.socket) as client:
        result = client.result(out)
        assert client.status().job == "first"
    assert result is not None
    assert result.outcome == "cancelled"
    with Client(simulated.socket) as client:
        client.cancel(client.status().job_id)
    browser.says("job", "third")
    assert waiting(browser) == []
    assert "moving by hand: not now, the robot is running" in browser.text("unable")
    assert not browser.find("jog-x+1").is_enabled()
    browser.tab("Recordings")
    browser.wait(lambda: "still being recorded" in
                 (browser.find("report").get_attribute("title") or ""),
                 "a run is not said to be recorded still")  # fmt: skip
    assert not browser.find("diagnose").is_enabled()
    browser.tab("Robot")
    browser.press("cancel")
    browser.says("state", "ready")
    browser.says("job", "no job")
    browser.says("ended", "third was cancelled: its recording is third-")
    browser.press("show-recording")
    browser.says("recording", "third-")
    browser.wait(lambda: browser.find("diagnose").is_enabled(), "it cannot be diagnosed")


def test_what_cannot_be_pressed_looks_so_and_says_why(browser: Browser, simulated: WebPage) -> None:
    switch_off(simulated)
    browser.tab("Robot")
    browser.says("state", "off")
    browser.wait(lambda: not browser.find("pause").is_enabled(), "pause can be pressed")
    looks = [browser.find(name).value_of_css_property("background-color")
             for name in ("pause", "power_on")]  # fmt: skip
    grey, blue = ([int(part) for part in re.findall(r"\d+", look)[:3]] for look in looks)
    assert max(grey) - min(grey) < 10
    assert max(blue) - min(blue) > 100
    block = browser.find("pause").find_element(By.CSS_SELECTOR, ".block")
    assert block.value_of_css_property("text-decoration-line") == "none"
    why = browser.find("pause").get_attribute("title")
    assert why == "Pause: not now, the robot is off; possible when it is planning a job or running"
    assert "the robot is off" in browser.text("unable")
    nodes = browser.driver.execute_cdp_cmd("Accessibility.getFullAXTree", {})["nodes"]
    told = {one["name"]["value"]: one.get("description", {}).get("value", "")
            for one in nodes if one["role"]["value"] == "button" and "name" in one}  # fmt: skip
    assert any(why in (name, text) for name, text in told.items())
    browser.tab("Jobs")
    browser.press("run")
    browser.says("verdict", "on the tab robot: switch the robot on")
    browser.tab("Robot")
    browser.press("power_on")
    browser.says("state", "unhomed")
    browser.wait(lambda: browser.find("home").is_enabled(), "home cannot be pressed")
    assert not browser.find("home").get_attribute("title")


def test_run_is_larger_than_what_opens_a_file(
    browser: Browser, simulated: WebPage, chromium: Open
) -> None:
    for one in (browser, chromium(simulated.url, PHONE)):
        one.says("next", "")
        one.tab("Jobs")
        sizes = [one.find(name).size for name in ("run", "upload", "check")]
        areas = [size["width"] * size["height"] for size in sizes]
        assert areas[0] == max(areas)
