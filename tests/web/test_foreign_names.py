"""Names that others chose, on the page in a real browser: shown as they are, and never run."""

from __future__ import annotations

from collections.abc import Iterator

import pytest
from selenium.webdriver.common.by import By

from deltactl.firmware_py.daemon.client import Client
from tests.web.conftest import (
    CIRCLE,
    Browser,
    Open,
    WebPage,
    at_home,
    end_page,
    patient_robot,
    start_page,
)

pytestmark = pytest.mark.study
FOREIGN = """r" :title="__t=1" '<img src=q onerror=__t=2>:{{9*9}}"""
"""Ends an attribute and begins one that NiceGUI would run, an element, and a template of Vue."""
WORDS = ("robot", "job", "next", "heading", "unit", "why")
ROBOT, JOB, NEXT, HEADING, UNIT, WHY = (f"{word} {FOREIGN}" for word in WORDS)
RECORDING = f"a{FOREIGN}"
TABLE = f"t{FOREIGN}.csv"
NO_3D = "THREE.WebGLRenderer: "


@pytest.fixture(scope="module")
def hostile(tmp_path_factory: pytest.TempPathFactory) -> Iterator[WebPage]:
    """A page on which everything that has a name has this one."""
    folder = tmp_path_factory.mktemp("hostile")
    robot = folder / f"{ROBOT}.yaml"
    text = patient_robot(folder).read_text(encoding="utf-8")
    # Nothing in the name needs quotes in YAML.
    robot.write_text(text.replace("name: zhao-2023\n", f"name: {ROBOT}\n"))
    job = CIRCLE.format(name=JOB, robot=robot.name, turns=20)
    (folder / f"{JOB}.yaml").write_text(job)
    (folder / "recordings").mkdir()
    (folder / "recordings" / f"{RECORDING}.mcap").write_bytes(b"\x89MCAP0\r\n")
    (folder / TABLE).write_text(
        f't [s],"{HEADING.replace(chr(34), chr(34) * 2)} [{UNIT.replace(chr(34), chr(34) * 2)}]"\n'
        + "".join(f"{k * 0.01},{k % 9}\n" for k in range(300))
    )
    place = folder / "d.sock"
    page = start_page(folder, "--simulate", "--robot", str(robot), "--socket", str(place))
    page.socket = place
    yield page
    end_page(page)


@pytest.fixture(scope="module")
def browser(hostile: WebPage, chromium: Open) -> Browser:
    return chromium(hostile.url)


def shown(browser: Browser) -> str:
    """All texts of the page, also those that are cut short or stand in fields."""
    text: str = browser.driver.execute_script(
        "return [document.documentElement.textContent, ...[...document.querySelectorAll('input')]"
        ".map(one => one.value)].join(' ')"
    )
    return text


def is_literal(browser: Browser, *texts: str) -> None:
    """Wait until each text is there as it is, and see that none of it ran."""
    for text in texts:
        browser.wait(lambda text=text: text in shown(browser), f"{text} is not shown")
    for event in ("mouseenter", "mouseover", "focus"):  # what a hand on the page would start
        browser.driver.execute_script(
            "document.querySelectorAll('[data-testid], [aria-label], [title]').forEach("
            f"one => one.dispatchEvent(new MouseEvent('{event}')))"
        )
    ran = browser.driver.execute_script("return [typeof window.__t, String(window.__t)]")
    assert ran == ["undefined", "undefined"]
    assert not browser.driver.find_elements(By.CSS_SELECTOR, 'img[src="q"]')
    assert "{{9*9}}" in texts[0]


def test_robot_and_files(browser: Browser, hostile: WebPage) -> None:
    browser.says("robot_file", "robot")
    is_literal(browser, f"{ROBOT} (simulated)", f"{ROBOT}.yaml")
    browser.tab("Jobs")
    browser.find("file").click()
    is_literal(browser, f"{JOB}.yaml", f"{ROBOT}.yaml")
    browser.driver.find_element(By.TAG_NAME, "body").click()


def test_jobs_that_run_and_wait_and_why_it_stopped(browser: Browser, hostile: WebPage) -> None:
    browser.tab("Robot")
    at_home(hostile)
    folder = hostile.recordings.parent
    text = (folder / f"{JOB}.yaml").read_text()
    assert hostile.socket is not None
    with Client(hostile.socket) as client:
        client.submit_text(text, f"{JOB}.yaml")
        client.submit_text(text.replace(f"name: {JOB}", f"name: {NEXT}"), f"{NEXT}.yaml")
        is_literal(browser, JOB, f"1. then {NEXT}")
        client.stop(WHY)
    is_literal(browser, f"STOPPED: {WHY}")


def test_recordings_headings_and_units(browser: Browser, hostile: WebPage) -> None:
    browser.tab("Recordings")
    is_literal(browser, RECORDING)
    browser.open_own(hostile.recordings.parent / TABLE)
    browser.says("own-says", "is in the list")
    is_literal(browser, f"{TABLE} is in the list")
    browser.wait(lambda: TABLE in [one.text for one in browser.all("recording")], "not listed")
    browser.press("columns")
    is_literal(browser, HEADING)
    browser.press("diagnose")
    browser.wait(lambda: browser.all("failed"), "no answer", within_s=60.0)
    is_literal(browser, TABLE)


def test_no_error_in_the_browser(browser: Browser) -> None:
    """No violation of the page's policy either, which the browser writes to its log."""
    said = browser.driver.get_log("browser")
    severe = [line["message"] for line in said if line["level"] == "SEVERE"]
    # The library says that this browser cannot draw.
    assert [one for one in severe if NO_3D not in one] == []
