"""A report in a real browser: its charts are drawn, and what they show can be saved."""

from __future__ import annotations

import csv
import shutil
import time
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from selenium import webdriver
from selenium.webdriver.chrome.service import Service
from selenium.webdriver.common.by import By

from charts.figures import HeatStrip, LineChart
from charts.page import page
from charts.spec import Colour, Mark, Series, Span, Style

pytestmark = pytest.mark.realtime
PATIENCE_S = 60.0
COLOURED = """
const plots = [...document.querySelectorAll(".plot")];
return plots.map((plot) => [...plot.querySelectorAll("*")].filter((one) => one.shadowRoot).length
  && plot.getBoundingClientRect().height);
"""


def report() -> str:
    """A page with every kind of chart there is."""
    t = np.linspace(0.0, 10.0, 50)
    band = Series("b", t, np.cos(t), Colour.SECOND, low=np.cos(t) - 0.1, high=np.cos(t) + 0.1)
    first = LineChart(
        "First", "t [s]", "e [mm]", [Series("a", t, np.sin(t)), band], group="time",
        marks=[Mark(2.0, "here")], spans=[Span(1.0, 3.0, "while")],
    )  # fmt: skip
    plane = LineChart("Plane", "x [mm]", "y [mm]",
                      [Series("p", np.cos(t), np.sin(t), Colour.ASKED, Style.POINTS)],
                      equal_aspect=True)  # fmt: skip
    states = [("good", Colour.GOOD), ("bad", Colour.BAD)]
    strip = HeatStrip("Strip", "t [s]", t, ["x"], [np.arange(50) % 2], states, group="time")
    return page("Report", [one.html() for one in (first, plane, strip)])


def wait(condition: Any, what: str) -> None:
    """Until it holds."""
    give_up_s = time.monotonic() + PATIENCE_S
    while not condition():
        assert time.monotonic() < give_up_s, what
        time.sleep(0.05)


def test_charts_are_drawn_and_saved_as_picture_drawing_and_numbers(tmp_path: Path) -> None:
    binary, driver = shutil.which("chromium"), shutil.which("chromedriver")
    if binary is None or driver is None:
        pytest.skip("needs Debian's packages chromium and chromium-driver")
    file = tmp_path / "report.html"
    file.write_text(report(), encoding="utf-8")
    options = webdriver.ChromeOptions()
    options.binary_location = binary
    for word in ("--headless=new", "--no-sandbox", "--disable-dev-shm-usage", "--disable-gpu"):
        options.add_argument(word)
    options.set_capability("goog:loggingPrefs", {"browser": "ALL"})
    browser = webdriver.Chrome(options=options, service=Service(driver))
    try:
        browser.execute_cdp_cmd(
            "Browser.setDownloadBehavior", {"behavior": "allow", "downloadPath": str(tmp_path)}
        )
        browser.get(file.as_uri())
        drawn = "return document.documentElement.dataset.drawn"
        wait(lambda: browser.execute_script(drawn) == "true", "the charts are not drawn")
        heights = browser.execute_script(COLOURED)
        assert len(heights) == 3
        assert min(heights) > 90.0
        for kind in ("png", "svg", "csv"):
            browser.find_element(By.CSS_SELECTOR, f'[data-save="{kind}"]').click()
            saved = tmp_path / f"First.{kind}"
            wait(saved.is_file, f"no {kind} was saved")
        assert (tmp_path / "First.png").read_bytes().startswith(b"\x89PNG")
        svg = (tmp_path / "First.svg").read_text(encoding="utf-8")
        assert "<svg" in svg
        assert "e [mm]" in svg
        with (tmp_path / "First.csv").open(newline="", encoding="utf-8") as table:
            rows = list(csv.reader(table))
        assert rows[0] == ["t [s]", "a", "b", "b, low", "b, high"]
        assert [float(cell) for cell in rows[1]] == pytest.approx([0.0, 0.0, 1.0, 0.9, 1.1])
        name = browser.find_element(By.CSS_SELECTOR, '[data-series="0"]')
        name.click()
        assert name.get_attribute("aria-pressed") == "false"
        assert not [one for one in browser.get_log("browser") if one["level"] == "SEVERE"]
    finally:
        browser.quit()
