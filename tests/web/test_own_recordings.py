"""A recording of one's own on the page: sent, listed, diagnosed; and what is not taken."""

from __future__ import annotations

import asyncio
from collections.abc import AsyncIterator, Callable
from pathlib import Path

import pytest
from fastapi import FastAPI
from selenium.webdriver.common.by import By
from selenium.webdriver.remote.webelement import WebElement
from starlette.testclient import TestClient

from deltactl.foundation.errors import RecordingError
from deltactl.web.access.guard import MAX_UPLOAD, UPLOAD, Guard
from deltactl.web.access.users import Session, Sessions
from deltactl.web.behind import own_recordings
from deltactl.web.behind.known_robots import KnownRobots
from deltactl.web.behind.link import DaemonLink
from deltactl.web.behind.own_recordings import MAX_BYTES, MOST, OwnRecordings
from deltactl.web.behind.site import Site
from deltactl.web.serve import add_pages
from tests.web.conftest import CIRCLE, Browser, WebPage
from tests.web.test_hidden_fault import run_job, simulated_robot

Open = Callable[..., Browser]
HERE = "http://127.0.0.1:8080"


def a_site(folder: Path) -> Site:
    return Site(DaemonLink(None), KnownRobots(), folder / "recordings", folder / "work")


def client(site: Site, role: str = "operator") -> TestClient:
    """The page's routes behind its guard, for somebody of this role."""
    app = FastAPI()
    add_pages(app, site)

    class Known(Sessions):
        def __init__(self) -> None:
            """Nobody signs in."""

        def of(self, word: str) -> Session | None:
            return Session("ada", role, 0.0) if word else None

    return TestClient(Guard(app, Known()), HERE, cookies={"deltactl": "word"})


@pytest.mark.parametrize(
    "name", ["../../etc/cron.d/x.csv", "C:\\x.csv", "a\nb\x1b.csv", "$(id).csv"]
)
def test_a_name_is_shown_and_reaches_no_path(name: str, tmp_path: Path) -> None:
    site = a_site(tmp_path)
    answer = client(site).post(UPLOAD, params={"name": name}, content=b"t,x\n0,1\n")
    assert answer.status_code == 200, answer.text
    (one,) = site.listed()
    assert one.path.parent == tmp_path / "work" / "own"
    assert one.path.stem.isalnum()
    assert one.title.isprintable()
    assert not {"/", "\\"} & set(one.title)
    (there,) = (tmp_path / "work" / "own").glob("*.csv")
    assert there.read_bytes() == b"t,x\n0,1\n"


@pytest.mark.parametrize(
    ("name", "content", "says"),
    [("x.exe", b"x", "ends in .csv"), ("", b"x", "ends in .csv"), ("x.csv", b"", "is empty")],
)
def test_what_is_no_recording_is_one_line(
    name: str, content: bytes, says: str, tmp_path: Path
) -> None:
    answer = client(a_site(tmp_path)).post(UPLOAD, params={"name": name}, content=content)
    assert answer.status_code == 400
    assert says in answer.text
    assert "\n" not in answer.text.strip()
    assert not list((tmp_path / "work" / "own").glob("*"))


def test_a_viewer_sends_none_and_neither_does_another_site(tmp_path: Path) -> None:
    site = a_site(tmp_path)
    assert client(site, "viewer").post(UPLOAD + "?name=x.csv", content=b"x").status_code == 403
    foreign = client(site).post(
        UPLOAD + "?name=x.csv", content=b"x", headers={"origin": "http://evil.example"}
    )
    assert foreign.status_code == 403
    long = client(site).post(
        UPLOAD + "?name=x.csv", content=b"x", headers={"content-length": str(MAX_UPLOAD + 1)}
    )
    assert long.status_code == 413
    assert site.listed() == []


async def pieces(*sizes: int) -> AsyncIterator[bytes]:
    for size in sizes:
        yield b"x" * size


