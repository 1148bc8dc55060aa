"""`deltactl web --simulate` in a process of its own, and Debian's Chromium to look at it."""

from __future__ import annotations

import os
import shutil
import signal
import socket
import subprocess
import sys
import time
import urllib.request
from collections import defaultdict
from collections.abc import Callable, Iterator
from dataclasses import dataclass
from functools import partial
from pathlib import Path

import pytest
from selenium import webdriver
from selenium.common.exceptions import StaleElementReferenceException
from selenium.webdriver.chrome.service import Service
from selenium.webdriver.common.by import By
from selenium.webdriver.remote.webelement import WebElement

from deltactl.drivers.steps.pulse_main import die_with_parent
from deltactl.firmware_py.daemon.client import Client
from deltactl.firmware_py.named_files import CONFIG_FOLDER
from deltactl.web.access.users import SCRYPT, add_user

READY_S = 60.0
PATIENCE_S = 30.0
LOOK_S = 0.15
"""The longest pause between two looks at a page."""
NICE = 15
PASSWORD = "correct horse battery"
DESK, PHONE = (1280, 900), (400, 800)
CIRCLE = """name: {name}
robot: {robot}
path: {{shape: circle, centre_m: [0, 0, -0.45], radius_m: 0.05, turns: {turns}}}
timing: {{mode: accelerated, speed_mps: 0.1}}
inverse_kinematics: {{kind: geometry}}
on_blind: warn
"""


@dataclass
class Browser:
    """One Chromium on one page."""

    driver: webdriver.Chrome

    def find(self, name: str, within_s: float = PATIENCE_S) -> WebElement:
        """The element with this data-testid, as soon as it is there."""
        place = f'[data-testid="{name}"]'
        self.wait(lambda: self.driver.find_elements(By.CSS_SELECTOR, place), f"no {name}", within_s)
        return self.driver.find_element(By.CSS_SELECTOR, place)

    def text(self, name: str) -> str:
        """What an element says."""
        return self.find(name).text.lower()

    def press(self, name: str) -> None:
        """Click a button once it can be clicked."""
        self.wait(lambda: self.find(name).is_enabled(), f"{name} stays disabled")
        self.find(name).click()

    def open_file(self, path: Path) -> None:
        """Give the browser a file of one's own, as its dialog would."""
        place = "input[type=file]"
        self.wait(lambda: self.driver.find_elements(By.CSS_SELECTOR, place), "no upload")
        self.driver.find_element(By.CSS_SELECTOR, place).send_keys(str(path))

    def open_own(self, path: Path) -> None:
        """Send a recording of one's own."""
        self.find("own-file").send_keys(str(path))

    def all(self, name: str) -> list[WebElement]:
        """All elements with this data-testid."""
        return self.driver.find_elements(By.CSS_SELECTOR, f'[data-testid="{name}"]')

    def tab(self, name: str) -> None:
        """Turn to a tab."""
        self.driver.find_element(By.XPATH, f'//div[@role="tab"][.="{name}"]').click()

    def says(self, name: str, words: str, within_s: float = PATIENCE_S) -> None:
        """Wait until an element says something."""
        self.find(name, within_s)
        self.wait(
            lambda: words in self.text(name),
            lambda: f"{name} says {self.text(name)!r}, not {words!r}",
            within_s,
        )

    def wait(
        self,
        condition: Callable[[], object],
        otherwise: str | Callable[[], str],
        within_s: float = PATIENCE_S,
    ) -> None:
        """Wait for something; fail with words when it does not come."""
        give_up_s = time.monotonic() + within_s
        pause_s = 0.02
        while True:
            try:
                if condition():
                    return
            except StaleElementReferenceException:
                pass
            if time.monotonic() > give_up_s:
                latched = self.driver.find_elements(By.CSS_SELECTOR, '[data-testid="latched"]')
                seen = "; ".join(one.text for one in latched if one.text)
                pytest.fail(f"{otherwise if isinstance(otherwise, str) else otherwise()} {seen}")
            # Each look costs the browser as much as a tenth of a second of the page.
            time.sleep(pause_s)
            pause_s = min(1.5 * pause_s, LOOK_S)


Open = Callable[..., Browser]


