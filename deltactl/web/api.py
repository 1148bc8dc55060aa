"""The interface for programs: HTTP and one WebSocket under /api/v1, described by OpenAPI.

It asks the same site as the page, behind the same guard: whoever may not move the robot on the page
may not move it here. A request carries the page's cookie or a token; docs/service.md shows it.
"""

from __future__ import annotations

import asyncio
from collections.abc import Callable
from dataclasses import asdict
from functools import partial
from typing import Annotated, Any, Final, TypeVar

from fastapi import FastAPI, Query, Request, WebSocket
from fastapi.exceptions import RequestValidationError
from pydantic import BaseModel, Field
from starlette.exceptions import HTTPException
from starlette.responses import FileResponse, JSONResponse, Response
from starlette.websockets import WebSocketDisconnect

from deltactl.firmware_py.daemon.protocol import encode
from deltactl.firmware_py.wire_errors import as_message
from deltactl.foundation.errors import ConfigError, DeltactlError, NotReady, ServiceError
from deltactl.web.access.users import asking, operates
from deltactl.web.behind.link import RATE_HZ
from deltactl.web.behind.own_jobs import MAX_CHARACTERS
from deltactl.web.behind.shelf import Listed
from deltactl.web.behind.site import Site
from deltactl.web.behind.texts import kind_of, mistakes, of_another_robot

PLACE: Final = "/api/v1"
LOOKS: Final = "your token or session may look and stop, and nothing else"
ABOUT: Final = """Runs the robot that the page shows. `Authorization: Bearer TOKEN`, with a token
made in the page's menu behind your name; where nobody signs in, none is needed. Lengths are metres,
times seconds. A refusal is `{"error": {"kind", "message"}}`."""
CODES: Final = {NotReady: 409, ServiceError: 503}
AnswerT = TypeVar("AnswerT")
Name = Annotated[str, Field(min_length=1, max_length=200)]
Text = Annotated[str, Field(min_length=1, max_length=MAX_CHARACTERS)]


class JobText(BaseModel):
    """A job as YAML."""

    text: Text


class Named(BaseModel):
    """A new name."""

    name: Name


class Run(BaseModel):
    """A job to run: the name of one that is kept or shipped, or a text with a name of its own."""

    name: Name
    text: Text | None = None


class Place(BaseModel):
    """A place in the queue; 1 is the next to run."""

    place: Annotated[int, Field(ge=1, le=100)]


class Reason(BaseModel):
    """Why the robot is stopped, for the log."""

    reason: Annotated[str, Field(min_length=1, max_length=150)] = "stopped by a program"


def make_api(site: Site) -> FastAPI:
    """The application to be mounted at PLACE."""
    api = FastAPI(title="deltactl", version="1", description=ABOUT, docs_url=None, redoc_url=None)
    api.add_exception_handler(DeltactlError, _refused)
    api.add_exception_handler(HTTPException, _not_so)
    api.add_exception_handler(RequestValidationError, _no_request)
    _robot(api, site)
    _queue(api, site)
    _jobs(api, site)
    _recordings(api, site)
    return api


def _refused(_: Request, error: Exception) -> Response:
    status = next((code for kind, code in CODES.items() if isinstance(error, kind)), 400)
    return JSONResponse({"error": as_message(error)}, status)


def _not_so(_: Request, error: Exception) -> Response:
    assert isinstance(error, HTTPException)
    kind = "Forbidden" if error.status_code == 403 else "NotFound"
    return JSONResponse({"error": {"kind": kind, "message": error.detail}}, error.status_code)


def _no_request(_: Request, error: Exception) -> Response:
    assert isinstance(error, RequestValidationError)
    says = "; ".join(
        f"{'.'.join(map(str, wrong['loc']))}: {wrong['msg']}" for wrong in error.errors()
    )
    return JSONResponse({"error": {"kind": "ConfigError", "message": says}}, 422)


