"""Messages of one channel gathered into columns, as its row of the channel table says."""

from __future__ import annotations

import json
import math
from array import array
from typing import Any

import numpy as np

from deltactl.foundation.errors import RecordingError
from deltactl.recording.format.channels import Channel

FloatArray = np.ndarray[Any, np.dtype[np.float64]]
Int64Array = np.ndarray[Any, np.dtype[np.int64]]
_WRONG = (ValueError, KeyError, TypeError, OverflowError, AttributeError, RecursionError)
"""What messages that are not as they should be make `json` and arrays raise."""


class Columns:
    """Grows chunk by chunk; numbers cost eight bytes each, whatever JSON they came from."""

    def __init__(self, channel: Channel):
        self._channel = channel
        self._integers = {f.name: array("q") for f in channel.fields if f.kind == "integer"}
        self._numbers = {f.name: array("d") for f in channel.fields if f.kind == "number"}
        self._texts: dict[str, list[str]] = {
            f.name: [] for f in channel.fields if f.kind == "string"
        }

    def add(self, payloads: list[bytes]) -> None:
        """Append messages. Raises RecordingError when one is not what the table says."""
        try:
            messages = json.loads(b"[" + b",".join(payloads) + b"]")
            for name, integers in self._integers.items():
                integers.extend([message[name] for message in messages])
            for name, numbers in self._numbers.items():
                numbers.extend([message.get(name, math.nan) for message in messages])
            for name, texts in self._texts.items():
                texts.extend([str(message[name]) for message in messages])
        except _WRONG as error:
            raise RecordingError(
                f"a message of {self._channel.topic} is not what its schema says ({error!r})"
            ) from error

    def integers(self, name: str) -> Int64Array:
        """A column of whole numbers; shape (n,)."""
        return np.array(self._integers[name], dtype=np.int64)

    def numbers(self, *names: str) -> FloatArray:
        """One column, shape (n,), or several side by side, shape (n, len(names)); NaN = absent."""
        columns = [np.array(self._numbers[name], dtype=np.float64) for name in names]
        return columns[0] if len(columns) == 1 else np.stack(columns, axis=1)

    def texts(self, name: str) -> list[str]:
        """A column of texts."""
        return self._texts[name]

    def counts(self) -> Int64Array:
        """The three step counts; shape (n, 3)."""
        return np.stack([self.integers(f"steps_{motor}") for motor in (1, 2, 3)], axis=1)

    def rows(self) -> list[dict[str, Any]]:
        """The messages again, one dictionary each."""
        columns: dict[str, Any] = {**self._integers, **self._numbers, **self._texts}
        lists = [list(column) for column in columns.values()]
        return [dict(zip(columns, row, strict=True)) for row in zip(*lists, strict=True)]
