"""YAML text to plain values, with the line of each.

A small part of YAML, on purpose: mappings, sequences and scalars. Anchors, aliases and tags
are refused (a few lines of aliases can expand to gigabytes), and so is a key that occurs twice.
Plain scalars are what they look like: `010` and `1:30` are text, where YAML 1.1 would silently
make 8 and 90 of them; 5e-5 is a number, where YAML 1.1 wants a dot.
"""

from __future__ import annotations

import math
import re
from array import array
from collections.abc import Callable, Iterator, Sequence
from contextlib import contextmanager
from typing import Any

import yaml

from deltactl.foundation.printable import is_printable

Location = tuple[str | int, ...]

MAX_DEPTH = 20
MAX_VALUES = 1_000_000
"""Ten for each of the 100,000 legs or poses that a job may have."""
MOST_DIGITS = 30
"""Digits of a whole number; more takes a time that grows with their square."""
SHOWN_CHARACTERS = 100
"""So much of a key is shown."""

# The parser in C, where PyYAML was built with it, is about ten times faster.
_LOADER: Any = getattr(yaml, "CSafeLoader", yaml.SafeLoader)

_Scalar = yaml.ScalarEvent
_OF_NUMBERS = frozenset("0123456789+-.")
"""With which a number begins."""
_DIGITS = r"[0-9]+(?:_[0-9]+)*"
_POWER = r"[eE][-+]?[0-9]+"
_INT = re.compile(r"[-+]?(?:0|[1-9][0-9]*(?:_[0-9]+)*)")
_HEX = re.compile(r"0x[0-9a-fA-F]+")
_FLOAT = re.compile(
    rf"[-+]?(?:(?:{_DIGITS}\.(?:{_DIGITS})?|\.{_DIGITS})(?:{_POWER})?|{_DIGITS}{_POWER})"
)
# Refused before the parser sees them: it compares each with all before it.
_TAG_DIRECTIVE = re.compile(r"^\ufeff?%TAG\b", re.MULTILINE)
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
    """The values of a YAML text and their lines. Raises YamlError.

    Its time and memory are proportional to the text, and what is refused is refused where it is
    met: a text of 4 MB takes a second, whatever it holds.
    """

    def __init__(self, text: str, most_values: int = MAX_VALUES):
        self._lines: dict[int, dict[str, int] | array[int]] = {}
        """By identity of each mapping and sequence: the line of each of its parts."""
        self._most = self._left = most_values
        self._here: list[str | int] = []
        """Where the value is that is read now."""
        with _events(text) as self._next:
            self.value = self._document()

    @property
    def values(self) -> int:
        """How many there are, lists and mappings included."""
        return self._most - self._left

    def line_of(self, location: Location) -> int:
        """Line of the deepest part of `location` that is in the text (1 if none is)."""
        line, value = 1, self.value
        for part in location:
            if not self._has(value, part):
                break
            line, value = self._lines[id(value)][part], value[part]  # type: ignore[index]
        return line

    def __contains__(self, location: object) -> bool:
        """Whether the text has a value there."""
        if not isinstance(location, tuple):
            return False
        value = self.value
        for part in location:
            if not self._has(value, part):
                return False
            value = value[part]
        return bool(location)

    @staticmethod
    def _has(value: Any, part: str | int) -> bool:
        if isinstance(value, list):
            return isinstance(part, int) and 0 <= part < len(value)
        return isinstance(value, dict) and part in value

    def _document(self) -> Any:
        self._next()  # start of stream
        if isinstance(self._next(), yaml.StreamEndEvent):
            return None
        value = self._value(self._next())
        self._next()  # end of document
        if not isinstance(following := self._next(), yaml.StreamEndEvent):
            raise YamlError(_line(following), "a second document begins here ('---'); remove it")
        return value

    def _value(self, event: Any) -> Any:
        self._left -= 1
        if self._left < 0:
            raise YamlError(_line(event), f"holds more than {self._most:,} values; split the file")
        if event.anchor is not None or event.tag is not None:
            _refuse_extras(event)
        if type(event) is _Scalar:
            if not event.implicit[0]:
                return _visible(event)
            value = _plain(event)
            if type(value) is float and not math.isfinite(value):
                key = f"{key_of(self._here)}: " if self._here else ""
                raise YamlError(_line(event), f"{key}must be a finite number, not {value}")
            return value
        if len(self._here) > MAX_DEPTH:
            raise YamlError(_line(event), f"nested more than {MAX_DEPTH} deep")
        return self._mapping() if type(event) is yaml.MappingStartEvent else self._sequence()

    def _mapping(self) -> dict[str, Any]:
        result: dict[str, Any] = {}
        lines: dict[str, int] = {}
        self._lines[id(result)] = lines
        following, value_of, here = self._next, self._value, self._here
        here.append("")
        while type(event := following()) is not yaml.MappingEndEvent:
            key = _key(event)
            if key in result:
                raise YamlError(_line(event), f"'{_shortened(key)}' occurs here twice; remove one")
            lines[key] = event.start_mark.line + 1
            here[-1] = key
            result[key] = value_of(following())
        here.pop()
        return result

    def _sequence(self) -> list[Any]:
        result: list[Any] = []
        lines = self._lines[id(result)] = array("L")
        following, value_of, here = self._next, self._value, self._here
        here.append(0)
        while type(event := following()) is not yaml.SequenceEndEvent:
            lines.append(event.start_mark.line + 1)
            here[-1] = len(result)
            result.append(value_of(event))
        here.pop()
        return result


