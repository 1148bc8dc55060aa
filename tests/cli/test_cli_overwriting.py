"""No command writes over a file that is there, but with --force."""

from __future__ import annotations

from pathlib import Path

import pytest

from tests.cli.conftest import Deltactl

COMMANDS = [
    ("export", "x.mcap", "kept"),
    ("report", "x.mcap", "-o", "kept"),
    ("run", "heart.yaml", "--simulate", "--report", "kept"),
    *(("diagnose", "x.csv", "--robot", "servo-axis.yaml", option, "kept")
      for option in ("--json", "--report", "--save-robot", "--next-job")),
    ("diagnose", "x.csv", "--inspect", "--save-columns", "kept"),
]  # fmt: skip


@pytest.mark.parametrize("words", COMMANDS, ids=" ".join)
def test_what_is_there_is_kept(
    words: tuple[str, ...], tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    from typer.testing import CliRunner

    from command_line.main import app

    monkeypatch.chdir(tmp_path)
    (tmp_path / "kept").write_text("mine")
    refused = CliRunner().invoke(app, [*words])
    assert str(refused.exception) == "kept: exists already; name another file, or add --force"
    assert (tmp_path / "kept").read_text() == "mine"


def test_force_writes_over_it(deltactl: Deltactl, tmp_path: Path) -> None:
    (tmp_path / "c.html").write_text("old")
    deltactl("run", "circle.yaml", "--simulate", "--record", "c.mcap", "--report", "c.html",
             "--force")  # fmt: skip
    assert (tmp_path / "c.html").read_text().startswith("<!")
