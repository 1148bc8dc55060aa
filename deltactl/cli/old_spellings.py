"""Command lines in the spelling of an earlier version: what was typed, in the present one."""

from __future__ import annotations

import difflib
import sys
from collections.abc import Collection

from deltactl.foundation.release import COMMANDS, GONE_IN

HELP = ("--help", "-h", "--help-all")


def as_now(typed: list[str], kinds: Collection[str]) -> list[str]:
    """The words of a command line in the present spelling; says on standard error what is new.

    kinds: the commands of `init`; a word that is nearly one of them names no robot file.
    """
    for old, new in COMMANDS.items():
        rest = _behind(old.split(), typed, kinds)
        if rest is None:
            continue
        print(
            f"deltactl: 'deltactl {old}' is now 'deltactl {new}'; the old spelling goes with"
            f" release {GONE_IN}",
            file=sys.stderr,
        )
        return [word for word in new.split() if word != "FILE"] + rest
    return typed


def _behind(old: list[str], typed: list[str], kinds: Collection[str]) -> list[str] | None:
    """What else was typed where an old spelling was; None where it was not."""
    command, *options = old
    if not typed or typed[0] != command:
        return None
    rest = _split(typed[1:])
    if options == ["FILE"]:
        mistyped = rest and difflib.get_close_matches(rest[0], [*kinds, *HELP], n=1)
        return None if not rest or mistyped else rest
    for start in range(len(rest) - len(options) + 1):
        if rest[start : start + len(options)] == options:
            return rest[:start] + rest[start + len(options) :]
    return None


def _split(words: list[str]) -> list[str]:
    """Options of old spellings that were typed with their value, as --kind=delta, in two words."""
    known = {word for old in COMMANDS for word in old.split() if word.startswith("--")}
    made: list[str] = []
    for word in words:
        option, equals, value = word.partition("=")
        made += [option, value] if equals and option in known else [word]
    return made
