"""A page serves the session it was built for, as long as that lasts: the messages themselves."""

from __future__ import annotations

import ast
import html
import http.client
import json
import re
import time
import urllib.request
from collections.abc import Iterator
from contextlib import closing, contextmanager, suppress
from typing import Any
from urllib.parse import urlencode

import pytest
from websockets.exceptions import ConnectionClosed
from websockets.sync.client import ClientConnection, connect

from deltactl.firmware_py.daemon.client import Client
from deltactl.web.access.users import add_user
from tests.web.conftest import PASSWORD, WebPage, switch_off

NEVER_S = 1.5
"""So long nothing may happen that must not."""


@pytest.fixture
def page(signed_in: WebPage) -> WebPage:
    switch_off(signed_in)
    return signed_in


class Tab:
    """What a browser's tab holds: a cookie, and the page that was built for it."""

    def __init__(self, page: WebPage, name: str = ""):
        self.page, self.cookie = page, ""
        if name:
            self.sign_in(name)

    def ask(self, method: str, path: str, body: str = "") -> tuple[int, str]:
        """A request with the cookie, and its answer."""
        asked = http.client.HTTPConnection(self.page.url.removeprefix("http://"), timeout=20.0)
        with closing(asked):
            kind = {"Content-Type": "application/x-www-form-urlencoded"} if body else {}
            asked.request(method, path, body, {"Cookie": self.cookie, **kind})
            answer = asked.getresponse()
            if given := answer.getheader("set-cookie"):
                self.cookie = given.split(";")[0]
            return answer.status, answer.read().decode()

    def sign_in(self, name: str) -> None:
        assert self.ask("POST", "/login", urlencode({"name": name, "password": PASSWORD}))[0] == 303

    def load(self) -> None:
        """Have the page built, and read from it what its script would."""
        status, text = self.ask("GET", "/")
        assert status == 200
        raw = re.search(r"parseElements\(String.raw`(.*?)`\)", text, re.DOTALL)
        query = re.search(r"query: (\{.*?\}),\n", text)
        assert raw is not None
        assert query is not None
        self.elements: dict[str, Any] = json.loads(html.unescape(raw.group(1)))
        self.query: dict[str, Any] = ast.literal_eval(query.group(1))

    @contextmanager
    def connect(self, cookie: str = "") -> Iterator[ClientConnection]:
        """The page's own connection, or one that only says so."""
        asked = {
            **self.query, "implicit_handshake": "true", "tab_id": "t", "document_id": "d",
            "EIO": 4, "transport": "websocket",
        }  # fmt: skip
        url = f"{self.page.url.replace('http', 'ws')}/_nicegui_ws/socket.io/?{urlencode(asked)}"
        head = {"Cookie": cookie or self.cookie}
        with connect(url, additional_headers=head, open_timeout=20.0, ping_interval=None) as one:
            assert str(one.recv(20.0)).startswith("0")
            one.send("40")
            yield one

    def element(self, mark: str) -> dict[str, Any]:
        """One of the page's elements, with its number."""
        return next(
            {"number": number, **one} for number, one in self.elements.items()
            if one.get("props", {}).get("data-testid") == mark
        )  # fmt: skip

    def press(
        self, connection: ClientConnection, mark: str, kind: str = "click", value: object = None
    ) -> None:
        """What the script sends for a click on a button of this page, or for another event."""
        part = self.element(mark)
        heard = next(
            event
            for event in part["events"]
            if event["type"] == kind and not event.get("js_handler")
        )
        event = {
            "id": int(part["number"]), "client_id": self.query["client_id"],
            "listener_id": heard["listener_id"],
            "args": [json.dumps({} if value is None else value)],
        }  # fmt: skip
        connection.send("42" + json.dumps(["event", event]))


def answer(connection: ClientConnection) -> str:
    """The answer to connecting: "40..." where it was let in."""
    return str(connection.recv(20.0))


def is_closed(connection: ClientConnection) -> bool:
    """Whether the page's connection is ended, after whatever it still says."""
    give_up_s = time.monotonic() + 20.0
    while time.monotonic() < give_up_s:
        try:
            connection.recv(1.0)
        except TimeoutError:
            continue
        except ConnectionClosed:
            return True
    return False


def state(page: WebPage) -> str:
    assert page.socket is not None
    with Client(page.socket) as client:
        return client.status().state


def operates(tab: Tab, connection: ClientConnection) -> None:
    """Switch on and off, so that what does nothing afterwards has its reason in who sends it."""
    assert answer(connection).startswith("40")
    for mark, wanted in (("power_on", "unhomed"), ("power_off", "off")):
        give_up_s = time.monotonic() + 20.0
        while state(tab.page) != wanted:
            assert time.monotonic() < give_up_s, state(tab.page)
            tab.press(connection, mark)  # again: a button is offered once the page knows the state
            time.sleep(0.5)


def log_of(page: WebPage) -> str:
    return (page.recordings.parent / "log").read_text()


def test_a_press_on_ones_own_name_ends_nothing(page: WebPage) -> None:
    tab = Tab(page, "hall")
    tab.load()
    assert tab.element("user")["props"].get("type") != "submit"
    assert tab.element("sign-out")["props"]["type"] == "submit"
    assert tab.element("make-token")


