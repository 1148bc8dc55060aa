"""Lines that name files stay whole, whatever the window's width and the file's name."""

from __future__ import annotations

from pathlib import Path

import pytest

from deltactl.cli import output


def test_a_path_is_neither_broken_nor_read_as_markup(capsys: pytest.CaptureFixture[str]) -> None:
    path = Path("/a", *["long folder [bold]"] * 20, "run.mcap")
    output.say(f"recording: {path}")
    output.warn(f"not all was recorded: {path}")
    out, err = capsys.readouterr()
    assert out == f"recording: {path}\n"
    assert err == f"not all was recorded: {path}\n"


def test_facts_show_brackets(capsys: pytest.CaptureFixture[str]) -> None:
    output.console.print(output.facts("limits [mm]", [("why", "point [1, 2] is out")]))
    shown = capsys.readouterr().out
    assert "limits [mm]" in shown
    assert "point [1, 2] is out" in shown
