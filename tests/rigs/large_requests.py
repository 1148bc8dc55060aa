"""Files of up to 4 MB that hold up whoever reads them, and how fast a daemon answers meanwhile.

The daemon is a process of its own on the simulated robot. Does not model: a slow disk.
"""

from __future__ import annotations

import contextlib
import os
import subprocess
import sys
import threading
import time
from collections.abc import Callable, Iterator
from contextlib import closing
from dataclasses import dataclass, field
from pathlib import Path

from deltactl.firmware_py.daemon.client import Client
from deltactl.firmware_py.daemon.line import Line
from deltactl.firmware_py.named_files import CONFIG_FOLDER
from deltactl.foundation.errors import DeltactlError, ServiceError

MB = 1_000_000
ROBOT_FILE = CONFIG_FOLDER / "zhao-2023.yaml"
START_S = 60.0
ANSWER_S = 120.0
"""So long the answer to a request is waited for."""
FOLLOWED_S = 20.0
"""So long a job is followed that is being planned."""
JOB = f"name: large\nrobot: {ROBOT_FILE.name}\ntiming: {{mode: together, t_pwm_s: 0.01}}\n"
JOB += "inverse_kinematics: {kind: geometry}\n"


def _filled(pattern: str, size: int) -> str:
    """A pattern with a running number, as often as it fits into `size` characters."""
    longest = len(pattern.format(n=size // max(1, len(pattern.format(n=0)))))
    return "".join(pattern.format(n=n) for n in range(size // longest))


WRONG: dict[str, Callable[[int], str]] = {
    "unknown keys": lambda size: _filled("key{n}: 1\n", size),
    "names near a key": lambda size: _filled("limit{n}: 1\n", size),
    "unknown keys in a section": lambda size: "limits:\n" + _filled("  arm_{n}: 1\n", size),
    "wrong values of a mapping": lambda size: "networks:\n" + _filled("  n{n}: 1\n", size),
    "wrong entries of a list": lambda size: "effects:\n" + _filled("- {{kind: k{n}}}\n", size),
    "lists in a list": lambda size: "effects: [" + "[1]," * (size // 4) + "]\n",
    "empty lists": lambda size: "effects: [" + "[]," * (size // 3) + "]\n",
    "nested lists": lambda size: "effects: " + "[" * size + "\n",
    "nested mappings": lambda size: "effects: " + "{a: " * (size // 4) + "\n",
    "aliases": lambda size: "a: &a [1]\n" + _filled("b{n}: *a\n", size),
    "directives": lambda size: _filled("%TAG !a{n}! x\n", size) + "---\na: 1\n",
    "one number": lambda size: "a: " + "9" * size + "\n",
    "one text": lambda size: "a: " + "x" * size + "\n",
    "one key": lambda size: "? " + "k" * size + "\n: 1\n",
    "long keys": lambda size: _filled("k" * 900 + "{n}: 1\n", size),
    "numbers that are none": lambda size: "effects: [" + ".nan," * (size // 5) + "]\n",
    "escapes": lambda size: 'a: "' + "\\x41" * (size // 4) + '"\n',
    "letters of many alphabets": lambda size: _filled("ключ{n}: значение 値 🙂\n", size // 2),
    "numbers of a million digits": lambda size: "".join(
        f"a{n}: {'7' * min(size, 1_000_000)}\n" for n in range(max(size // 1_000_000, 1))
    ),
    "one block of text": lambda size: "a: |\n" + _filled("  line {n}\n", size),
    "quoted keys": lambda size: _filled('"k {n}": "1"\n', size),
    "comments": lambda size: "#\n" * (size // 2),
    "blank lines": lambda size: "\n" * size,
}
"""What is added to a robot file or a job."""
ITEMS = {
    "numbers": "{n}",
    "texts": "x{n}",
    "lists": "[{n}]",
    "mappings": "{{a: {n}}}",
    "nothing": "",
}
"""What an entry of a list may be, and is not."""
LISTS = {
    "steps": "steps:\n",
    "inner steps": "steps:\n- repeat: 2\n  steps:\n",
    "points": "path:\n  shape: points\n  points_m:\n",
    "angles": "path:\n  shape: joints\n  angles_deg:\n",
    "legs": "path:\n  shape: way\n  legs:\n",
}
"""The lists of a job."""


def _entries(head: str, item: str) -> Callable[[int], str]:
    return lambda size: head + _filled(f"    - {item}\n", size)


JOBS: dict[str, Callable[[int], str]] = {
    "wrong poses": lambda size: (
        "path:\n  shape: joints\n  angles_deg:\n" + _filled("  - [1, x, {n}]\n", size)
    ),
    "wrong legs": lambda size: (
        "path:\n  shape: way\n  legs:\n" + _filled("  - {{to: {n}}}\n", size)
    ),
    "wrong steps": lambda size: "steps:\n" + _filled("- {{nothing: {n}}}\n", size),
    "steps that name no file": lambda size: (
        "steps:\n" + _filled("- {{include: n{n}.yaml}}\n", size)
    ),
    "steps within steps": lambda size: (
        "steps:\n- repeat: 2\n  steps:\n" + _filled("  - {{wait_s: x{n}}}\n", size)
    ),
    "outputs that are none": lambda size: "steps:\n" + _filled("- {{set: {{o{n}: on}}}}\n", size),
}
JOBS |= {
    f"{what} as {name}": _entries(head, item)
    for name, head in LISTS.items()
    for what, item in ITEMS.items()
}
"""What a job alone may have."""
VALID: dict[str, Callable[[int], str]] = {
    "poses": lambda size: (
        "path:\n  shape: joints\n  angles_deg:\n"
        + _filled("  - [10.0, 11.0, 12.{n}]\n", min(size, 2 * MB))
    ),
    "legs": lambda size: (
        "path:\n  shape: way\n  legs:\n"
        + _filled("  - {{to: [0.00{n}, 0.01, -0.45]}}\n", min(size, 3 * MB))
    ),
}
"""Jobs that are right, or nearly, and take long to plan."""


@dataclass
class Latencies:
    """The longest answers that a kind of request causes [s]."""

    answer_s: float = 0.0
    meanwhile_s: dict[str, float] = field(default_factory=dict)
    """Request -> its longest answer while the other was worked on."""
    refusal: str = ""
    planned_late: bool = False
    """Whether a job was answered before its check ended."""


@contextlib.contextmanager
def daemon(folder: Path) -> Iterator[Path]:
    """A simulated daemon, off; its socket. Raises ServiceError when it does not start."""
    socket, log = folder / "d.sock", folder / "log"
    words = [
        "service",
        "daemon",
        ROBOT_FILE,
        "--simulate",
        "--socket",
        socket,
        "--recordings",
        folder,
    ]
    with log.open("wb") as errors:
        process = subprocess.Popen(
            [sys.executable, "-m", "deltactl.cli.main", *map(str, words)],
            cwd=folder,
            env=os.environ | {"STATE_DIRECTORY": str(folder)},
            stdout=errors,
            stderr=errors,
        )
    try:
        give_up_s = time.monotonic() + START_S
        while not socket.exists():
            if process.poll() is not None or time.monotonic() > give_up_s:
                raise ServiceError(f"the daemon did not start: {log.read_text()[-500:]}")
            time.sleep(0.05)
        yield socket
    finally:
        process.terminate()
        process.wait()


def files(folder: Path, size: int) -> Iterator[tuple[str, str, Path]]:
    """Name, request (`home` or `run`) and file of each kind, one after another."""
    robot, path = ROBOT_FILE.read_text(), folder / "large.yaml"
    for name, added in WRONG.items():
        for do, text in (("home", robot), ("run", JOB)):
            written = added(size)
            whole = written + text if written.startswith("%") else text + written
            path.write_text(whole[: 4 * 2**20])
            yield name, do, path
    for name, added in (JOBS | VALID).items():
        path.write_text(JOB + added(size))
        yield name, "run", path


def measured(socket: Path, do: str, path: Path, followed_s: float = FOLLOWED_S) -> Latencies:
    """Have a daemon work on a file, and ask it for other things meanwhile."""
    found = Latencies()
    with Client(socket) as other:
        _ready(other, do)
        ended, argument = threading.Event(), "job" if do == "run" else "robot"

        def ask() -> None:
            begun_s = time.monotonic()
            with closing(Line(socket, ANSWER_S)) as line:
                try:
                    answer = line.ask({"do": do, argument: str(path)}, ANSWER_S)
                except DeltactlError as error:
                    answer = {"error": {"message": str(error)}}
                found.answer_s = max(found.answer_s, time.monotonic() - begun_s)
                found.planned_late |= bool(answer.get("planning"))
                number = answer.get("job_id")
                while answer.get("planning") and time.monotonic() < begun_s + followed_s:
                    time.sleep(0.05)
                    answer = line.ask({"do": "result", "job_id": number}, ANSWER_S)
                found.refusal = answer.get("error", {}).get("message", found.refusal)
            ended.set()

        thread = threading.Thread(target=ask)
        thread.start()
        while not ended.wait(0.02):
            _timed(found, "status", other.status)
        thread.join()
        thread = threading.Thread(target=ask)
        ended.clear()
        thread.start()
        ended.wait(0.1)
        for name, request in (
            ("stop", lambda: other.stop("measured")),
            ("acknowledge", other.acknowledge),
        ):
            _timed(found, name, request)
        thread.join()
    return found


def _timed(found: Latencies, name: str, request: Callable[[], object]) -> None:
    begun_s = time.monotonic()
    request()
    took_s = time.monotonic() - begun_s
    found.meanwhile_s[name] = max(took_s, found.meanwhile_s.get(name, 0.0))


def _ready(client: Client, do: str) -> None:
    state = client.status().state
    if state == "stopped":
        client.acknowledge()
    elif state == "off":
        client.power_on()
    if do == "run" and client.status().state != "ready":
        client.power_off()
        client.power_on()
        client.home()
