"""A report in a real browser: its charts are drawn, and what they show can be saved."""

from __future__ import annotations

import csv
import json
from pathlib import Path
from typing import Any

import pytest
from selenium import webdriver
from selenium.webdriver.common.by import By

from tests.charts.conftest import Open, wait

COLOURED = """
const plots = [...document.querySelectorAll(".plot")];
return plots.map((plot) => [...plot.querySelectorAll("*")].filter((one) => one.shadowRoot).length
  && plot.getBoundingClientRect().height);
"""


def test_charts_are_drawn_and_saved_as_picture_drawing_and_numbers(
    open_report: Open, report_file: Path, tmp_path: Path
) -> None:
    browser = open_report(report_file)
    browser.execute_cdp_cmd(
        "Browser.setDownloadBehavior", {"behavior": "allow", "downloadPath": str(tmp_path)}
    )
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
    assert asked_for(browser) == {report_file.as_uri()}


def asked_for(browser: webdriver.Chrome) -> set[str]:
    """Every address that the page has asked for, but what it made itself."""
    said: list[dict[str, Any]] = [
        json.loads(one["message"])["message"] for one in browser.get_log("performance")
    ]
    sent = [one["params"]["request"]["url"] for one in said
            if one["method"] == "Network.requestWillBeSent"]  # fmt: skip
    return {url for url in sent if not url.startswith(("blob:", "data:"))}


@pytest.mark.study
def test_a_screen_reader_is_told_what_is_shown(open_report: Open, report_file: Path) -> None:
    browser = open_report(report_file)
    nodes = browser.execute_cdp_cmd("Accessibility.getFullAXTree", {})["nodes"]
    heard = {(one["role"]["value"], one["name"]["value"]) for one in nodes
             if not one["ignored"] and one.get("name", {}).get("value")}  # fmt: skip
    assert ("figure", "First") in heard
    assert ("button", "save First as numbers, CSV") in heard
    assert ("button", "a") in heard
    texts = [name for role, name in heard if role == "StaticText"]
    assert any(text.startswith("e [mm] over t [s]. a: 50 points from") for text in texts)
