"""A report on a bright and a dark screen, on a phone, and printed, in a real browser."""

from __future__ import annotations

import base64
import io
import shutil
import subprocess
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from PIL import Image
from selenium import webdriver

from tests.charts.conftest import Open

PHONE_PX = 360
"""What fits there fits on wider ones."""
SMALLEST_PX = 12.0
READABLE_PT = 8.0
NEAR = 40
PAPER = {"light": (255, 255, 255), "dark": (20, 23, 28)}
CURVES = {"light": [(29, 111, 192), (196, 89, 11)], "dark": [(98, 174, 245), (245, 154, 76)]}
"""Curves 'a' and 'b' of the report (first and second in report.css)."""
SEEN_PX = 60
TEXTS = """
const small = [];
for (const one of document.querySelectorAll("body *")) {
  const own = [...one.childNodes].some((node) => node.nodeType === 3 && node.data.trim());
  if (!own || one.closest(".for-readers, script, style, noscript")) continue;
  if (parseFloat(getComputedStyle(one).fontSize) < arguments[0]) small.push(one.outerHTML);
}
return small;
"""
AXES = """
const found = [];
for (const root of Bokeh.documents[0].roots()) {
  const view = Bokeh.index.get_one(root);
  for (const axis of view.child_renderer_views ?? view.computed_renderer_views) {
    const { major_label_text: numbers, axis_label_text: name } = axis.visuals ?? {};
    if (numbers) found.push(numbers.get_text_font_size(), name.get_text_font_size());
  }
}
return found;
"""


def colour(browser: webdriver.Chrome, scheme: str) -> None:
    """Prefer bright or dark pages."""
    wanted = [{"name": "prefers-color-scheme", "value": scheme}]
    browser.execute_cdp_cmd("Emulation.setEmulatedMedia", {"features": wanted})


def picture(browser: webdriver.Chrome) -> Any:
    """The whole page, shape (height, width, 3)."""
    taken = browser.execute_cdp_cmd(
        "Page.captureScreenshot", {"format": "png", "captureBeyondViewport": True}
    )
    return pixels(base64.b64decode(taken["data"]))


def pixels(png: bytes) -> Any:
    """A picture as numbers."""
    return np.asarray(Image.open(io.BytesIO(png)).convert("RGB"), dtype=np.int64)


def count(shown: Any, wanted: tuple[int, int, int]) -> int:
    """How many of its pixels have this colour."""
    return int((np.abs(shown - np.array(wanted)).max(axis=2) <= NEAR).sum())


@pytest.mark.parametrize("scheme", ["light", "dark"])
def test_paper_and_curves_have_the_colours_of_the_screen(
    open_report: Open, report_file: Path, scheme: str
) -> None:
    browser = open_report(report_file)
    colour(browser, scheme)
    shown = picture(browser)
    other = "dark" if scheme == "light" else "light"
    assert count(shown, PAPER[scheme]) > shown.shape[0] * shown.shape[1] // 2
    assert count(shown, PAPER[other]) < shown.shape[0] * shown.shape[1] // 20
    for wanted in CURVES[scheme]:
        assert count(shown, wanted) > SEEN_PX


def test_on_a_phone_nothing_is_wider_than_the_screen_and_all_can_be_read(
    open_report: Open, report_file: Path
) -> None:
    browser = open_report(report_file)
    size = {"width": PHONE_PX, "height": 780, "deviceScaleFactor": 2, "mobile": True}
    browser.execute_cdp_cmd("Emulation.setDeviceMetricsOverride", size)
    browser = open_report(report_file)
    assert browser.execute_script("return document.documentElement.scrollWidth") <= PHONE_PX
    assert browser.execute_script(TEXTS, SMALLEST_PX) == []
    sizes = browser.execute_script(AXES)
    assert len(sizes) >= 12
    assert min(float(size.removesuffix("px")) for size in sizes) >= SMALLEST_PX
    plots = browser.execute_script(
        "return [...document.querySelectorAll('.plot')].map((one) => one.clientWidth)"
    )
    assert min(plots) > 0.85 * PHONE_PX


@pytest.mark.parametrize("scheme", ["light", "dark"])
def test_on_paper_curves_bars_legends_and_axes_are_there_and_large_enough(
    open_report: Open, report_file: Path, tmp_path: Path, scheme: str
) -> None:
    """As browsers print unless told otherwise: without backgrounds."""
    if shutil.which("pdftotext") is None:
        pytest.skip("needs Debian's package poppler-utils")
    browser = open_report(report_file)
    colour(browser, scheme)
    sheet = {"printBackground": False, "paperWidth": 8.27, "paperHeight": 11.69}
    printed = base64.b64decode(browser.execute_cdp_cmd("Page.printToPDF", sheet)["data"])
    file = tmp_path / "report.pdf"
    file.write_bytes(printed)
    words = subprocess.run(["pdftotext", "-bbox", str(file), "-"], capture_output=True, text=True)
    heights = [
        float(line.split('yMax="')[1].split('"')[0]) - float(line.split('yMin="')[1].split('"')[0])
        for line in words.stdout.splitlines()
        if "<word" in line and ">here<" in line
    ]
    assert len(heights) == 1
    assert heights[0] > READABLE_PT
    text = subprocess.run(["pdftotext", str(file), "-"], capture_output=True, text=True).stdout
    for wanted in ("First", "e [mm]", "t [s]", "x [mm]", "while", "−0.5", "good", "before",
                   "column 8"):  # fmt: skip
        assert wanted in text, f"{wanted} is not printed"
    assert "PNG" not in text
    run = ["pdftoppm", "-r", "144", "-png", str(file), str(tmp_path / "sheet")]
    subprocess.run(run, check=True)
    sheets = [pixels(one.read_bytes()) for one in sorted(tmp_path.glob("sheet*.png"))]
    for wanted in (*CURVES["light"], (22, 128, 90), (169, 214, 196)):  # curves, a bar, a state
        assert sum(count(one, wanted) for one in sheets) > SEEN_PX, f"{wanted} is not printed"
    assert all(count(one, PAPER["dark"]) < one.size // 30 for one in sheets)
    paper = "return document.documentElement.matches('[data-paper]')"
    assert browser.execute_script(paper) is False
