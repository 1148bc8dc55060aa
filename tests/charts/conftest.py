"""A report with every kind of chart there is, and Debian's Chromium to look at it."""

from __future__ import annotations

import shutil
import time
from collections.abc import Callable, Iterator
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from selenium import webdriver
from selenium.webdriver.chrome.service import Service

from deltactl.charts.figures import HeatStrip, LineChart
from deltactl.charts.page import page, table
from deltactl.charts.spec import Colour, Mark, Series, Span, Style

PATIENCE_S = 60.0
Open = Callable[[Path], webdriver.Chrome]


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
    cells = [[f"column {number}" for number in range(9)]]
    wide = table(cells[0], cells * 2)
    return page("Report", [*(one.html() for one in (first, plane, strip)), wide])


def wait(condition: Any, what: str) -> None:
    """Until it holds."""
    give_up_s = time.monotonic() + PATIENCE_S
    while not condition():
        assert time.monotonic() < give_up_s, what
        time.sleep(0.05)


@pytest.fixture
def report_file(tmp_path: Path) -> Path:
    """The report as a file."""
    file = tmp_path / "report.html"
    file.write_text(report(), encoding="utf-8")
    return file


@pytest.fixture(scope="module")
def chromium() -> Iterator[webdriver.Chrome]:
    """One browser for a file of tests; skips where there is no Chromium."""
    binary, driver = shutil.which("chromium"), shutil.which("chromedriver")
    if binary is None or driver is None:
        pytest.skip("needs Debian's packages chromium and chromium-driver")
    options = webdriver.ChromeOptions()
    options.binary_location = binary
    for word in ("--headless=new", "--no-sandbox", "--disable-dev-shm-usage", "--disable-gpu",
                 "--hide-scrollbars"):  # fmt: skip
        options.add_argument(word)
    options.set_capability("goog:loggingPrefs", {"browser": "ALL", "performance": "ALL"})
    browser = webdriver.Chrome(options=options, service=Service(driver))
    yield browser
    browser.quit()


@pytest.fixture
def open_report(chromium: webdriver.Chrome) -> Iterator[Open]:
    """Opens a report and waits until it is drawn; the browser is as it was started."""

    def drawn(file: Path) -> webdriver.Chrome:
        chromium.get(file.as_uri())
        done = "return document.documentElement.dataset.drawn"
        wait(lambda: chromium.execute_script(done) == "true", "the charts are not drawn")
        return chromium

    for kind in ("browser", "performance"):
        chromium.get_log(kind)  # of tests before
    yield drawn
    chromium.get("about:blank")
    chromium.execute_cdp_cmd("Emulation.setEmulatedMedia", {"features": []})
    chromium.execute_cdp_cmd("Emulation.clearDeviceMetricsOverride", {})
