"""The words of the socket: one JSON object a line, each way. docs/service.md shows them.

A request is {"id": 1, "do": "run", "job": "/abs/circle.yaml"}; its answer carries the same id
and is {"id": 1, "ok": true, ...} or {"id": 1, "ok": false, "error": {"kind", "message"}}.
Answers may come in another order than their requests: a stop never waits for a home.
"""

from __future__ import annotations

import difflib
import json
import math
from dataclasses import dataclass, fields
from typing import Any, Final, TypeVar

from deltactl.firmware_py.controller.contract import JobResult, SensorStatus, Status
from deltactl.foundation.errors import ServiceError
from deltactl.foundation.printable import is_printable

VERSION: Final = 1
MAX_LINE_BYTES: Final = 65_536
MAX_WATCH_HZ: Final = 20.0
MAX_TEXT: Final = 60_000
MAX_WORDS: Final = 4096

Message = dict[str, Any]
RequestId = int | str | None
MadeT = TypeVar("MadeT")


@dataclass(frozen=True, slots=True)
class Argument:
    """One argument of a request: its type, and bounds (length of a text, size of a number)."""

    type: type
    most: float
    least: float = 0.0


_PATH = Argument(str, MAX_WORDS, 1)
_TEXT = Argument(str, MAX_TEXT, 1)

ARGUMENTS: Final[dict[str, dict[str, Argument]]] = {
    "ping": {},
    "version": {},
    "on": {},
    "off": {},
    "home": {
        "accept_unseen_deg": Argument(float, 360.0),
        "robot": _PATH,
        "robot_text": _TEXT,
        "name": _PATH,
        "trial": Argument(bool, 1),
    },
    "run": {
        "job": _PATH,
        "job_text": _TEXT,
        "name": _PATH,
        "record": _PATH,
        "detach": Argument(bool, 1),
    },
    "pause": {},
    "resume": {},
    "cancel": {"job_id": Argument(int, 1e15)},
    "stop": {"reason": Argument(str, 200, 1)},
    "acknowledge": {},
    "status": {},
    "sensors": {},
    "watch": {"rate_hz": Argument(float, MAX_WATCH_HZ, 0.01)},
    "result": {"job_id": Argument(int, 1e15)},
    "rename": {"recording": _PATH, "name": _PATH},
    "delete": {"recording": _PATH},
    "move": {"job_id": Argument(int, 1e15), "place": Argument(int, 100, 1)},
    "log": {"after": Argument(int, 1e15)},
}
"""What can be asked for, and with which arguments."""

SLOW: Final = frozenset({"on", "home", "run", "acknowledge"})
"""These wait for hardware or check a whole path; they are carried out one after another."""

MOVING: Final = frozenset({"home", "run"})
"""Those that a `cancel` calls off."""


@dataclass(frozen=True, slots=True)
class Request:
    """A request whose shape has been checked."""

    id: RequestId
    do: str
    arguments: Message

    def text(self, name: str, default: str | None = None) -> str | None:
        """A text argument, or the default when it was not given."""
        return self.arguments.get(name, default)


class BadRequest(Exception):
    """A line that is no request; `id` is given back where it could be read."""

    def __init__(self, message: str, request_id: RequestId = None):
        super().__init__(message)
        self.id = request_id

    @property
    def answer(self) -> Message:
        """The refusal that the client receives."""
        return refusal(self.id, {"kind": ServiceError.__name__, "message": str(self)})


def parse(line: bytes | None) -> Request:
    """Check one line; None is a line that was too long. Raises BadRequest."""
    if line is None:
        raise BadRequest(f"a request may have {MAX_LINE_BYTES // 1024} kB at most; send a path")
    try:
        message = json.loads(line)
    except (ValueError, RecursionError):
        raise BadRequest("a request must be one JSON object a line; this line is not") from None
    if not isinstance(message, dict):
        raise BadRequest('a request must be a JSON object such as {"id": 1, "do": "status"}')
    request_id = _id(message.pop("id", None))
    do = message.pop("do", None)
    if not isinstance(do, str) or do not in ARGUMENTS:
        raise BadRequest(f"'do' cannot be {_shown(do)}{_nearest(do, list(ARGUMENTS))}", request_id)
    for name, value in message.items():
        _check(do, name, value, request_id)
    return Request(request_id, do, message)