def _operating(call: Callable[..., AnswerT], *arguments: Any) -> AnswerT:
    """Do what only an operator may. Raises HTTPException, and what is raised."""
    if not operates():
        raise HTTPException(403, LOOKS)
    return call(*arguments)


def _ask(site: Site, name: str, *arguments: Any) -> dict[str, Any]:
    """The daemon's answer to a request of an operator."""

    def call() -> dict[str, Any]:
        with site.link.client() as client:
            answer = getattr(client, name)(*arguments)
        return {} if answer is None else asdict(answer)

    return _operating(call)


def _robot(api: FastAPI, site: Site) -> None:
    ask = partial(_ask, site)

    @api.get("/status", tags=["robot"])
    def status() -> dict[str, Any]:
        """The newest status, as `deltactl status --json` prints it."""
        seen = site.link.seen
        if seen.status is None:
            raise ServiceError(seen.problem)
        return seen.status.as_json()

    @api.websocket("/watch")
    async def watch(websocket: WebSocket, rate_hz: float = 5.0) -> None:
        """Statuses, `rate_hz` a second at most; what comes in is not read."""
        await websocket.accept()
        period_s = 1.0 / min(max(rate_hz, 0.1), RATE_HZ)
        sent = -1
        try:
            while asking() is not None:
                seen = site.link.seen
                if seen.serial != sent:
                    sent = seen.serial
                    now = None if seen.status is None else seen.status.as_json()
                    line = encode({"status": now, "problem": seen.problem})
                    await websocket.send_text(line.decode().rstrip())
                await asyncio.sleep(period_s)
            await websocket.close(1008)
        except (WebSocketDisconnect, RuntimeError):
            return

    @api.post("/on", tags=["robot"])
    def on() -> dict[str, Any]:
        """Switch the drives on."""
        return ask("power_on")

    @api.post("/off", tags=["robot"])
    def off() -> dict[str, Any]:
        """Release the drives; the arms may drop."""
        return ask("power_off")

    @api.post("/home", tags=["robot"])
    def home() -> dict[str, Any]:
        """Learn where the arms are; answered when that is done."""
        return ask("home")

    @api.post("/pause", tags=["robot"])
    def pause() -> dict[str, Any]:
        """Slow down to rest on the path."""
        return ask("pause")

    @api.post("/resume", tags=["robot"])
    def resume() -> dict[str, Any]:
        """Go on along the path."""
        return ask("resume")

    @api.post("/acknowledge", tags=["robot"])
    def acknowledge() -> dict[str, Any]:
        """Clear a stop or fault whose cause is gone."""
        return ask("acknowledge")

    @api.post("/stop", tags=["robot"])
    def stop(reason: Reason | None = None) -> dict[str, Any]:
        """Emergency stop. Everybody may, as on the page."""
        session = asking()
        by = f" ({session.name})" if session is not None and session.name else ""
        site.link.stop(f"{(reason or Reason()).reason}{by}")
        return {}

    @api.get("/log", tags=["robot"])
    def log(after: Annotated[int, Query(ge=0)] = 0) -> list[dict[str, Any]]:
        """Lines of the daemon's log behind a number."""
        return site.log(after)


def _queue(api: FastAPI, site: Site) -> None:
    ask = partial(_ask, site)

    @api.get("/queue", tags=["queue"])
    def queue() -> list[dict[str, Any]]:
        """Jobs that wait, in the order in which they will run."""
        now = site.link.seen.status
        waiting = () if now is None else zip(now.queued_ids, now.queued, strict=False)
        return [{"job_id": number, "name": name} for number, name in waiting]

    @api.post("/queue", tags=["queue"])
    def run(job: Run) -> dict[str, Any]:
        """Check a job and queue it; the answer has its number."""

        def call() -> dict[str, Any]:
            text = job.text or _text_of(site, job.name)
            if kind_of(text) != "job":
                raise ConfigError(f"{job.name}: is a robot file, and no job")
            if another := of_another_robot(site, job.name, text):
                raise ConfigError(another)
            return {"job_id": site.link.submit_text(text, job.name)}

        return _operating(call)

    @api.put("/queue/{job_id}", tags=["queue"])
    def move(job_id: int, place: Place) -> dict[str, Any]:
        """Give a job that waits another place."""
        return ask("move", job_id, place.place)

    @api.delete("/queue/{job_id}", tags=["queue"])
    def cancel(job_id: int) -> dict[str, Any]:
        """End a job that waits or runs."""
        return ask("cancel", job_id)

    @api.get("/history", tags=["queue"])
    def history() -> list[dict[str, Any]]:
        """How jobs ended, the newest first."""
        return [asdict(ended) for ended in site.history.newest_first()]


