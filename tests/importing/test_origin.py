"""A file out of reach is answered by the --origin that brings all of it there, if there is one."""

from __future__ import annotations

import re
import shlex
import subprocess
from collections.abc import Callable
from pathlib import Path

import pytest

Deltactl = Callable[..., subprocess.CompletedProcess[str]]
HOLE = "G0 X0 Y0 Z5\nG1 Z0 F600\nG1 X40\nG2 X0 Y0 I-20 J0\n"


@pytest.mark.parametrize(
    ("file", "text"),
    [
        ("flat.nc", "G0 X0 Y0\nG1 X40 F600\nG1 Y40\n"),
        ("deep.nc", HOLE),
        ("far.nc", HOLE.replace("X0", "X700").replace("X40", "X740")),
        ("table.csv", "x,y,z\n0,0,0\n30,0,0\n30,30,4\n"),
    ],
)
def test_the_origin_that_is_named_will_do(
    deltactl: Deltactl, tmp_path: Path, file: str, text: str
) -> None:
    """The command said only that the first place is out of reach."""
    (tmp_path / file).write_text(text)
    words = ("convert", file, "job.yaml", "--robot", "zhao-2023.yaml")
    refused = deltactl(*words, status=2).stderr
    named = re.search(r'all of it is within reach with (--origin "[^"]+"); no job', refused)
    assert named is not None, refused
    deltactl(*words, *shlex.split(named[1]))
    assert (tmp_path / "job.yaml").exists()


def test_where_there_is_none_its_form_is_told(deltactl: Deltactl, tmp_path: Path) -> None:
    (tmp_path / "large.nc").write_text("G0 X0 Y0\nG1 X1900 F600\n")
    words = ("convert", "large.nc", "job.yaml", "--robot", "zhao-2023.yaml")
    refused = deltactl(*words, status=2).stderr
    assert '--origin "X Y Z" says where the file\'s 0 0 0 is' in refused