def key_of(location: Sequence[str | int]) -> str:
    """A location as messages name it: `limits.arm_deg.0`; long keys are cut."""
    return ".".join(_shortened(str(part)) for part in location)


def _shortened(text: str) -> str:
    return text if len(text) <= SHOWN_CHARACTERS else f"{text[: SHOWN_CHARACTERS - 3]}..."


@contextmanager
def _events(text: str) -> Iterator[Callable[[], Any]]:
    """What gives one event of the text after another; its errors become YamlErrors."""
    _refuse_half_characters(text, 1)
    if directive := _TAG_DIRECTIVE.search(text):
        line = text.count("\n", 0, directive.start()) + 1
        raise YamlError(line, "tags (!) are not taken; remove '%TAG'")
    try:
        yield _LOADER(text).get_event
    except yaml.MarkedYAMLError as error:
        line = error.problem_mark.line + 1 if error.problem_mark else 1
        problem = _one_line(error.problem or error.context)
        raise YamlError(line, f"is not YAML: {problem}{_remedy(problem)}") from error
    except yaml.YAMLError as error:
        raise YamlError(1, f"is not YAML: {_one_line(error)}") from error


def _refuse_extras(event: Any) -> None:
    if event.anchor is not None:
        name = f"'{_shortened(event.anchor)}'"
        raise YamlError(
            _line(event), f"anchors and aliases (& and *) are not taken; write {name} out"
        )
    if event.tag is not None:
        raise YamlError(_line(event), f"tags (!) are not taken; remove '{_shortened(event.tag)}'")


def _key(event: Any) -> str:
    if type(event) is not _Scalar:
        raise YamlError(_line(event), "a key must be a plain word")
    if event.anchor is not None or event.tag is not None:
        _refuse_extras(event)
    key: str = event.value
    if not key or not key.isprintable():
        raise YamlError(_line(event), f"a key must be a plain word, not {_shortened(key)!a}")
    return key


def _visible(event: Any) -> str:
    """A text; raises YamlError where a part of it cannot be seen."""
    text: str = event.value
    if not (text.isascii() and text.isprintable()):
        _refuse_half_characters(text, _line(event))
        if not is_printable(text, layout=True):
            raise YamlError(_line(event), f"holds characters that cannot be seen: {text[:60]!a}")
    return text


def _plain(event: Any) -> str | int | float | bool | None:
    """The value of a scalar without quotes."""
    text: str = event.value
    if text.isdigit() and text.isascii() and len(text) <= MOST_DIGITS and text[0] != "0":
        return int(text)  # most of a long file
    if text in WORDS:
        return WORDS[text]
    if text[0] not in _OF_NUMBERS:
        return _visible(event)
    if _FLOAT.fullmatch(text):
        return float(text)
    if _INT.fullmatch(text) or _HEX.fullmatch(text):
        if len(text) > MOST_DIGITS:
            raise YamlError(
                _line(event), f"a number of {len(text)} digits; nothing here is that large"
            )
        return int(text, 0)
    return _visible(event)


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
