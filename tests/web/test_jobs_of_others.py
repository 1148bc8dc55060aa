"""Where a newcomer stood: the job of another robot, a figure without a meaning, keys on a phone."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path

import pytest
from selenium.webdriver.common.by import By

from tests.web.conftest import Browser, WebPage, at_home

Open = Callable[..., Browser]
JOB = """name: theirs
robot: {robot}
path: {{shape: circle, centre_m: [0, 0, -0.45], radius_m: 0.05}}
timing: {{mode: accelerated, speed_mps: 0.1}}
inverse_kinematics: {{kind: geometry}}
"""


@pytest.fixture(scope="module")
def browser(simulated: WebPage, chromium: Open) -> Browser:
    return chromium(simulated.url)


def check(browser: Browser, folder: Path, robot: str) -> None:
    """Open a job for this robot file, and press Check."""
    path = folder / "theirs.yaml"
    path.write_text(JOB.format(robot=robot))
    browser.tab("Jobs")
    place = "input[type=file]"
    browser.wait(lambda: browser.driver.find_elements(By.CSS_SELECTOR, place), "no upload")
    browser.driver.find_element(By.CSS_SELECTOR, place).send_keys(str(path))
    browser.wait(lambda: robot in browser.text("text"), "the editor does not show it")
    browser.press("check")


@pytest.mark.parametrize(
    ("robot", "there"), [("my-delta.yaml", ", a file that is not here"), ("gripper-delta.yaml", "")]
)
def test_a_job_for_another_robot_says_which_and_what_to_do(
    browser: Browser, simulated: WebPage, tmp_path: Path, robot: str, there: str
) -> None:
    at_home(simulated)
    check(browser, tmp_path, robot)
    browser.says("verdict", f"theirs.yaml is a job for another robot: {robot}{there}. ")
    browser.says("verdict", "this one is zhao-2023.yaml")
    browser.says("verdict", "write 'robot: zhao-2023.yaml' in the job")
    browser.says("verdict", f"start deltactl web --simulate --robot {robot}")


def test_a_job_for_this_robot_says_what_its_margin_means(
    browser: Browser, simulated: WebPage, tmp_path: Path
) -> None:
    at_home(simulated)
    check(browser, tmp_path, "zhao-2023.yaml")
    browser.says("verdict", "may run")
    assert "singularity margin: " in browser.driver.page_source
    assert "cannot hold or steer" in browser.driver.page_source


def test_keys_are_offered_only_where_there_are_keys(
    browser: Browser, simulated: WebPage, chromium: Open
) -> None:
    at_home(simulated)
    browser.tab("Robot")
    browser.wait(lambda: browser.find("jog-keys").is_displayed(), "no switch on a desk")
    phone = chromium("about:blank", (390, 844))
    touch = {"features": [{"name": "hover", "value": "none"}]}
    phone.driver.execute_cdp_cmd("Emulation.setTouchEmulationEnabled", {"enabled": True})
    phone.driver.execute_cdp_cmd("Emulation.setEmulatedMedia", touch)
    phone.driver.get(simulated.url)
    phone.says("state", "ready")
    assert phone.find("jog-x+1").is_displayed()
    assert not phone.find("jog-keys").is_displayed()