def _text_of(site: Site, name: str) -> str:
    path = site.files().get(name)
    if path is None:
        raise ConfigError(f"{name}: there is no such job; give its 'text'")
    return path.read_text(encoding="utf-8")


def _jobs(api: FastAPI, site: Site) -> None:
    @api.get("/jobs", tags=["jobs"])
    def names() -> list[dict[str, Any]]:
        """Job and robot files; those that are `own` can be changed."""
        own = site.jobs.files()
        return [{"name": name, "own": name in own} for name in site.files()]

    @api.get("/jobs/{name}", tags=["jobs"])
    def text(name: str) -> dict[str, str]:
        """The text of one."""
        return {"name": name, "text": _text_of(site, name)}

    @api.put("/jobs/{name}", tags=["jobs"])
    def save(name: str, job: JobText) -> dict[str, str]:
        """Keep a job under a name."""
        return {"name": _operating(site.jobs.save, name, job.text)}

    @api.patch("/jobs/{name}", tags=["jobs"])
    def rename(name: str, wanted: Named) -> dict[str, str]:
        """Another name."""
        return {"name": _operating(site.jobs.rename, name, wanted.name)}

    @api.delete("/jobs/{name}", tags=["jobs"])
    def delete(name: str) -> dict[str, str]:
        """Forget one."""
        _operating(site.jobs.delete, name)
        return {}

    @api.post("/check", tags=["jobs"])
    def check(job: JobText) -> list[dict[str, Any]]:
        """Mistakes of a job by itself, with their lines; an empty list where there is none."""
        return [asdict(mistake) for mistake in mistakes(job.text, "job.yaml")]


def _recordings(api: FastAPI, site: Site) -> None:
    def known(key: str) -> Listed:
        found = next((one for one in site.listed() if one.made.name == key), None)
        if found is None or found.parts:
            raise ConfigError("there is no such recording; ask for the list")
        return found

    @api.get("/recordings", tags=["recordings"])
    def listed() -> list[dict[str, Any]]:
        """Recordings of this robot and those that were sent, the newest first."""
        return [
            {
                "id": one.made.name,
                "title": one.title,
                "job": one.job,
                "bytes": one.size_bytes,
                "written_s": one.written_s,
                "diagnosis": one.diagnosis,
            }
            for one in site.listed()
            if not one.parts
        ]

    @api.get("/recordings/{key}/file", tags=["recordings"])
    def file(key: str) -> Response:
        """The file itself."""
        one = known(key)
        name = one.own or one.path.name
        return FileResponse(one.path, filename=name, media_type="application/octet-stream")

    @api.patch("/recordings/{key}", tags=["recordings"])
    def rename(key: str, wanted: Named) -> dict[str, str]:
        """Another name."""
        _operating(site.rename, known(key), wanted.name)
        return {}

    @api.delete("/recordings/{key}", tags=["recordings"])
    def delete(key: str) -> dict[str, str]:
        """Delete one, and what was made of it."""
        _operating(site.delete, known(key))
        return {}

    @api.post("/recordings/{key}/diagnose", tags=["recordings"])
    async def diagnose(key: str) -> dict[str, Any]:
        """Diagnose one; seconds, at most minutes."""
        one = known(key)
        return await site.diagnose(one)
