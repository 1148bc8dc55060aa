"""Where somebody who meets the page for the first time was lost: each step in a real browser."""

from __future__ import annotations

from pathlib import Path

import pytest
from selenium.webdriver.common.by import By

from tests.web.conftest import CIRCLE, PHONE, Browser, Open, WebPage, at_home


def platform_z_mm(browser: Browser) -> float:
    return float(browser.text("position").split()[2])


def press_three_times(browser: Browser, name: str) -> None:
    """Faster than any status comes."""
    browser.driver.execute_script("for (const _ of [1, 2, 3]) arguments[0].click()",
                                  browser.find(name))  # fmt: skip


def test_three_quick_presses_are_three_steps(browser: Browser, simulated: WebPage) -> None:
    at_home(simulated)
    browser.says("state", "ready")
    start = platform_z_mm(browser)
    press_three_times(browser, "jog-z-1")
    browser.wait(lambda: platform_z_mm(browser) < start - 2.9,
                 lambda: f"it moved {platform_z_mm(browser) - start:.2f} mm")  # fmt: skip
    browser.says("state", "ready")
    assert platform_z_mm(browser) == pytest.approx(start - 3.0, abs=0.1)


def test_a_file_of_ones_own_keeps_its_name(browser: Browser, tmp_path: Path) -> None:
    """In the list of files, and in what is said about it; the list leads back to it."""
    mine = tmp_path / "little circle.yaml"
    mine.write_text(CIRCLE.format(name="little", robot="zhao-2023.yaml", turns="two"))
    browser.tab("Jobs")
    browser.open_file(mine)
    browser.wait(lambda: browser.find("file").get_attribute("value") == mine.name
                 or mine.name in browser.find("file").find_element(By.XPATH, "..").text,
                 "the list still shows another file")  # fmt: skip
    browser.press("check")
    browser.says("verdict", "little circle.yaml:3: path.turns")


def test_a_report_that_the_browser_does_not_open_is_a_link(
    browser: Browser, simulated: WebPage
) -> None:
    """A browser opens no page by itself seconds after a press."""
    its = simulated.recordings / "web" / "made" / "driven"
    its.mkdir(parents=True)
    (its / "run.html").write_text("<title>A run</title>")
    recording = simulated.recordings / "driven.mcap"
    recording.write_bytes(b"")
    try:
        browser.tab("Recordings")
        row = '//*[@data-testid="recording"][.="driven"]/ancestor::*[contains(@class,"q-card")]'
        browser.wait(lambda: browser.driver.find_elements(By.XPATH, row), "it is not listed")
        browser.driver.execute_script("window.open = () => null")
        row_card = browser.driver.find_element(By.XPATH, row)
        row_card.find_element(By.CSS_SELECTOR, '[data-testid="report"]').click()
        browser.find("run-report").click()
        browser.wait(lambda: len(browser.driver.window_handles) == 2, "no report was opened")
        here, report = browser.driver.window_handles
        browser.driver.switch_to.window(report)
        browser.wait(lambda: browser.driver.title == "A run", lambda: browser.driver.title)
        browser.driver.close()
        browser.driver.switch_to.window(here)
    finally:
        recording.unlink()


def test_a_tab_begins_at_its_top_and_a_stop_stays_in_sight(
    simulated: WebPage, chromium: Open
) -> None:
    at_home(simulated)
    phone = chromium(simulated.url, PHONE)
    phone.says("state", "ready")
    press_three_times(phone, "jog-z-1")
    press_three_times(phone, "jog-z-1")
    toast = ".q-notification"
    phone.wait(lambda: phone.driver.find_elements(By.CSS_SELECTOR, toast), "nothing is told")
    bottom = "return arguments[0].getBoundingClientRect().bottom"
    top = "return arguments[0].getBoundingClientRect().top"
    stop_y = phone.driver.execute_script(top, phone.find("stop"))

    def clear_of_stop() -> bool:
        told = phone.driver.find_elements(By.CSS_SELECTOR, toast)
        return bool(told) and phone.driver.execute_script(bottom, told[-1]) <= stop_y

    phone.wait(clear_of_stop, "what is told lies over STOP", 4.0)
    script = "window.scrollTo(0, 9999); return scrollY"
    assert phone.driver.execute_script(script) > 300
    phone.press("stop")
    phone.says("latched", "stopped on the page")
    phone.driver.execute_script(script)
    button = phone.find("acknowledge")
    over = (
        "const b = arguments[0].getBoundingClientRect();"
        "const top = document.elementFromPoint(b.x + 9, b.y + b.height / 2);"
        "return arguments[0].contains(top)"
    )
    assert phone.driver.execute_script(over, button), "what to press lies out of sight"
    button.click()
    phone.says("state", "unhomed")
    phone.driver.execute_script("window.scrollTo(0, 99)")
    phone.tab("Jobs")
    phone.wait(lambda: phone.driver.execute_script("return scrollY") == 0,
               "the tab Jobs begins in its middle")  # fmt: skip
