"""The interface for programs: the same site and guard as the page's, with tokens."""

from __future__ import annotations

from collections.abc import Iterator
from pathlib import Path

import pytest
from fastapi import FastAPI
from starlette.testclient import TestClient
from starlette.websockets import WebSocketDisconnect

from deltactl.foundation.errors import ConfigError
from deltactl.web.access.guard import Guard
from deltactl.web.access.login import add_login
from deltactl.web.access.tokens import MOST_EACH, Tokens
from deltactl.web.access.users import Sessions, Users, add_user
from deltactl.web.api import PLACE, make_api
from deltactl.web.behind.known_robots import KnownRobots
from deltactl.web.behind.link import DaemonLink
from deltactl.web.behind.site import Site
from deltactl.web.motion_card import to_point
from tests.rigs.served import Served, served
from tests.web.test_runs_of_a_robot import until
from tests.web.test_who_may import HERE, PASSWORD

CIRCLE = """name: ring
robot: mine.yaml
path: {shape: circle, centre_m: [0, 0, -0.33], radius_m: 0.02}
timing: {mode: accelerated, speed_mps: 0.1}
inverse_kinematics: {kind: geometry}
on_blind: warn
"""


class Here:
    """A robot, its site, and programs that ask."""

    def __init__(self, folder: Path, robot: Served, users: Path):
        self.robot = robot
        self.link = DaemonLink(robot.socket)
        robots = KnownRobots(folder / "mine.yaml")
        self.site = Site(self.link, robots, folder, folder / "work")
        known = Users(users)
        sessions = Sessions(known)
        self.tokens = Tokens(folder / "work" / "tokens.json", known)
        app = FastAPI()
        add_login(app, known, sessions, secure=False)
        app.mount(PLACE, make_api(self.site))
        self.guard = Guard(app, sessions, self.tokens)
        self.link.start()
        until(lambda: self.link.seen.status is not None)

    def program(self, token: str) -> TestClient:
        head = {"authorization": f"Bearer {token}"} if token else {}
        return TestClient(self.guard, HERE, headers=head)


@pytest.fixture(scope="module")
def here(tmp_path_factory: pytest.TempPathFactory, quick_hashes: None) -> Iterator[Here]:
    folder = tmp_path_factory.mktemp("api")
    users = folder / "users.yaml"
    add_user(users, "ada", "operator", PASSWORD)
    add_user(users, "hall", "viewer", PASSWORD)
    (folder / "work").mkdir()
    with served(folder) as robot:
        made = Here(folder, robot, users)
        yield made
        made.link.close()


@pytest.fixture(scope="module")
def ada(here: Here) -> TestClient:
    return here.program(here.tokens.make("ada", "script", False))


@pytest.fixture(scope="module")
def viewer(here: Here) -> TestClient:
    return here.program(here.tokens.make("ada", "screen", True))


def paths(client: TestClient) -> dict[str, dict[str, object]]:
    found: dict[str, dict[str, object]] = client.get(f"{PLACE}/openapi.json").json()["paths"]
    return found


def test_without_a_token_nothing_is_answered(here: Here) -> None:
    for token in ("", "wrong", "x" * 5000):
        nobody = here.program(token)
        assert nobody.get(f"{PLACE}/status").status_code == 401
        assert nobody.post(f"{PLACE}/stop").status_code == 401
        with (
            pytest.raises(WebSocketDisconnect),
            nobody.websocket_connect(f"ws://127.0.0.1:8080{PLACE}/watch"),
        ):
            pass


def test_a_viewers_token_does_nothing_that_the_interface_describes_but_stop(
    here: Here, viewer: TestClient
) -> None:
    """Every path of the description that is no GET, so that a new one is judged too."""
    bodies = {"place": 1, "name": "x.yaml", "text": CIRCLE}
    changing = [
        (verb, path)
        for path, verbs in paths(viewer).items()
        for verb in verbs
        if verb != "get" and not path.endswith(("/stop", "/check", "/diagnose"))
    ]
    assert len(changing) > 12
    before = here.robot.controller.status()
    for verb, path in changing:
        url = path.replace("{job_id}", "1").replace("{name}", "x.yaml").replace("{key}", "x")
        if "/recordings/" in path:
            continue  # told apart below, with a recording that is there
        answer = viewer.request(verb, f"{PLACE}{url}", json=bodies)
        assert answer.status_code == 403, (verb, path, answer.text)
        assert answer.json()["error"]["kind"] == "Forbidden"
    assert here.robot.controller.status().state == before.state == "ready"
    assert viewer.get(f"{PLACE}/status").json()["state"] == "ready"


