"""The page about a fleet: short, with what comes first at its top."""

from __future__ import annotations

import re
from typing import Any

import numpy as np
import pytest

from deltactl.fleet.page import fleet_html
from deltactl.fleet.task import Row
from tests.charts.conftest import Open
from tests.fleet.test_trends_and_groups import rows_of

ROBOTS, RECORDINGS = 40, 50
MOST_ROWS = 36
LONGEST_PHONE_PX = 4_000
PHONE = {"width": 360, "height": 780, "deviceScaleFactor": 2, "mobile": True}


@pytest.fixture(scope="module")
def fleet() -> list[Row]:
    """Forty robots: twelve whose play grows, a batch of eight, and files that are cut off."""
    rng = np.random.default_rng(3)
    rows: list[dict[str, Any]] = []
    for robot in range(ROBOTS):
        name = f"delta-{robot:02d}"
        grows = np.linspace(0.0, 0.002 * (robot + 1), RECORDINGS) if robot < 12 else 0.0
        size = 1.004 if 12 <= robot < 20 else 1.0 + 0.01 * robot
        noise = 1e-5 * rng.standard_normal(RECORDINGS)
        its = rows_of(name, size + grows + noise, 1e-5, "gear_backlash")
        for row in its:
            row["recording"] = f"recordings/{name}/{row['recording']}.mcap"
            for one in row["findings"]:
                one["probability"] = 0.98
        its[3] = {"recording": its[3]["recording"], "robot": name, "error": "the file is cut off"}
        rows += its
    return rows


@pytest.mark.study
def test_what_comes_first_is_at_the_top_and_the_rest_opens_on_a_click(fleet: list[Row]) -> None:
    text = fleet_html(fleet, {"gear_backlash.scale": 1.13})
    at_once = re.sub(r"<details>.*?</details>", "", text, flags=re.DOTALL)
    assert at_once.count("<tr>") <= MOST_ROWS < text.count("<tr>")
    first = at_once.split("Where to look first")[1].split("<tr>")
    assert "past its limit" in first[2]
    assert "delta-39" in text


@pytest.mark.study
def test_on_a_phone_the_page_is_a_few_screens_long(
    fleet: list[Row], open_report: Open, tmp_path: Any
) -> None:
    file = tmp_path / "fleet.html"
    file.write_text(fleet_html(fleet, {"gear_backlash.scale": 1.13}), encoding="utf-8")
    browser = open_report(file)
    browser.execute_cdp_cmd("Emulation.setDeviceMetricsOverride", PHONE)
    wide, long = browser.execute_script(
        "const page = document.documentElement; return [page.scrollWidth, page.scrollHeight]"
    )
    assert wide <= PHONE["width"]
    assert long <= LONGEST_PHONE_PX
