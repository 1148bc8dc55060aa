"""Help teaches by example: every command shows how it is called, a line each, unwrapped."""

from __future__ import annotations

import re
import shlex

import pytest
import typer
from typer.testing import CliRunner

from deltactl.cli.main import app
from deltactl.cli.mistyped import CALLED

JOBS = ["run", "check", "report", "export", "diagnose"]
SERVICE = ["on", "off", "home", "pause", "resume", "cancel", "acknowledge", "stop", "status"]
COMMANDS = typer.main.get_command(app).commands
MACHINE = ["sensors", "daemon", "install"]


@pytest.mark.parametrize("command", JOBS + SERVICE + MACHINE)
def test_help_shows_whole_lines_to_type(deltactl, command: str) -> None:
    lines = [line.rstrip() for line in deltactl(command, "--help").stdout.splitlines()]
    above_options = lines[: next(n for n, line in enumerate(lines) if line.startswith("╭"))]
    above_options = [line for line in above_options if not line.startswith(" Usage:")]
    shown = [line for line in above_options if re.search(rf"\bdeltactl {command}\b", line)]
    assert shown
    assert not any("`" in line for line in lines)
    assert all(line.startswith(("  deltactl", "  sudo .venv/bin/deltactl")) for line in shown)


def test_the_first_help_starts_without_a_robot(deltactl) -> None:
    shown = [
        line.split("  ")[1]
        for line in deltactl("--help").stdout.splitlines()[:12]
        if "  deltactl" in line
    ]
    assert shown[:2] == ["deltactl run heart.yaml", "deltactl check heart.yaml"]


@pytest.mark.parametrize("typed", sorted(CALLED))
def test_a_command_that_is_called_otherwise_says_what_to_type(typed: str) -> None:
    refused = CliRunner().invoke(app, [typed])
    assert refused.exit_code == 2
    assert CALLED[typed] in " ".join(refused.stderr.split())
    _, command, *options = CALLED[typed].split()
    shown = CliRunner().invoke(app, [command, "--help"])
    assert shown.exit_code == 0
    assert all(one in shown.stdout for one in options if one.startswith("--"))


def examples() -> list[str]:
    """Lines to type, of every command's help; two spaces part them from what they are for."""
    texts = [app.info.help, *(one.help for one in COMMANDS.values())]
    lines = [line.strip().removeprefix("sudo .venv/bin/") for text in texts
             for line in str(text).splitlines()]  # fmt: skip
    return [line.split("  ")[0] for line in lines if line.startswith("deltactl ")]


@pytest.mark.parametrize("line", examples())
def test_the_command_line_takes_every_example(line: str) -> None:
    _, name, *words = shlex.split(line)
    command = COMMANDS[name]
    command.make_context(name, words)


def test_there_is_an_example_for_every_command() -> None:
    shown = {line.split()[1] for line in examples()}
    assert set(COMMANDS) == shown
