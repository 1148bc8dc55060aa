"""`deltactl mcp` as a process: it answers while it works, can be called off, and only reads."""

from __future__ import annotations

import json
import os
import signal
import subprocess
import sys
import time
from collections.abc import Awaitable, Callable
from pathlib import Path
from typing import Any

import anyio
import numpy as np
import pytest
from mcp import Client, StdioServerParameters
from mcp.client.stdio import stdio_client

from deltactl.foundation.process import importable
from tests.assistants.calls import SLIDE, diagnose

WORKER = "deltactl.assistants.worker"
SOON_S = 60.0
"""Far more than ending a process takes, on a machine that others use too."""
LONG = {"recordings": ["mixed.csv"], "robot_text": SLIDE}
"""A diagnosis that takes some ten seconds, as the reading has nothing to do with the command."""


def started(root: Path) -> StdioServerParameters:
    """The command that an assistant starts."""
    command = ["-m", "deltactl.cli.main", "mcp", "--root", str(root)]
    environment = importable({"PATH": os.environ["PATH"], "PYTHONWARNINGS": "default"})
    return StdioServerParameters(command=sys.executable, args=command, env=environment)


def with_server(root: Path, work: Callable[[Client], Awaitable[Any]]) -> Any:
    """Do some work with a client of that process."""

    async def working() -> Any:
        async with Client(stdio_client(started(root))) as client:
            return await work(client)

    return anyio.run(working)


def workers(root: Path) -> list[int]:
    """Processes that work for a server with this root."""
    found = []
    for process in Path("/proc").glob("[0-9]*"):
        try:
            words = (process / "cmdline").read_bytes().split(b"\0")
        except OSError:
            continue
        if WORKER.encode() in words and any(str(root).encode() in word for word in words):
            found.append(int(process.name))
    return found


def none_left(root: Path) -> bool:
    """Whether all workers end soon."""
    end_s = time.monotonic() + SOON_S
    while workers(root) and time.monotonic() < end_s:
        time.sleep(0.05)
    return workers(root) == []


