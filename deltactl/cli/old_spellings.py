"""Command lines in the spelling of an earlier version: what was typed, in the present one."""

from __future__ import annotations

import difflib
import sys
from collections.abc import Collection

from deltactl.foundation.release import GONE_IN

OLD_SPELLINGS: dict[str, str] = {
    "diagnose --inspect": "inspect",
    "diagnose --fleet": "fleet",
    "demo --conceal": "demo --hide",
    "init --kind delta": "init delta",
    "init --kind servo_axis": "init axis",
    "init --kind stepper_axis": "init axis --drive stepper",
    "init --kind range_sensor": "init sensor",
    "init FILE": "init delta FILE",
    "verify": "job verify",
    "follow": "job follow",
    "pause": "job pause",
    "resume": "job resume",
    "cancel": "job cancel",
    "teach": "job teach",
    "on": "power on",
    "off": "power off",
    "record": "status record",
    "sensors record": "status record",
    "sensors": "status sensors",
    "collect": "network collect",
    "train": "network train",
    "evaluate": "network evaluate",
    "prove": "demo prove",
    "reproduce": "network reproduce",
    "daemon": "service daemon",
    "install": "service install",
    "check-runs": "service check-runs",
    "web-user": "web user",
    "foxglove": "web foxglove",
    "version": "--version",
}
"""Old to new, each without `deltactl`. Options in an old spelling may be typed anywhere behind the
command."""
HELP = ("--help", "-h", "--help-all")


def as_now(typed: list[str], kinds: Collection[str]) -> list[str]:
    """The words of a command line in the present spelling; says on standard error what is new.

    kinds: the commands of `init`; a word that is nearly one of them names no robot file.
    """
    for old, new in OLD_SPELLINGS.items():
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
    known = {word for old in OLD_SPELLINGS for word in old.split() if word.startswith("--")}
    made: list[str] = []
    for word in words:
        option, equals, value = word.partition("=")
        made += [option, value] if equals and option in known else [word]
    return made
