"""Calls of the tools as an assistant makes them, and the numbers of what comes back."""

from __future__ import annotations

import json
import os
import re
from collections.abc import Awaitable, Callable, Sequence
from contextlib import chdir
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import anyio
import numpy as np
from mcp import Client

from deltactl.assistants.server import server
from deltactl.assistants.worker import result
from deltactl.web.behind.tasks import Tasks

NUMBER = re.compile(r"-?\d+(?:\.\d+)?(?:e[-+]?\d+)?")
SLIDE = "{kind: servo_axis, name: slide, motion: linear}"
Call = tuple[str, dict[str, Any]]


@dataclass(frozen=True)
class Answered:
    """What a call brought."""

    call: Call
    text: str
    structured: dict[str, Any]
    refused: bool
    json: Any
    """The JSON of the inspection or diagnosis that the answer is of."""

    @property
    def tokens(self) -> float:
        """A third of the bytes of all that an assistant is sent."""
        return len((self.text + json.dumps(self.structured)).encode()) / 3.0

    @property
    def invented(self) -> list[str]:
        """Numbers of the answer that the JSON does not have, as it is or with six figures."""
        there = {float(one) for one in NUMBER.findall(json.dumps(self.json))}
        there |= {float(f"{value:.6g}") for value in there}
        there |= {-value for value in there}  # a dash in front is no sign
        given = NUMBER.findall(self.text) + NUMBER.findall(json.dumps(self.structured))
        return [one for one in given if float(one) not in there]


async def answered(client: Client, call: Call) -> Answered:
    """Call a tool, and read the JSON of its answer."""
    name, arguments = call
    result = await client.call_tool(name, arguments)
    (block,) = result.content
    structured = dict(result.structured_content)
    kinds = {"inspection": "inspections", "diagnosis": "diagnoses"}
    uri = next(
        (f"deltactl://{kinds[one]}/{structured[one]}" for one in kinds if one in structured), ""
    )
    text = (await client.read_resource(uri)).contents[0].text if uri else "null"
    return Answered(call, block.text, structured, bool(result.is_error), json.loads(text))


class Here(Tasks):
    """Works in this process, which stays free to open files; `test_server.py` has the workers."""

    async def run(self, kind: str, *words: str | Path, **_: Any) -> dict[str, Any]:
        def work() -> dict[str, Any]:
            with chdir(os.curdir):
                made = result(kind, json.loads(str(words[0])), hold=lambda root: None)
            return dict(json.loads(json.dumps(made, default=str)))

        return await anyio.to_thread.run_sync(work)


def with_client(root: Path, work: Callable[[Client], Awaitable[Any]]) -> Any:
    """Do some work with a client of a server for this folder."""

    async def working() -> Any:
        async with Client(server(root, Here())) as client:
            return await work(client)

    return anyio.run(working)


def all_answered(root: Path, calls: Sequence[Call]) -> list[Answered]:
    """The answers of calls, one after the other on one connection."""

    async def calling(client: Client) -> list[Answered]:
        return [await answered(client, call) for call in calls]

    made: list[Answered] = with_client(root, calling)
    return made


def write_slide(path: Path, seed: int, scale: float = 1.02, lag_s: float = 0.0) -> None:
    """A slide whose reading is larger than its command or late, in columns with other names."""
    t_s = np.arange(0.0, 20.0, 0.02)

    def asked_mm(at_s: np.ndarray) -> np.ndarray:
        return 40.0 * np.sin(0.8 * at_s) + 15.0 * np.sin(2.1 * at_s + seed)

    noise_mm = np.random.default_rng(seed).normal(0.0, 0.01, len(t_s))
    rows = np.column_stack([t_s, asked_mm(t_s), scale * asked_mm(t_s - lag_s) + noise_mm])
    np.savetxt(path, rows, "%.6g", ",", header="time_s,target,seen", comments="")


COLUMNS = ["t=time_s[s]", "command=target[mm]", "position=seen[mm]"]


def diagnose(*recordings: str, **more: Any) -> Call:
    """A diagnosis of tables of the slide."""
    return "diagnose", {"recordings": recordings, "robot_text": SLIDE, "columns": COLUMNS} | more
