"""Errors across the socket: the class goes over by name and comes out as the same class."""

from __future__ import annotations

from dataclasses import asdict
from typing import Any

from deltactl.foundation.errors import DeltactlError, MotionError, Refusal, ServiceError

Message = dict[str, Any]


def _tree(root: type[DeltactlError]) -> dict[str, type[DeltactlError]]:
    found = {root.__name__: root}
    for leaf in root.__subclasses__():
        found |= _tree(leaf)
    return found


KINDS: dict[str, type[DeltactlError]] = _tree(DeltactlError)
"""Every class of `deltactl.foundation.errors` by its name."""


def as_message(error: BaseException) -> Message:
    """Kind and one-line text of an error; what is not ours is an internal ServiceError."""
    text = " ".join(str(error).split())
    kind = type(error).__name__
    if kind in KINDS and type(error) is KINDS[kind]:
        refusal = error.at_point if isinstance(error, MotionError) else None
        return {"kind": kind, "message": text} | (
            {} if refusal is None else {"at_point": asdict(refusal)}
        )
    return {
        "kind": ServiceError.__name__,
        "message": f"the daemon failed inside ({kind}: {text}); see 'journalctl -u deltactl'",
    }


def as_exception(message: object) -> DeltactlError:
    """The exception that a message describes; an unknown kind becomes a ServiceError."""
    if not isinstance(message, dict) or not isinstance(message.get("message"), str):
        return ServiceError(
            "the daemon refused, and its reason cannot be read; are both one version?"
        )
    kind = KINDS.get(str(message.get("kind")), ServiceError)
    error = kind(message["message"])
    if isinstance(error, MotionError):
        error.at_point = _refusal(message.get("at_point"))
    return error


def _refusal(sent: object) -> Refusal | None:
    """What is wrong with a point; None where nothing, or something else, was sent."""
    if not isinstance(sent, dict):
        return None
    why, remedy, on_the_way = (sent.get(name) for name in ("why", "remedy", "on_the_way"))
    if not (isinstance(why, str) and isinstance(remedy, str) and isinstance(on_the_way, bool)):
        return None
    return Refusal(why, remedy, on_the_way)