def test_a_token_ends_with_its_user_and_opens_no_page(here: Here, tmp_path: Path) -> None:
    users = tmp_path / "users.yaml"
    add_user(users, "eve", "operator", PASSWORD)
    known = Users(users)
    tokens = Tokens(tmp_path / "tokens.json", known)
    word = tokens.make("eve", "x", False)
    assert word not in (tmp_path / "tokens.json").read_text()
    again = Tokens(tmp_path / "tokens.json", known)
    session = again.session(f"Bearer {word}")
    assert session is not None
    assert session is again.session(f"bearer {word}")
    assert (session.name, session.role) == ("eve", "operator")
    for _ in range(MOST_EACH - 1):
        tokens.make("eve", "x", False)
    with pytest.raises(ConfigError, match="take one back"):
        tokens.make("eve", "x", False)
    add_user(users, "eve", "viewer", PASSWORD + "?")
    assert again.session(f"Bearer {word}") is None
    second = again.make("eve", "y", False)
    demoted = again.session(f"Bearer {second}")
    assert demoted is not None
    assert demoted.role == "viewer"
    again.take_back("hall", again.of("eve")[0].sha256)
    assert again.session(f"Bearer {second}") is not None
    again.take_back("eve", again.of("eve")[0].sha256)
    assert again.session(f"Bearer {second}") is None
    page = here.program(here.tokens.make("ada", "page", False)).get("/", follow_redirects=False)
    assert page.status_code == 303, "a token is no session of the page"


def test_a_job_is_kept_run_and_found_in_history_and_recordings(
    here: Here, ada: TestClient, viewer: TestClient
) -> None:
    assert ada.post(f"{PLACE}/check", json={"text": CIRCLE}).json() == []
    wrong = ada.post(f"{PLACE}/check", json={"text": CIRCLE.replace("circle", "cirle")}).json()
    assert wrong[0]["line"] == 3
    assert ada.put(f"{PLACE}/jobs/ring", json={"text": CIRCLE}).json() == {"name": "ring.yaml"}
    assert ada.patch(f"{PLACE}/jobs/ring.yaml", json={"name": "round"}).status_code == 200
    kept = [job["name"] for job in ada.get(f"{PLACE}/jobs").json() if job["own"]]
    assert kept == ["round.yaml"]
    assert ada.get(f"{PLACE}/jobs/round.yaml").json()["text"] == CIRCLE
    refused = ada.put(f"{PLACE}/jobs/heart.yaml", json={"text": CIRCLE})
    assert refused.status_code == 400
    assert "belongs to" in refused.json()["error"]["message"]
    here.robot.ready()
    answer = ada.post(f"{PLACE}/queue", json={"name": "round.yaml"})
    assert answer.status_code == 200, answer.text
    until(lambda: bool(here.site.history.newest_first()))
    (ended,) = viewer.get(f"{PLACE}/history").json()
    result = here.robot.controller.result(answer.json()["job_id"])
    assert result is not None
    assert (ended["name"], ended["outcome"]) == ("ring", result.outcome)
    assert ended["duration_s"] > 0.5 or result.outcome == "fault", "a computer under load stalls"
    (found,) = viewer.get(f"{PLACE}/recordings").json()
    url = f"{PLACE}/recordings/{found['id']}"
    assert viewer.delete(url).status_code == 403
    assert viewer.patch(url, json={"name": "x"}).status_code == 403
    assert viewer.get(f"{url}/file").content.startswith(b"\x89MCAP")
    assert ada.patch(url, json={"name": "my ring"}).status_code == 200
    (renamed,) = ada.get(f"{PLACE}/recordings").json()
    assert renamed["title"] == "my ring"
    assert here.site.history.newest_first()[0].recording == "my ring.mcap"
    assert ada.delete(f"{PLACE}/recordings/my%20ring").status_code == 200
    assert ada.get(f"{PLACE}/recordings").json() == []
    assert ada.delete(f"{PLACE}/jobs/round.yaml").status_code == 200
    assert ada.get(f"{PLACE}/jobs/round.yaml").status_code == 400


def test_the_queue_is_sorted_watched_and_stopped_by_a_viewer(
    here: Here, ada: TestClient, viewer: TestClient
) -> None:
    here.robot.ready()
    at = here.robot.controller.status().position_m
    assert at is not None
    numbers = []
    texts = {name: to_point("mine.yaml", at, name) for name in "bc"}
    for name, text in {
        "a": CIRCLE.replace("radius_m: 0.02", "radius_m: 0.02, turns: 5"),
        **texts,
    }.items():
        numbers.append(ada.post(f"{PLACE}/queue", json={"name": name, "text": text}).json())
        assert name != "a" or ada.post(f"{PLACE}/pause").status_code == 200
    assert ada.put(f"{PLACE}/queue/{numbers[2]['job_id']}", json={"place": 1}).status_code == 200
    waiting = [name for name in here.robot.controller.status().queued if name in "bc"]
    assert waiting == ["c", "b"]
    refused = ada.put(f"{PLACE}/queue/99", json={"place": 1})
    assert (refused.status_code, refused.json()["error"]["kind"]) == (409, "NotReady")
    assert ada.put(f"{PLACE}/queue/99", json={"place": 0}).status_code == 422
    with viewer.websocket_connect(f"ws://127.0.0.1:8080{PLACE}/watch?rate_hz=20") as watched:
        assert watched.receive_json()["status"]["robot"] == "gripper-delta"
        assert viewer.post(f"{PLACE}/stop").status_code == 200
        until(lambda: watched.receive_json()["status"]["state"] == "stopped")
    assert "ada" in here.robot.controller.status().why


def test_another_sites_page_may_not_use_it(here: Here, ada: TestClient) -> None:
    foreign = ada.post(f"{PLACE}/acknowledge", headers={"origin": "http://evil.example"})
    assert foreign.status_code == 403
    assert here.robot.controller.status().state != "unhomed"