def test_the_size_is_counted_whatever_was_announced_and_the_oldest_go(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    assert MAX_UPLOAD == MAX_BYTES
    own = OwnRecordings(tmp_path)
    monkeypatch.setattr(own_recordings, "MAX_BYTES", 1000)
    with pytest.raises(RecordingError, match="not taken"):
        asyncio.run(own.take("big.csv", pieces(600, 600)))
    assert list(tmp_path.glob("*")) == []
    for k in range(MOST + 2):
        asyncio.run(own.take(f"{k}.csv", pieces(5)))
    names = [own.name_of(one) for one in own.newest_first()]
    assert len(names) == MOST
    assert "0.csv" not in names
    assert len(list(tmp_path.glob("*"))) == 2 * MOST
    monkeypatch.setattr(own_recordings, "LEAST_FREE_BYTES", 2**62)
    with pytest.raises(RecordingError, match="disk is nearly full"):
        asyncio.run(own.take("one.csv", pieces(5)))


async def stalled() -> AsyncIterator[bytes]:
    yield b"t,x\n"
    await asyncio.sleep(60.0)


def test_one_that_stalls_is_given_up_and_the_next_is_taken(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    own = OwnRecordings(tmp_path)
    monkeypatch.setattr(own_recordings, "LONGEST_PAUSE_S", 0.1)
    with pytest.raises(RecordingError, match=r"slow\.csv: nothing came of it for 0\.1 s"):
        asyncio.run(asyncio.wait_for(own.take("slow.csv", stalled()), 5.0))
    assert list(tmp_path.glob("*")) == []
    asyncio.run(own.take("next.csv", pieces(5)))


@pytest.mark.study
def test_a_run_is_opened_and_diagnosed_and_a_bad_table_is_a_line(
    simulated: WebPage, chromium: Open, tmp_path: Path
) -> None:
    controller = simulated_robot(tmp_path)
    job = tmp_path / "circle.yaml"
    job.write_text(CIRCLE.format(name="circle", robot="zhao-2023.yaml", turns=1))
    run = run_job(controller, job).rename(tmp_path / "my heart.mcap")
    controller.close()
    browser = chromium(simulated.url)
    browser.tab("Recordings")
    send(browser, run)
    browser.says("own-says", "my heart.mcap is in the list")
    card = row(browser, "my heart.mcap")
    card.find_element(By.CSS_SELECTOR, '[data-testid="diagnose"]').click()
    browser.says("answer", "nothing is missing", 90.0)
    assert browser.text("own-says") == ""
    bad = tmp_path / "bad.csv"
    bad.write_text("ms,angle\n0,1\n20,2\n40,3\n")
    send(browser, bad)
    browser.says("own-says", "bad.csv is in the list")
    card = row(browser, "bad.csv")
    card.find_element(By.CSS_SELECTOR, '[data-testid="diagnose"]').click()
    browser.says("failed", "press columns")
    assert "deltactl" not in browser.text("failed")
    card.find_element(By.CSS_SELECTOR, '[data-testid="columns"]').click()
    browser.says("columns-form", "ms (0, 20, 40 ...)")
    browser.press("columns-done")
    browser.wait(lambda: "press columns" not in browser.text("failed"), "the choice is not taken")
    assert "bad.csv" in browser.text("failed")
    other = tmp_path / "song.mp3"
    other.write_bytes(b"la")
    send(browser, other)
    browser.says("own-says", "ends in .csv")


def send(browser: Browser, path: Path) -> None:
    browser.find("own-file").send_keys(str(path))


def row(browser: Browser, title: str) -> WebElement:
    place = f'//*[@data-testid="recording"][.="{title}"]/ancestor::*[contains(@class,"q-card")]'
    browser.wait(lambda: browser.driver.find_elements(By.XPATH, place), f"{title} is not listed")
    return browser.driver.find_element(By.XPATH, place)