@dataclass
class WebPage:
    """A page that is served, and where its robot records."""

    process: subprocess.Popen[bytes]
    url: str
    recordings: Path
    socket: Path | None = None


def free_port() -> int:
    """A port nobody has."""
    with socket.socket() as probe:
        probe.bind(("127.0.0.1", 0))
        return int(probe.getsockname()[1])


def start_page(folder: Path, *more: str) -> WebPage:
    """Start `deltactl web` and wait until it answers."""
    port = free_port()
    call = ["web", "--port", str(port), "--recordings", str(folder / "recordings"), *more]
    with (folder / "log").open("wb") as log:
        process = subprocess.Popen(
            [sys.executable, "-P", "-m", "deltactl.cli.main", *call],
            cwd=folder, stdout=log, stderr=log,
            preexec_fn=partial(die_with_parent, signal.SIGINT),
        )  # fmt: skip
    page = WebPage(process, f"http://127.0.0.1:{port}", folder / "recordings")
    give_up_s = time.monotonic() + READY_S
    while True:
        try:
            urllib.request.urlopen(f"{page.url}/health", timeout=5.0).close()
            return page
        except OSError:
            if process.poll() is not None or time.monotonic() > give_up_s:
                pytest.fail(f"the page did not start: {(folder / 'log').read_text()}")
            time.sleep(0.1)


def patient_robot(folder: Path) -> Path:
    """The Zhao robot for a machine that renders its own browser: it bears pauses of seconds."""
    text = (CONFIG_FOLDER / "zhao-2023.yaml").read_text(encoding="utf-8")
    path = folder / "zhao-2023.yaml"
    path.write_text(text.replace("backend: pulse", "heartbeat_s: 5.0\n  backend: pulse"))
    return path


def end_page(page: WebPage) -> None:
    """End it as Ctrl-C does."""
    page.process.send_signal(signal.SIGINT)
    page.process.wait(20.0)


def switch_off(page: WebPage) -> None:
    """Whatever an attempt before this one has left."""
    assert page.socket is not None
    with Client(page.socket) as client:
        if client.status().state in ("stopped", "fault"):
            client.acknowledge()
        if client.status().state != "off":
            client.power_off()


def at_home(page: WebPage) -> None:
    """Ready, whatever an attempt or a test before this one has left."""
    assert page.socket is not None
    with Client(page.socket) as client:
        if client.status().state != "ready":
            switch_off(page)
            client.power_on()
            client.home()


HERE = Path(__file__).parent
CLOSERS = pytest.StashKey[list[Callable[[], None]]]()
"""What ends the page and the browsers that files of tests share."""


@pytest.hookimpl(wrapper=True)
def pytest_runtest_teardown(item: pytest.Item, nextitem: pytest.Item | None) -> Iterator[None]:
    """End them with the last test of the page: tests elsewhere need the processor."""
    yield
    if nextitem is not None and not nextitem.path.is_relative_to(HERE):
        for close in item.config.stash.get(CLOSERS, []):
            close()


def ends_with_the_folder(config: pytest.Config, close: Callable[[], None]) -> None:
    config.stash.setdefault(CLOSERS, []).append(close)


@pytest.fixture(scope="session")
def simulated(
    tmp_path_factory: pytest.TempPathFactory, pytestconfig: pytest.Config
) -> Iterator[WebPage]:
    """The page of a simulated robot, one for all tests."""
    folder = tmp_path_factory.mktemp("web")
    place = folder / "d.sock"
    page = start_page(
        folder, "--simulate", "--robot", str(patient_robot(folder)), "--socket", str(place)
    )
    page.socket = place
    ends_with_the_folder(pytestconfig, lambda: end_page(page))
    yield page
    end_page(page)


@pytest.fixture(scope="session")
def signed_in(
    simulated: WebPage, tmp_path_factory: pytest.TempPathFactory, pytestconfig: pytest.Config
) -> Iterator[WebPage]:
    """A second page for the same robot, with passwords: ada operates, hall looks."""
    folder = tmp_path_factory.mktemp("signed-in")
    users = folder / "users.yaml"
    add_user(users, "ada", "operator", PASSWORD)
    add_user(users, "hall", "viewer", PASSWORD)
    page = start_page(folder, "--users", str(users), "--socket", str(simulated.socket))
    page.socket = simulated.socket
    ends_with_the_folder(pytestconfig, lambda: end_page(page))
    yield page
    end_page(page)


