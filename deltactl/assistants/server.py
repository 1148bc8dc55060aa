"""The server: tools and resources of the Model Context Protocol over standard input and output.

It answers while workers are at work; a call that is cancelled ends its worker at once.
"""

from __future__ import annotations

import asyncio
import json
import os
import signal
import string
from collections import OrderedDict
from collections.abc import Callable
from pathlib import Path
from typing import Any

import anyio
import mcp_types as types
from mcp.server import Server
from mcp.server.context import ServerRequestContext
from mcp.server.stdio import stdio_server
from mcp.shared.exceptions import MCPError
from pydantic import ValidationError

from deltactl.assistants.allowed import inside, robot_file
from deltactl.assistants.answers import (
    of_diagnosis,
    of_finding,
    of_inspection,
    of_next_run,
    resource,
)
from deltactl.assistants.refused import Refused, refused, refused_arguments
from deltactl.assistants.tools import TOOLS, Call, Diagnose, Explain, Inspect, NextRun, described
from deltactl.foundation.errors import ConfigError, ServiceError
from deltactl.foundation.release import own_version
from deltactl.web.behind.tasks import Tasks

KEPT = 50
"""Answers of each kind whose JSON is kept, some 10 kB each; the oldest goes first."""
CLEANING_UP_S = 0.5
"""In which calls that are called off end their workers."""
WORKER = "deltactl.assistants.worker"
JSON = "application/json"
READ_ONLY = types.ToolAnnotations(
    read_only_hint=True, destructive_hint=False, idempotent_hint=True, open_world_hint=False
)
INSTRUCTIONS = (
    "Finds out where recordings of a robot or an axis differ from its model. Call inspect on a"
    " table, then diagnose; explain and next_run go on from a diagnosis. Files are named by their"
    " place below the root. Quote sizes with unit, interval and probability; report what else could"
    " be the cause. Nothing is written, nothing moves."
)
Context = ServerRequestContext[Any, Any]
Answer = tuple[str, dict[str, Any]]
WORK: dict[type[Call], tuple[str, str, Callable[[str, dict[str, Any]], Answer]]] = {
    Inspect: ("inspect", "inspections", of_inspection),
    Diagnose: ("diagnose", "diagnoses", of_diagnosis),
}
"""What a worker does for a call, where its JSON is kept, and what words it."""


class Shelf:
    """JSON of the answers of one kind, by names without digits, which are never given again."""

    def __init__(self) -> None:
        self._held: OrderedDict[str, dict[str, Any]] = OrderedDict()
        self._number = 0

    def keep(self, made: dict[str, Any]) -> str:
        """Keep an answer; returns its name."""
        self._number += 1
        name, left = "", self._number
        while left:
            left, letter = divmod(left - 1, 26)
            name = string.ascii_lowercase[letter] + name
        self._held[name] = made
        while len(self._held) > KEPT:
            self._held.popitem(last=False)
        return name

    def get(self, name: str) -> dict[str, Any] | None:
        """An answer; None where there is none of this name any more."""
        return self._held.get(name)

    @property
    def names(self) -> list[str]:
        """Those that are kept, the oldest first."""
        return list(self._held)


class Progress:
    """Hands what a worker says on to who called, if that asked for it."""

    def __init__(self, context: Context) -> None:
        self._context, self._said = context, 0
        self._sent: list[asyncio.Future[None]] = []

    def __call__(self, text: str) -> None:
        self._said += 1
        report = self._context.session.report_progress(self._said, None, text)
        self._sent.append(asyncio.ensure_future(report))

    async def sent(self) -> None:
        """Wait until all has been sent, as nothing may follow the answer."""
        await asyncio.gather(*self._sent, return_exceptions=True)


