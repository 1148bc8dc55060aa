"""The tabs of the page where the browser asks for dark colours, and on paper."""

from __future__ import annotations

import base64
from typing import Any

import pytest
from selenium.webdriver.common.by import By

from tests.web.conftest import Browser, Open, WebPage, switch_off

TABS = ("Robot", "Jobs", "Recordings")
READABLE = 3.0
"""Contrast that WCAG 2.1 (1.4.11) asks of what is to be seen at all."""
FAINT = """
const colour = (text) => text.match(/[\\d.]+/g).map(Number);
const light = (rgb) => { const [r, g, b] = rgb.slice(0, 3).map((v) => v / 255)
  .map((v) => v <= 0.04045 ? v / 12.92 : ((v + 0.055) / 1.055) ** 2.4);
  return 0.2126 * r + 0.7152 * g + 0.0722 * b; };
const behind = (part) => { for (let one = part; one; one = one.parentElement) {
  const [r, g, b, a = 1] = colour(getComputedStyle(one).backgroundColor);
  if (a > 0.5) return [r, g, b]; } return [255, 255, 255]; };
const faint = [];
for (const part of document.querySelectorAll("body *")) {
  const own = [...part.childNodes].some((one) => one.nodeType === 3 && one.data.trim());
  const left = !own || !part.checkVisibility() || part.closest(".editor, .disabled, script, style");
  if (left) continue;
  const pair = [light(colour(getComputedStyle(part).color)), light(behind(part))];
  const contrast = (Math.max(...pair) + 0.05) / (Math.min(...pair) + 0.05);
  if (contrast < arguments[0]) faint.push(part.textContent.trim() + " " + contrast.toFixed(1));
}
return faint;
"""
"""Texts that hardly differ from what lies behind them, other than of what cannot be pressed."""

PRESSED = """return [...document.querySelectorAll("button")]
  .filter((one) => one.checkVisibility()).map((one) => one.innerText)"""
"""Buttons that are seen."""


@pytest.fixture(scope="module")
def browser(simulated: WebPage, chromium: Open) -> Browser:
    opened = chromium(simulated.url)
    switch_off(simulated)
    opened.says("state", "off")
    return opened


def asks_for(browser: Browser, **media: Any) -> None:
    """Be a browser that asks for dark colours, or a printer."""
    browser.driver.execute_cdp_cmd("Emulation.setEmulatedMedia", media)


def faint(browser: Browser) -> list[str]:
    return list(browser.driver.execute_script(FAINT, READABLE))


@pytest.mark.parametrize("scheme", ["dark", "light"])
def test_every_text_can_be_read(browser: Browser, simulated: WebPage, scheme: str) -> None:
    switch_off(simulated)
    asks_for(browser, features=[{"name": "prefers-color-scheme", "value": scheme}])
    is_dark = "return document.body.classList.contains('body--dark')"
    try:
        browser.wait(lambda: browser.driver.execute_script(is_dark) == (scheme == "dark"),
                     f"the page is not {scheme}")  # fmt: skip
        for state in ("off", "unhomed"):
            browser.tab("Robot")
            if state == "unhomed":
                browser.press("power_on")
            browser.says("state", state)
            for tab in TABS:
                browser.tab(tab)
                browser.wait(lambda: not faint(browser), lambda: str(faint(browser)))
    finally:
        asks_for(browser, features=[])


def told_of_runs(browser: Browser) -> bool:
    """Whether the page tells of what ran before on this robot, which may take another sheet."""
    told = browser.driver.find_elements(
        By.CSS_SELECTOR,
        '.news, [data-testid="trial"], [data-testid="ended"], .history > :nth-child(6)',
    )
    return any(one.is_displayed() for one in told)


def sheets(browser: Browser) -> int:
    """How many the tab takes."""
    pdf = base64.b64decode(browser.driver.execute_cdp_cmd("Page.printToPDF", {})["data"])
    return pdf.count(b"/Type /Page\n")


@pytest.mark.parametrize("tab", TABS)
def test_paper_shows_what_is_and_nothing_to_press(browser: Browser, tab: str) -> None:
    browser.tab("Robot")
    if browser.find("power_on").is_enabled():
        browser.press("power_on")
    browser.says("state", "unhomed")
    browser.tab(tab)
    if tab != "Recordings":  # of which there may be many
        assert sheets(browser) <= 1 + told_of_runs(browser)
    asks_for(browser, media="print")
    try:
        assert browser.driver.execute_script(PRESSED) == []
        assert browser.find("state").is_displayed()
    finally:
        asks_for(browser, media="")
