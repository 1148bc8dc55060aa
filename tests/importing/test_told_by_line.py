"""A converted job that may not run is told by the line of the file that it was made of."""

from __future__ import annotations

import subprocess
from collections.abc import Callable
from pathlib import Path

import pytest

Deltactl = Callable[..., subprocess.CompletedProcess[str]]
OPTIONS = ["--robot", "zhao-2023.yaml", "--origin", "0 0 -450"]


@pytest.mark.parametrize(
    ("line", "says"),
    [
        ("G1 X900 F100", "part.nc:4: this move: arm 2 would be at 110"),
        ("G1 X20000", "part.nc:4: this move ends at 20000 0 -450 mm, beyond the reach"),
        ("G2 X30 Y0 I20", "part.nc:4: an arc's radius is 20 where it begins and 10 where it ends"),
    ],
)
def test_the_line_of_the_gcode_is_named(
    deltactl: Deltactl, tmp_path: Path, line: str, says: str
) -> None:
    (tmp_path / "part.nc").write_text(f"(part)\nG0 X0 Y0 Z0\n\n{line}\nG1 X0 Y0\n")
    refused = deltactl("convert", "part.nc", "part.yaml", *OPTIONS, status=2).stderr
    assert says in " ".join(refused.split())
    assert "legs." not in refused


@pytest.mark.parametrize(
    ("name", "text", "says"),
    [
        (
            "part.nc",
            "(part)\nG0 X900 Y0 Z0\nG1 X0 Y0\n",
            "part.nc:2: where the path begins: out of reach",
        ),
        ("part.nc", "G0 X20000 Y0 Z0\nG1 X0\n", "part.nc:1: the path begins at 20000 0 -450 mm"),
        (
            "part.nc",
            "G1 X10 F100\nG1 X20\nG2 X30 Y0 Z0 I5 J0\n",
            "moves before X, Y and Z are all known left out (2 times): begin with a move that has",
        ),
        ("part.csv", "x,y\n900,0\n0,0\n", "part.csv:2: where the path begins: out of reach"),
    ],
)
def test_a_start_out_of_reach_is_told_by_its_own_line(
    deltactl: Deltactl, tmp_path: Path, name: str, text: str, says: str
) -> None:
    (tmp_path / name).write_text(text)
    refused = deltactl("convert", name, "part.yaml", *OPTIONS, status=2).stderr
    assert says in " ".join(refused.split())