class Assistance:
    """What the tools do; files are sought below `root`."""

    def __init__(self, root: Path, tasks: Tasks | None = None) -> None:
        self._root = root.resolve()
        self._tasks = tasks or Tasks(worker=WORKER)
        self.shelves = {"inspections": Shelf(), "diagnoses": Shelf()}

    async def answer(self, call: Call, progress: Callable[[str], None]) -> Answer | Refused:
        """The answer of a call, or why there is none."""
        if isinstance(call, Explain | NextRun):
            return self._of_kept(call)
        work, kind, worded = WORK[type(call)]
        made = await self._work(work, call, progress)
        if isinstance(made, Refused):
            return made
        return worded(self.shelves[kind].keep(made), made)

    def _of_kept(self, call: Explain | NextRun) -> Answer | Refused:
        name, shelf = call.diagnosis, self.shelves["diagnoses"]
        made = shelf.get(name)
        if made is None:
            why = f"there is no diagnosis {name} here; there are {_listed(shelf.names)}"
            return Refused(
                "unknown_name", why, "call diagnose, which names its answer", "diagnosis"
            )
        if isinstance(call, NextRun):
            return of_next_run(name, made)
        found = len(made["json"]["findings"])
        if call.finding > found:
            why = (
                f"diagnosis {name} has {found or 'no'} findings, and none is number {call.finding}"
            )
            do = (
                "give a number of its answer"
                if found
                else "call next_run for what it could not see"
            )
            return Refused("unknown_name", why, do, "finding")
        return of_finding(name, made, call.finding)

    async def _work(
        self, kind: str, call: Call, progress: Callable[[str], None]
    ) -> dict[str, Any] | Refused:
        try:
            self._look_at_names(call)
        except ConfigError as error:
            return refused(error, "path")
        request = json.dumps({"root": str(self._root)} | call.model_dump())
        try:
            made = await self._tasks.run(kind, request, progress=progress)
        except ServiceError as error:
            return refused(error, "not_finished")
        return Refused(**made["refused"]) if "refused" in made else made

    def _look_at_names(self, call: Call) -> None:
        """Refuse at once what the worker would. Raises ForbiddenPath or MissingFile."""
        match call:
            case Inspect():
                inside(self._root, call.recording)
            case Diagnose():
                for named in (*call.recordings, *call.holdout):
                    inside(self._root, named)
                if call.robot is not None:
                    robot_file(self._root, call.robot)


def server(root: Path, tasks: Tasks | None = None) -> Server[Any]:
    """The server for files below a folder. tasks: another way to do the work, for tests."""
    assistance = Assistance(root, tasks)

    async def list_tools(
        context: Context, params: types.PaginatedRequestParams | None
    ) -> types.ListToolsResult:
        return types.ListToolsResult(
            tools=[types.Tool(**one, annotations=READ_ONLY) for one in described()]
        )

    async def call_tool(
        context: Context, params: types.CallToolRequestParams
    ) -> types.CallToolResult:
        wanted = TOOLS.get(params.name)
        if wanted is None:
            why = f"there is no tool {params.name[:50]!r}; there are {_listed(list(TOOLS))}"
            return _result(Refused("unknown_name", why, "call one of them"))
        try:
            call = wanted.model_validate(params.arguments or {})
        except ValidationError as error:
            return _result(refused_arguments(params.name, error, wanted.model_fields))
        progress = Progress(context)
        made = await assistance.answer(call, progress)
        await progress.sent()
        return _result(made)

    async def list_resources(
        context: Context, params: types.PaginatedRequestParams | None
    ) -> types.ListResourcesResult:
        held = [(kind, name) for kind, shelf in assistance.shelves.items() for name in shelf.names]
        return types.ListResourcesResult(
            resources=[
                types.Resource(name=f"{kind} {name}", uri=resource(kind, name), mime_type=JSON)
                for kind, name in held
            ]
        )

    async def read_resource(
        context: Context, params: types.ReadResourceRequestParams
    ) -> types.ReadResourceResult:
        uri = str(params.uri)
        kind, _, name = uri.removeprefix("deltactl://").partition("/")
        made = assistance.shelves[kind].get(name) if kind in assistance.shelves else None
        if made is None:
            raise MCPError(types.INVALID_PARAMS, f"{uri[:100]}: no such answer is kept here")
        text = json.dumps(made["json"])
        return types.ReadResourceResult(
            contents=[types.TextResourceContents(uri=uri, text=text, mime_type=JSON)]
        )

    return Server(
        "deltactl",
        version=own_version(),
        instructions=INSTRUCTIONS,
        on_list_tools=list_tools,
        on_call_tool=call_tool,
        on_list_resources=list_resources,
        on_read_resource=read_resource,
    )


def serve(root: Path) -> None:
    """Answer on standard input and output until the input ends, or a signal ends the process."""

    async def answering() -> None:
        made = server(root)
        with anyio.CancelScope() as scope:
            loop = asyncio.get_running_loop()
            for number in (signal.SIGINT, signal.SIGTERM):
                loop.add_signal_handler(number, _end, scope, number)
            async with stdio_server() as (incoming, outgoing):
                await made.run(incoming, outgoing, made.create_initialization_options())

    anyio.run(answering)


def _end(scope: anyio.CancelScope, number: int) -> None:
    """End the workers, and then the process: a thread that waits for input would keep it."""
    scope.cancel()
    asyncio.get_running_loop().call_later(CLEANING_UP_S, os._exit, 128 + number)


def _result(made: Answer | Refused) -> types.CallToolResult:
    if isinstance(made, Refused):
        text, structured = made.text, made.to_json()
    else:
        text, structured = made
    return types.CallToolResult(
        content=[types.TextContent(type="text", text=text)],
        structured_content=structured,
        is_error=isinstance(made, Refused),
    )


def _listed(names: list[str]) -> str:
    return ", ".join(names[-20:]) or "none"
