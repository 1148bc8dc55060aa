"""YAML text to plain values, with the line on which each stands.

A small part of YAML, on purpose: mappings, sequences and scalars. Anchors, aliases and tags
are refused (a few lines of aliases can stand for gigabytes), so is a key that stands twice.
Plain scalars are what they look like: `010` and `1:30` are text, where YAML 1.1 would silently
make 8 and 90 of them; 5e-5 is a number, where YAML 1.1 wants a dot.
"""

from __future__ import annotations

import re
from collections.abc import Iterator
from typing import Any

import yaml

from deltactl.foundation.printable import is_printable

Location = tuple[str | int, ...]

MAX_DEPTH = 20

# The parser in C, where PyYAML was built with it, is about ten times faster.
_LOADER: Any = getattr(yaml, "CSafeLoader", yaml.SafeLoader)

_DIGITS = r"[0-9]+(?:_[0-9]+)*"
_POWER = r"[eE][-+]?[0-9]+"
_INT = re.compile(r"[-+]?(?:0|[1-9][0-9]*(?:_[0-9]+)*)")
_HEX = re.compile(r"0x[0-9a-fA-F]+")
_FLOAT = re.compile(
    rf"[-+]?(?:(?:{_DIGITS}\.(?:{_DIGITS})?|\.{_DIGITS})(?:{_POWER})?|{_DIGITS}{_POWER})"
)
WORDS: dict[str, bool | float | None] = {
    **dict.fromkeys(("", "~", "null", "Null", "NULL"), None),
    **dict.fromkeys(("true", "True", "TRUE", "yes", "Yes", "on", "On"), True),
    **dict.fromkeys(("false", "False", "FALSE", "no", "No", "off", "Off"), False),
    **dict.fromkeys((".inf", "+.inf"), float("inf")),
    **dict.fromkeys(("-.inf",), float("-inf")),
    **dict.fromkeys((".nan", ".NaN"), float("nan")),
}
"""Plain words that are no texts, as in YAML 1.1."""


class YamlError(Exception):
    """Why the text cannot be read, and its line."""

    def __init__(self, line: int, message: str):
        super().__init__(message)
        self.line = line


class Tree:
    """The values of a YAML text and their lines. Raises YamlError."""

    def __init__(self, text: str):
        self.lines: dict[Location, int] = {}
        self._events = _events(text)
        self.value = self._document()

    def _document(self) -> Any:
        self._next()  # start of stream
        if isinstance(self._next(), yaml.StreamEndEvent):
            return None
        value = self._value(self._next(), ())
        self._next()  # end of document
        if not isinstance(following := self._next(), yaml.StreamEndEvent):
            raise YamlError(_line(following), "a second document begins here ('---'); remove it")
        return value

    def _value(self, event: Any, location: Location) -> Any:
        _refuse_extras(event)
        if len(location) > MAX_DEPTH:
            raise YamlError(_line(event), f"nested more than {MAX_DEPTH} deep")
        if isinstance(event, yaml.MappingStartEvent):
            return self._mapping(location)
        if isinstance(event, yaml.SequenceStartEvent):
            return self._sequence(location)
        return _scalar(event)

    def _mapping(self, location: Location) -> dict[str, Any]:
        result: dict[str, Any] = {}
        while not isinstance(event := self._next(), yaml.MappingEndEvent):
            key = _key(event)
            if key in result:
                raise YamlError(_line(event), f"'{key}' stands here twice; remove one")
            self.lines[(*location, key)] = _line(event)
            result[key] = self._value(self._next(), (*location, key))
        return result

    def _sequence(self, location: Location) -> list[Any]:
        result: list[Any] = []
        while not isinstance(event := self._next(), yaml.SequenceEndEvent):
            place = (*location, len(result))
            self.lines[place] = _line(event)
            result.append(self._value(event, place))
        return result

    def _next(self) -> Any:
        return next(self._events)


def _events(text: str) -> Iterator[Any]:
    _refuse_half_characters(text, 1)
    try:
        yield from yaml.parse(text, Loader=_LOADER)
    except yaml.MarkedYAMLError as error:
        line = error.problem_mark.line + 1 if error.problem_mark else 1
        problem = _one_line(error.problem or error.context)
        raise YamlError(line, f"is not YAML: {problem}{_remedy(problem)}") from error
    except yaml.YAMLError as error:
        raise YamlError(1, f"is not YAML: {_one_line(error)}") from error


def _refuse_extras(event: Any) -> None:
    if event.anchor is not None:
        name = f"'{event.anchor}'"
        raise YamlError(
            _line(event), f"anchors and aliases (& and *) are not taken; write {name} out"
        )
    if event.tag is not None:
        raise YamlError(_line(event), f"tags (!) are not taken; remove '{event.tag}'")


def _key(event: Any) -> str:
    if not isinstance(event, yaml.ScalarEvent):
        raise YamlError(_line(event), "a key must be a plain word")
    _refuse_extras(event)
    if not event.value or not event.value.isprintable():
        raise YamlError(_line(event), f"a key must be a plain word, not {event.value!a}")
    return str(event.value)


def _scalar(event: Any) -> str | int | float | bool | None:
    _refuse_half_characters(event.value, _line(event))
    if not is_printable(event.value, layout=True):
        raise YamlError(_line(event), f"holds characters that cannot be seen: {event.value[:60]!a}")
    is_plain = event.implicit[0]
    return _plain(event.value, _line(event)) if is_plain else str(event.value)


def _plain(text: str, line: int) -> str | int | float | bool | None:
    if text in WORDS:
        return WORDS[text]
    if _HEX.fullmatch(text) or _INT.fullmatch(text):
        if len(text) > 30:
            raise YamlError(line, f"a number of {len(text)} digits; nothing here is that large")
        return int(text, 0)
    if _FLOAT.fullmatch(text):
        return float(text)
    return text


def _refuse_half_characters(text: str, line: int) -> None:
    try:
        text.encode()
    except UnicodeEncodeError as error:
        raise YamlError(line, f"holds half a character ({text[error.start]!a})") from error


def _line(event: Any) -> int:
    return int(event.start_mark.line) + 1


_INDENTED = "is this line, or one before it, indented otherwise than its neighbours?"
REMEDIES = {
    "tab character": "indent with spaces",
    "cannot start any token": "is there a tab in front of it? Indent with spaces",
    "expected key": _INDENTED,
    "expected <block end>": _INDENTED,
    "mapping values are not allowed": "is there a second ':', or is this line indented too far?",
}
"""What is most often behind words of the YAML reader."""


def _remedy(problem: str) -> str:
    found = next((remedy for words, remedy in REMEDIES.items() if words in problem), None)
    return "" if found is None else f"; {found}"


def _one_line(error: object) -> str:
    return " ".join(str(error).split())
