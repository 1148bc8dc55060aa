"""A key that is held moves on, and stops the robot when it is released: without a browser."""

from __future__ import annotations

import time
from collections.abc import Iterator
from contextlib import contextmanager, suppress

import pytest
from websockets.sync.client import ClientConnection

from deltactl.firmware_py.daemon.client import Client
from deltactl.web.motion_card import STEPS_MM
from tests.web.conftest import WebPage, at_home, switch_off
from tests.web.test_runs_of_a_robot import until
from tests.web.test_whose_page import Tab, answer

REPEAT_S = 0.05
LONG = list(STEPS_MM).index(50)
"""As the browser names the choice of 50 mm, which takes the robot half a second."""


@contextmanager
def opened(page: WebPage) -> Iterator[tuple[Tab, ClientConnection]]:
    """A page, as a browser has it open."""
    tab = Tab(page)
    tab.load()
    with tab.connect() as connection:
        assert answer(connection).startswith("40")
        yield tab, connection


def stay_connected(connection: ClientConnection) -> None:
    """Hear what comes for a moment, and answer a ping as a browser does."""
    give_up_s = time.monotonic() + REPEAT_S
    while (left_s := give_up_s - time.monotonic()) > 0.0:
        with suppress(TimeoutError):
            if connection.recv(left_s) == "2":
                connection.send("3")


def held_and_released(page: WebPage, kind: str, key: str) -> set[str]:
    """How the moves ended that a held key had asked for when it was released."""
    at_home(page)
    assert page.socket is not None
    with opened(page) as (tab, connection), Client(page.socket) as client:
        tab.press(connection, "step-mm", "update:modelValue", LONG)
        tab.press(connection, "cross", "keydown", {"key": "PageDown", "repeat": False})
        give_up_s = time.monotonic() + 90.0
        while client.status().job is None:
            assert time.monotonic() < give_up_s, "a key does not move the robot"
            tab.press(connection, "cross", "keydown", {"key": "PageDown", "repeat": True})
            stay_connected(connection)
        now = client.status()
        asked = {now.job_id, *now.queued_ids} - {None}
        tab.press(connection, "cross", kind, {"key": key})
        until(lambda: client.status().state == "ready", 60.0)
        counts = client.status().counts
        time.sleep(0.5)
        assert client.status().counts == counts
        return {client.result(number).outcome for number in asked}  # type: ignore[union-attr, arg-type]


@pytest.mark.parametrize(("kind", "key"), [("keyup", "PageDown"), ("focusout", "")])
def test_what_a_held_key_has_asked_for_is_called_off(
    simulated: WebPage, kind: str, key: str
) -> None:
    for _ in range(3):
        outcomes = held_and_released(simulated, kind, key)
        if "done" not in outcomes:  # a move of half a second may end before the page hears of it
            break
        switch_off(simulated)
    assert outcomes == {"cancelled"}


def test_other_keys_and_keys_elsewhere_move_nothing(simulated: WebPage) -> None:
    at_home(simulated)
    assert simulated.socket is not None
    with opened(simulated) as (tab, page), Client(simulated.socket) as client:
        counts = client.status().counts
        for key in ("a", "Enter", "Tab", ""):
            tab.press(page, "cross", "keydown", {"key": key, "repeat": False})
        time.sleep(0.5)
        assert client.status().counts == counts