def a_chromium(size: tuple[int, int] = DESK, drawn: bool = True) -> webdriver.Chrome:
    """Debian's Chromium, without a window. Skips where there is none.

    drawn: whether it draws the robot in 3D, in software: up to a core as long as it is open.
    """
    binary, driver = shutil.which("chromium"), shutil.which("chromedriver")
    if binary is None or driver is None:
        pytest.skip("needs Debian's packages chromium and chromium-driver")
    options = webdriver.ChromeOptions()
    options.binary_location = binary
    in_3d = ("--disable-gpu", "--enable-unsafe-swiftshader")
    without = ("--disable-gpu", "--disable-3d-apis")
    for word in ("--headless=new", "--no-sandbox", "--disable-dev-shm-usage",
                 f"--window-size={size[0]},{size[1]}", *(in_3d if drawn else without)):  # fmt: skip
        options.add_argument(word)
    options.set_capability("goog:loggingPrefs", {"browser": "ALL"})
    # Its software rendering must not take the processor from the daemon's pulses.
    low = {"preexec_fn": lambda: os.nice(NICE)} if drawn else {}
    return webdriver.Chrome(options=options, service=Service(driver, popen_kw=low))


@pytest.fixture(scope="module")
def quick_hashes() -> Iterator[None]:
    """Passwords of a file of tests cost next to nothing to hash, and as little to guess."""
    with pytest.MonkeyPatch.context() as patch:
        patch.setitem(SCRYPT, "n", 2)
        yield


Size = tuple[int, int]


@pytest.fixture(scope="session")
def resting(pytestconfig: pytest.Config) -> Iterator[dict[Size, list[webdriver.Chrome]]]:
    """Browsers without 3D, by the size of their window, that wait for the next file of tests."""
    waiting: dict[Size, list[webdriver.Chrome]] = defaultdict(list)

    def quit_all() -> None:
        for browsers in waiting.values():
            while browsers:
                browsers.pop().quit()

    ends_with_the_folder(pytestconfig, quit_all)
    yield waiting
    quit_all()


def as_new(driver: webdriver.Chrome, origin: str) -> None:
    """One empty tab, without cookies, what pages stored, what they logged, and emulation."""
    used = driver.window_handles
    driver.switch_to.new_window("tab")
    empty = driver.current_window_handle
    for one in used:
        driver.switch_to.window(one)
        driver.close()
    driver.switch_to.window(empty)
    driver.execute_cdp_cmd("Network.clearBrowserCookies", {})
    if origin.startswith("http"):
        all_of_it = {"origin": origin, "storageTypes": "all"}
        driver.execute_cdp_cmd("Storage.clearDataForOrigin", all_of_it)
    driver.execute("getLog", {"type": "browser"})  # which is emptied by it


@pytest.fixture(scope="module")
def chromium(resting: dict[Size, list[webdriver.Chrome]]) -> Iterator[Open]:
    """Opens pages: `chromium(url, size, drawn)`, of which few tests look at the robot in 3D.

    All pages are closed at the end of a file of tests: a dozen of them leave no time for the
    pulses. Browsers without 3D are lent to the next file, as if they were new.
    Skips where there is no Chromium.
    """
    drawing: list[webdriver.Chrome] = []
    lent: list[tuple[webdriver.Chrome, Size, str]] = []

    def make(url: str, size: Size = DESK, drawn: bool = False) -> Browser:
        if drawn or not resting[size]:
            one = a_chromium(size, drawn)
            one.set_page_load_timeout(60.0)
        else:
            one = resting[size].pop()
        if drawn:
            drawing.append(one)
        else:
            lent.append((one, size, url))
        one.get(url)
        return Browser(one)

    yield make
    for one in drawing:
        one.quit()
    for one, size, url in lent:
        as_new(one, url)
        resting[size].append(one)


@pytest.fixture(scope="module")
def browser(simulated: WebPage, chromium: Open) -> Browser:
    """The page at a desk, one for a file of tests."""
    return chromium(simulated.url)