def encode(message: Message) -> bytes:
    """One line; what is not finite becomes null."""
    return json.dumps(_finite(message), separators=(",", ":"), allow_nan=False).encode() + b"\n"


def success(request_id: RequestId, **content: object) -> Message:
    """An answer that the request was carried out."""
    return {"id": request_id, "ok": True, **content}


def refusal(request_id: RequestId, error: Message) -> Message:
    """An answer that it was not."""
    return {"id": request_id, "ok": False, "error": error}


def status_from(message: object) -> Status:
    """A Status as it came over the socket. Raises ServiceError."""
    values = _known(Status, message)
    sensors = tuple(SensorStatus(**_known(SensorStatus, one)) for one in values.pop("sensors", ()))
    return _made(Status, values | {"sensors": sensors})


def result_from(message: object) -> JobResult:
    """A JobResult as it came over the socket. Raises ServiceError."""
    return _made(JobResult, _known(JobResult, message))


def _made(kind: type[MadeT], values: Message) -> MadeT:
    try:
        return kind(**values)
    except TypeError as error:
        raise _nonsense(kind) from error


def _known(kind: type[Any], message: object) -> Message:
    """The fields this version knows; a newer daemon may say more. Lists become tuples."""
    if not isinstance(message, dict):
        raise _nonsense(kind)
    names = {field.name for field in fields(kind)}
    return {
        name: tuple(value) if isinstance(value, list) else value
        for name, value in message.items()
        if name in names
    }


def _nonsense(kind: type) -> ServiceError:
    return ServiceError(
        f"the daemon's {kind.__name__} cannot be read; restart it so that both are one version"
    )


def _id(value: object) -> RequestId:
    plain = value is None or (isinstance(value, int | str) and not isinstance(value, bool))
    if not plain or len(str(value)) > 100:
        raise BadRequest("'id' must be a whole number or a text of up to 100 characters")
    return value  # type: ignore[return-value]


def _check(do: str, name: str, value: object, request_id: RequestId) -> None:
    known = ARGUMENTS[do]
    if name not in known:
        raise BadRequest(f"'{do}' takes no {_shown(name)}{_nearest(name, list(known))}", request_id)
    wanted = known[name]
    if wanted.type is str:
        if not isinstance(value, str) or not _is_clean(value, lines=wanted is _TEXT):
            raise BadRequest(f"'{name}' of '{do}' must be a plain text", request_id)
        size: float = len(value)
    elif wanted.type is bool:
        if not isinstance(value, bool):
            raise BadRequest(f"'{name}' of '{do}' must be true or false", request_id)
        size = value
    else:
        whole = isinstance(value, int) and not isinstance(value, bool)
        if not whole and not (wanted.type is float and isinstance(value, float)):
            raise BadRequest(f"'{name}' of '{do}' must be a number", request_id)
        size = value  # type: ignore[assignment]
    if not wanted.least <= size <= wanted.most:
        unit = " characters" if wanted.type is str else ""
        raise BadRequest(
            f"'{name}' of '{do}' must be {wanted.least:g} to {wanted.most:g}{unit}", request_id
        )


def _is_clean(text: str, lines: bool) -> bool:
    """Nothing that cannot be seen, and no half characters that a file name or log cannot hold."""
    return is_printable(text.replace("\r", "") if lines else text, layout=lines)


def _shown(value: object) -> str:
    text = repr(value)
    return text if len(text) <= 60 else f"{text[:57]}..."


def _nearest(word: object, valid: list[str]) -> str:
    text = word[:60] if isinstance(word, str) else ""
    close = difflib.get_close_matches(text, valid, n=1, cutoff=0.5)
    if close:
        return f"; did you mean '{close[0]}'?"
    return f"; there are {', '.join(valid)}" if valid else ""


def _finite(value: Any) -> Any:
    if isinstance(value, dict):
        return {str(key): _finite(inner) for key, inner in value.items()}
    if isinstance(value, list | tuple):
        return [_finite(inner) for inner in value]
    if isinstance(value, float) and not math.isfinite(value):
        return None
    return value
