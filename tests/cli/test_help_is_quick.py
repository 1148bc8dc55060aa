"""`deltactl --help` answers at once, whatever the machine."""

from __future__ import annotations

import re
import subprocess
import sys
from pathlib import Path

import pytest

from tests.rigs.commands import every_command

OVER_BARE = 1.5
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


@pytest.mark.study
def test_help_costs_little_more_than_that_of_a_program_that_does_nothing(tmp_path: Path) -> None:
    bare = tmp_path / "bare.py"
    bare.write_text(BARE.format(commands=len(list(every_command()))))
    assert _calls("-m", "deltactl.cli.main") < OVER_BARE * _calls(str(bare))


def test_help_loads_nothing_that_takes_long() -> None:
    asked = "import sys\nfrom deltactl.cli.main import main\nprint(*sys.modules)"
    loaded = subprocess.run(
        [sys.executable, "-c", asked], capture_output=True, text=True, check=True
    ).stdout.split()
    assert "typer" in loaded
    assert not {"numpy", "scipy", "pydantic", "yaml", "mcap", "asyncio", "mujoco"} & set(loaded)


def _calls(*program: str) -> int:
    """Counted, not timed: the same figure on a machine that is busy with something else."""
    command = [sys.executable, "-m", "cProfile", *program, "--help"]
    printed = subprocess.run(command, capture_output=True, text=True, check=True).stdout
    counted = re.search(r"(\d+) function calls", printed)
    assert counted is not None
    return int(counted[1])
