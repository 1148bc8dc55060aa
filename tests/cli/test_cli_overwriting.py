"""No command writes over a file that is there, but with --force."""

from __future__ import annotations

from pathlib import Path

import pytest

from deltactl.firmware_py.named_files import CONFIG_FOLDER
from tests.cli.conftest import Deltactl

COMMANDS = [
    ("export", "x.mcap", "kept"),
    ("report", "x.mcap", "-o", "kept"),
    ("run", "heart.yaml", "--simulate", "--report", "kept"),
    *(("diagnose", "x.csv", "--robot", "servo-axis.yaml", option, "kept")
      for option in ("--json", "--report", "--save-robot", "--next-job")),
    ("inspect", "x.csv", "--save-columns", "kept"),
]  # fmt: skip


@pytest.mark.parametrize("words", COMMANDS, ids=" ".join)
def test_what_is_there_is_kept(
    words: tuple[str, ...], tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    from typer.testing import CliRunner

    from deltactl.cli.main import app

    monkeypatch.chdir(tmp_path)
    (tmp_path / "kept").write_text("mine")
    refused = CliRunner().invoke(app, [*words])
    assert str(refused.exception) == "kept: exists already; name another file, or add --force"
    assert (tmp_path / "kept").read_text() == "mine"


@pytest.mark.study
def test_force_writes_over_it(deltactl: Deltactl, tmp_path: Path) -> None:
    (tmp_path / "c.html").write_text("old")
    circle = (CONFIG_FOLDER / "circle.yaml").read_text(encoding="utf-8")
    (tmp_path / "small.yaml").write_text(circle.replace("radius_m: 0.1", "radius_m: 0.01"))
    deltactl("run", "small.yaml", "--simulate", "--record", "c.mcap", "--report", "c.html",
             "--force")  # fmt: skip
    assert (tmp_path / "c.html").read_text().startswith("<!")


def test_a_recording_is_kept_with_force_too(tmp_path: Path) -> None:
    from typer.testing import CliRunner

    from deltactl.cli.main import app

    kept = tmp_path / "kept.mcap"
    kept.write_text("mine")
    words = ["run", "heart.yaml", "--simulate", "--record", str(kept), "--force"]
    refused = CliRunner().invoke(app, words)
    assert "a recording is never written over, not with --force either" in str(refused.exception)
    assert kept.read_text() == "mine"


@pytest.mark.parametrize(
    ("words", "says"),
    [
        (("run", "heart.yaml", "--simulate", "--report", "r.pdf"), "name it r.html"),
        (("report", "x.mcap", "-o", "r.pdf"), "name it r.html"),
        (
            ("diagnose", "x.csv", "--robot", "servo-axis.yaml", "--report", "r.pdf"),
            "name it r.html",
        ),
        (("diagnose", "x.txt", "--robot", "servo-axis.yaml"), "deltactl inspect x.txt"),
    ],
)
def test_a_kind_of_file_that_is_not_written_or_read_says_what_to_type(
    words: tuple[str, ...], says: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    from typer.testing import CliRunner

    from deltactl.cli.main import app

    monkeypatch.chdir(tmp_path)
    (tmp_path / "x.txt").write_text("0 1 2\n1 2 3\n")
    refused = CliRunner().invoke(app, [*words])
    assert says in str(refused.exception)
    assert not (tmp_path / "r.pdf").exists()


def test_the_short_word_for_help_helps() -> None:
    from typer.testing import CliRunner

    from deltactl.cli.main import app

    assert CliRunner().invoke(app, ["-h"]).exit_code == 0
    assert "Run a job" in CliRunner().invoke(app, ["run", "-h"]).output