def test_a_phone_is_offered_the_page_as_an_app_before_anybody_signs_in(page: WebPage) -> None:
    tab = Tab(page)
    status, text = tab.ask("GET", "/manifest.webmanifest")
    assert status == 200
    manifest = json.loads(text)
    assert (manifest["start_url"], manifest["display"]) == ("/", "standalone")
    for icon in manifest["icons"]:
        with urllib.request.urlopen(f"{page.url}{icon['src']}", timeout=20.0) as answer:
            assert answer.headers["content-type"] == icon["type"]
            assert answer.read().startswith(b"\x89PNG")
    tab.sign_in("hall")
    assert 'rel="manifest" href="/manifest.webmanifest"' in tab.ask("GET", "/")[1]


def test_an_operators_tab_operates_and_is_logged_by_name(page: WebPage) -> None:
    ada = Tab(page, "ada")
    ada.load()
    with ada.connect() as connection:
        operates(ada, connection)
    assert "power on asked for by ada" in log_of(page)


def test_after_a_viewer_has_signed_in_the_old_tab_does_nothing(page: WebPage) -> None:
    """The same browser: signed out and in within seconds, while NiceGUI waits for a reconnect."""
    tab = Tab(page, "ada")
    tab.load()
    with tab.connect() as connection:
        operates(tab, connection)
        before = log_of(page).count("power on asked for")
        tab.ask("POST", "/logout")
        tab.sign_in("hall")
        with suppress(ConnectionClosed):
            tab.press(connection, "power_on")
        assert is_closed(connection)
    with tab.connect() as again:
        assert answer(again).startswith("44"), "the script loads the page anew"
        tab.press(again, "power_on")
        time.sleep(NEVER_S)
    assert state(page) == "off"
    assert log_of(page).count("power on asked for") == before


def test_a_viewer_who_names_an_operators_page_does_nothing(page: WebPage) -> None:
    ada, hall = Tab(page, "ada"), Tab(page, "hall")
    ada.load()
    hall.load()
    with ada.connect() as open_page, hall.connect() as other:
        operates(ada, open_page)
        assert answer(other).startswith("40")
        ada.press(other, "power_on")
        time.sleep(NEVER_S)
        assert state(page) == "off"


def test_a_second_session_of_the_same_user_has_its_own_page(page: WebPage) -> None:
    first, second = Tab(page, "ada"), Tab(page, "ada")
    first.load()
    with first.connect(second.cookie) as connection:
        assert answer(connection).startswith("44")


def test_files_are_judged_by_who_sends_them(page: WebPage) -> None:
    ada, hall = Tab(page, "ada"), Tab(page, "hall")
    ada.load()
    url = next(one["props"]["url"] for one in ada.elements.values()
               if "/upload/" in str(one.get("props", {}).get("url", "")))  # fmt: skip
    assert hall.ask("POST", url, "x")[0] == 403
    assert ada.ask("POST", url, "x")[0] != 403
    assert hall.ask("POST", "/recording?name=x.csv", "t,q")[0] == 403
    ada.ask("POST", "/logout")
    assert ada.ask("POST", url, "x")[0] == 401


def test_a_changed_role_ends_what_the_open_page_may(page: WebPage) -> None:
    users = page.recordings.parent / "users.yaml"
    add_user(users, "eve", "operator", PASSWORD)
    eve = Tab(page, "eve")
    eve.load()
    with eve.connect() as connection:
        operates(eve, connection)
        add_user(users, "eve", "viewer", PASSWORD)
        eve.press(connection, "power_on")
        assert is_closed(connection)
    assert state(page) == "off"


def test_no_other_origin_is_answered_and_no_other_way_than_a_websocket(page: WebPage) -> None:
    path = "/_nicegui_ws/socket.io/?EIO=4&transport=polling"
    cookie = Tab(page, "ada").cookie
    for origin in ("http://evil.example", page.url):
        asked = http.client.HTTPConnection(page.url.removeprefix("http://"), timeout=20.0)
        with closing(asked):
            asked.request("GET", path, headers={"Origin": origin, "Cookie": cookie})
            answered = asked.getresponse()
            assert answered.status in (400, 403)
            assert answered.getheader("access-control-allow-origin") is None


def test_an_address_that_there_is_not_builds_no_page(page: WebPage) -> None:
    for path in ("/nothing", "/_nicegui/nothing", "/_nicegui/client/x/upload/3"):
        status, text = Tab(page, "ada").ask("GET", path)
        assert status in (403, 404)
        assert len(text) < 300, "one line, and not a whole page"


def test_pages_that_nobody_comes_for_make_room(page: WebPage) -> None:
    ada = Tab(page, "ada")
    tabs = [Tab(page) for _ in range(10)]
    for tab in tabs:
        tab.cookie = ada.cookie
        tab.load()
    with tabs[0].connect() as oldest, tabs[-1].connect() as newest:
        assert answer(oldest).startswith("44")
        assert answer(newest).startswith("40")