@pytest.fixture(scope="module")
def long_root(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A folder with that recording."""
    folder = tmp_path_factory.mktemp("long")
    t_s = np.arange(1000) / 50.0
    command = np.sin(t_s)
    rows = np.column_stack([t_s, command, np.random.default_rng(0).permutation(command)])
    np.savetxt(folder / "mixed.csv", rows, "%.6g", ",", header="t,command,position", comments="")
    return folder


@pytest.mark.study
def test_it_answers_while_a_diagnosis_runs_and_ends_one_that_is_cancelled(long_root: Path) -> None:
    heard: list[str] = []

    async def listen(progress: float, total: float | None, message: str | None) -> None:
        heard.append(message or "")

    async def calling(client: Client) -> None:
        scope = anyio.CancelScope()

        async def long() -> None:
            with scope:
                await client.call_tool("diagnose", LONG, progress_callback=listen)
                heard.append("the end")

        async with anyio.create_task_group() as group:
            group.start_soon(long)
            with anyio.fail_after(SOON_S):
                while not heard:
                    await anyio.sleep(0.02)
            seen = await client.call_tool("inspect", {"recording": "mixed.csv"})
            assert seen.structured_content["kind"] == "servo_axis"
            assert "the end" not in heard
            scope.cancel()
        assert await anyio.to_thread.run_sync(none_left, long_root)
        refused = await client.call_tool("next_run", {"diagnosis": "a"})
        assert refused.structured_content["refused"]["kind"] == "unknown_name"

    with_server(long_root, calling)
    assert "the end" not in heard


@pytest.mark.study
def test_an_assistant_that_goes_away_leaves_no_worker(long_root: Path) -> None:
    async def leaving(client: Client) -> None:
        async with anyio.create_task_group() as group:
            group.start_soon(client.call_tool, "diagnose", LONG)
            with anyio.fail_after(SOON_S):
                while not workers(long_root):
                    await anyio.sleep(0.02)
            group.cancel_scope.cancel()

    with_server(long_root, leaving)
    assert none_left(long_root)


def lines(*messages: dict[str, Any]) -> str:
    """Messages as an assistant writes them."""
    return "".join(json.dumps({"jsonrpc": "2.0"} | one) + "\n" for one in messages)


@pytest.mark.study
@pytest.mark.parametrize("number", [signal.SIGINT, signal.SIGTERM])
def test_a_signal_ends_it_and_its_workers(long_root: Path, number: int) -> None:
    client = {"name": "test", "version": "1"}
    opening = {"protocolVersion": "2025-06-18", "capabilities": {}, "clientInfo": client}
    asked = {"name": "diagnose", "arguments": LONG}
    how = started(long_root)
    with subprocess.Popen(
        [how.command, *how.args], env=how.env, text=True,
        stdin=subprocess.PIPE, stdout=subprocess.PIPE, stderr=subprocess.PIPE,
    ) as process:  # fmt: skip
        assert process.stdin is not None
        process.stdin.write(lines(
            {"id": 1, "method": "initialize", "params": opening},
            {"method": "notifications/initialized"},
            {"id": 2, "method": "tools/call", "params": asked},
        ))  # fmt: skip
        process.stdin.flush()
        end_s = time.monotonic() + SOON_S
        while not workers(long_root) and time.monotonic() < end_s:
            time.sleep(0.05)
        assert workers(long_root)
        process.send_signal(number)
        assert process.wait(SOON_S) == 128 + number
        assert none_left(long_root)
        assert "Traceback" not in process.stderr.read()


@pytest.mark.study
def test_the_tools_only_read_and_leave_the_folder_as_it_was(root: Path) -> None:
    def files() -> dict[Path, tuple[int, int]]:
        return {one: (one.stat().st_mtime_ns, one.stat().st_size) for one in root.rglob("*")}

    before = files()

    async def calling(client: Client) -> None:
        listed = (await client.list_tools()).tools
        assert {one.name for one in listed} == {"inspect", "diagnose", "explain", "next_run"}
        assert all(one.annotations.read_only_hint for one in listed)
        assert all(one.input_schema["additionalProperties"] is False for one in listed)
        name, arguments = diagnose("slide.csv")
        made = await client.call_tool(name, arguments)
        assert not made.is_error, made.content
        (kept,) = (await client.list_resources()).resources
        (text,) = (await client.read_resource(str(kept.uri))).contents
        assert json.loads(text.text)["verdict"] == "explained"

    with_server(root, calling)
    assert files() == before


GUARDED = """
import sys
from pathlib import Path
from deltactl.assistants.allowed import read_only
read_only(Path(sys.argv[1]))
for path, mode in [line.split() for line in sys.stdin]:
    try:
        open(path, mode).close()
        print("opened")
    except Exception as error:
        print(type(error).__name__)
"""


def test_a_worker_opens_no_file_elsewhere_and_writes_none(root: Path) -> None:
    asked = {
        "slide.csv r": "opened",
        "link.csv r": "ForbiddenPath",
        "../secret.csv r": "ForbiddenPath",
        "elsewhere/secret.csv rb": "ForbiddenPath",
        "/etc/passwd r": "ForbiddenPath",
        "slide.csv a": "ForbiddenPath",
        "new.csv w": "ForbiddenPath",
        "/dev/null w": "opened",
    }
    done = subprocess.run(
        [sys.executable, "-c", GUARDED, str(root)],
        input="\n".join(asked), capture_output=True, text=True, cwd=root, check=True,
        env=importable(dict(os.environ)),
    )  # fmt: skip
    assert dict(zip(asked, done.stdout.split(), strict=True)) == asked


@pytest.mark.study
def test_without_the_package_one_line_says_how_to_install_it() -> None:
    absent = "import sys; sys.modules['mcp'] = None; from deltactl.cli.main import main; main()"
    done = subprocess.run(
        [sys.executable, "-c", absent, "mcp"], capture_output=True, text=True, check=False
    )
    (line,) = done.stderr.splitlines()
    assert done.returncode == 2
    assert line.startswith("deltactl: mcp needs mcp")
    assert "mcp" in line.partition("type: ")[2]
