"""Help teaches by example: every command shows how it is called, a line each, unwrapped."""

from __future__ import annotations

import re
import resource
import shlex
import subprocess
import sys
from functools import cache

import pytest
import typer.rich_utils  # noqa: F401  it keeps the width of a window that it finds when imported
from typer.testing import CliRunner

from deltactl.cli.main import app
from deltactl.cli.mistyped import CALLED
from tests.rigs.commands import every_command, found, whole_group

COMMANDS = dict(every_command())
PANELS = {"Run", "By hand", "Diagnose and repair", "Learn", "Service"}
MOST_COMMANDS, MOST_OPTIONS = 25, 12
HELP_S = 0.4
SLOW = 4.0
"""So much slower a machine may be than the one that HELP_S is meant for."""
NARROW, WIDE = 80, 1000


@cache
def shown(name: str, option: str = "--help", columns: int = NARROW) -> str:
    window = {"COLUMNS": str(columns), "TERMINAL_WIDTH": str(columns)}
    done = CliRunner().invoke(app, [*name.split(), option], env=window)
    assert done.exit_code == 0, done.output
    return done.output


def test_the_first_screen_has_few_commands_in_panels() -> None:
    group = whole_group()
    assert len(group.commands) <= MOST_COMMANDS
    assert {command.rich_help_panel for command in group.commands.values()} == PANELS


@pytest.mark.parametrize("name", ["", *COMMANDS])
def test_the_first_screen_has_few_options_and_an_example_and_whole_words(name: str) -> None:
    help_text = shown(name)
    listed = [line for line in help_text.splitlines() if re.match(r"│ \*? *--[a-z]", line)]
    assert 1 <= len(listed) <= MOST_OPTIONS
    assert re.search(rf"^ +(sudo \S+/)?deltactl {name}", help_text, re.MULTILINE)
    assert "`" not in help_text
    for option in ("--help", "--help-all"):
        known = set(_words(shown(name, option, WIDE)))
        assert [word for word in _words(shown(name, option)) if word not in known] == []


@pytest.mark.parametrize("name", COMMANDS)
def test_examples_are_not_broken_in_a_narrow_window(name: str) -> None:
    narrow, wide = (_examples(shown(name, "--help", columns)) for columns in (NARROW, WIDE))
    assert narrow == wide


def _examples(text: str) -> list[str]:
    lines = [line.strip() for line in text.splitlines()]
    return [line for line in lines if re.match(r"(sudo \S+/)?deltactl ", line)]


def _words(text: str) -> list[str]:
    return [word for word in re.sub("[╭╮╰╯│─]", " ", text).split() if word]


@pytest.mark.parametrize("name", COMMANDS)
def test_the_second_screen_has_all_options(name: str) -> None:
    options = {
        option
        for parameter in COMMANDS[name].params
        for option in parameter.opts
        if option.startswith("--")
    }
    first, whole = (_words(shown(name, option)) for option in ("--help", "--help-all"))
    assert options <= {part for word in whole for part in word.split(",")}
    assert ("--help-all" in first) is (len(whole) > len(first))


def test_help_is_quick() -> None:
    """Counted in time of the processor, which is not that of others on the machine."""
    before = resource.getrusage(resource.RUSAGE_CHILDREN)
    command = [sys.executable, "-m", "deltactl.cli.main", "--help"]
    subprocess.run(command, capture_output=True, check=True)
    after = resource.getrusage(resource.RUSAGE_CHILDREN)
    took_s = after.ru_utime + after.ru_stime - before.ru_utime - before.ru_stime
    assert took_s < SLOW * HELP_S


def test_the_first_help_starts_without_a_robot(deltactl) -> None:
    typed = [
        line.split("  ")[1]
        for line in deltactl("--help").stdout.splitlines()[:12]
        if "  deltactl" in line
    ]
    assert typed[:2] == ["deltactl run heart.yaml", "deltactl check heart.yaml"]


@pytest.mark.parametrize("typed", sorted(CALLED))
def test_a_command_that_is_called_otherwise_says_what_to_type(typed: str) -> None:
    refused = CliRunner().invoke(app, [typed])
    assert refused.exit_code == 2
    assert CALLED[typed] in " ".join(refused.stderr.split())
    command, words = found(CALLED[typed].split()[1:])
    known = {option for parameter in command.params for option in parameter.opts}
    assert {word for word in words if word.startswith("--")} <= known


def examples() -> list[str]:
    """Lines to type, of every command's help; two spaces part them from what they are for."""
    texts = [app.info.help, *(one.help for one in COMMANDS.values())]
    lines = [line.strip().removeprefix("sudo .venv/bin/") for text in texts
             for line in str(text).splitlines()]  # fmt: skip
    return [line.split("  ")[0] for line in lines if line.startswith("deltactl ")]


@pytest.mark.parametrize("line", examples())
def test_the_command_line_takes_every_example(line: str) -> None:
    command, words = found(shlex.split(line)[1:])
    command.make_context(line, words)
