"""What docs/security.md promises and no other test holds."""

from __future__ import annotations

import ast
import os
import socket
import threading
from pathlib import Path

import pytest

from deltactl.firmware_py.daemon.address import Peer
from deltactl.firmware_py.daemon.client import Client
from deltactl.firmware_py.job_file import load_job
from deltactl.foundation.errors import ConfigError, DeltactlError, MissingFile, ServiceError

PROGRAM = Path(__file__).resolve().parents[2]
PACKAGES = ("drivers", "firmware_py", "deltactl/foundation", "models", "deltactl/recording")
CODE_FROM_DATA = {"pickle", "marshal", "shelve", "dill", "cloudpickle", "joblib"}


def test_who_may_use_the_socket() -> None:
    owner, group = 1000, 990
    assert Peer(1, owner).may_use(owner, group)
    assert Peer(1, 0).may_use(owner, group)
    assert Peer(1, 2000, frozenset({2000, group})).may_use(owner, group)
    assert not Peer(1, 2000, frozenset({2000})).may_use(owner, group)


def test_the_kernel_says_who_is_there() -> None:
    ours, theirs = socket.socketpair()
    with ours, theirs:
        peer = Peer.of(ours)
    assert (peer.pid, peer.uid) == (os.getpid(), os.getuid())
    assert os.getgid() in peer.groups
    assert set(os.getgroups()) <= peer.groups


def test_a_stranger_is_turned_away_with_a_reason(serve, monkeypatch, wait_until) -> None:
    """Whatever the mode of the socket has become."""
    daemon = serve()
    stranger = Peer(1, 4_000_000, frozenset({4_000_000}))
    monkeypatch.setattr(Peer, "of", classmethod(lambda cls, connection: stranger))
    with Client(daemon.path) as client, pytest.raises(ServiceError):
        client.power_on()
    assert daemon.controller.status().state == "off"


@pytest.mark.parametrize("load", [load_job])
def test_a_pipe_named_as_a_file_holds_nobody_up(tmp_path: Path, load) -> None:
    pipe = tmp_path / "job.yaml"
    os.mkfifo(pipe)
    said: list[BaseException] = []

    def attempt() -> None:
        try:
            load(pipe)
        except DeltactlError as error:
            said.append(error)

    thread = threading.Thread(target=attempt, daemon=True)
    thread.start()
    thread.join(30.0)
    assert isinstance(said[0], MissingFile)


def test_a_job_cannot_place_its_recording_elsewhere(tmp_path: Path) -> None:
    from deltactl.firmware_py.controller.build import build_controller
    from deltactl.firmware_py.named_files import CONFIG_FOLDER

    one = build_controller(
        CONFIG_FOLDER / "zhao-2023.yaml", simulated=True, realtime=False, recordings=tmp_path / "r"
    )
    job = tmp_path / "job.yaml"
    text = (CONFIG_FOLDER / "circle.yaml").read_text(encoding="utf-8")
    job.write_text(text + "record: ../../outside.mcap\n", encoding="utf-8")
    try:
        one.power_on()
        one.home()
        with pytest.raises(DeltactlError, match="give a plain name"):
            one.submit(job)
    finally:
        one.close()
    assert not list(tmp_path.rglob("*.mcap"))


def _calls_and_imports() -> list[tuple[Path, int, str]]:
    found = []
    for package in PACKAGES:
        for path in sorted((PROGRAM / package).rglob("*.py")):
            for node in ast.walk(ast.parse(path.read_text(encoding="utf-8"))):
                if isinstance(node, ast.Import):
                    found += [(path, node.lineno, alias.name) for alias in node.names]
                elif isinstance(node, ast.ImportFrom):
                    found.append((path, node.lineno, node.module or ""))
                elif isinstance(node, ast.Call):
                    found.append((path, node.lineno, ast.unparse(node.func)))
    return found


def test_nothing_read_is_ever_run() -> None:
    forbidden = CODE_FROM_DATA | {"eval", "exec", "os.system", "yaml.load", "yaml.unsafe_load"}
    bad = [
        f"{path.relative_to(PROGRAM)}:{line}: {name}"
        for path, line, name in _calls_and_imports()
        if name in forbidden or name.split(".")[0] in CODE_FROM_DATA
    ]
    assert bad == []


@pytest.mark.parametrize("text", ["a: !!python/object/apply:os.system [id]\n", "a: &x 1\nb: *x\n"])
def test_yaml_is_data(tmp_path: Path, text: str) -> None:
    path = tmp_path / "job.yaml"
    path.write_text(text, encoding="utf-8")
    with pytest.raises(ConfigError, match="are not taken"):
        load_job(path)
