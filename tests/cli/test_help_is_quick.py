"""`deltactl --help` answers at once, whatever the machine."""

from __future__ import annotations

import os
import resource
import subprocess
import sys
from pathlib import Path

import pytest

from command_line.main import app

TIMES = 5
OVER_BARE = 1.4
"""Of a program with as many commands that do nothing: what is ours, not the library's."""
BARE = """
from typing import Annotated
import typer
app = typer.Typer(rich_markup_mode="markdown")
def nothing(
    first: Annotated[str, typer.Argument(help="one")],
    second: Annotated[str, typer.Option(help="two")] = "",
    third: Annotated[bool, typer.Option("--third", help="three")] = False,
    fourth: Annotated[float, typer.Option(help="four")] = 0.0,
) -> None:
    "Nothing."
for number in range({commands}):
    app.command(f"nothing-{{number}}")(nothing)
app()
"""


@pytest.mark.realtime
def test_help_costs_little_more_than_that_of_a_program_that_does_nothing(tmp_path: Path) -> None:
    bare = tmp_path / "bare.py"
    bare.write_text(BARE.format(commands=len(app.registered_commands)))
    _used_s("-m", "command_line.main")  # warm the file cache and the byte code
    pairs = [(_used_s(str(bare)), _used_s("-m", "command_line.main")) for _ in range(TIMES)]
    bare_s, ours_s = (min(times) for times in zip(*pairs, strict=True))
    assert ours_s < OVER_BARE * bare_s


def test_help_loads_nothing_that_takes_long() -> None:
    asked = "import sys\nfrom command_line.main import main\nprint(*sys.modules)"
    loaded = subprocess.run(
        [sys.executable, "-c", asked], capture_output=True, text=True, check=True
    ).stdout.split()
    assert "typer" in loaded
    assert not {"numpy", "scipy", "pydantic", "yaml", "mcap", "asyncio", "mujoco"} & set(loaded)


def _used_s(*program: str) -> float:
    before = resource.getrusage(resource.RUSAGE_CHILDREN)
    written = os.environ | {"PYTHONDONTWRITEBYTECODE": ""}
    command = [sys.executable, *program, "--help"]
    subprocess.run(command, env=written, capture_output=True, check=True)
    after = resource.getrusage(resource.RUSAGE_CHILDREN)
    return after.ru_utime - before.ru_utime + after.ru_stime - before.ru_stime
