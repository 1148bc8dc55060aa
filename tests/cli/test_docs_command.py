"""`deltactl docs` opens the built site in the browser, or says in one line how to get it."""

from __future__ import annotations

import os
import subprocess
import sys
from pathlib import Path

import pytest
from typer.testing import CliRunner

from deltactl.cli import docs
from deltactl.cli.main import app


@pytest.fixture
def site(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    """A built site of three pages, where the command looks for one."""
    folder = tmp_path / "built site"
    for name in ("index", "wiring", "reference/robots"):
        (folder / name).parent.mkdir(parents=True, exist_ok=True)
        (folder / f"{name}.html").write_text("<h1>here</h1>")
    monkeypatch.setattr(docs, "PLACES", (folder,))
    return folder


def test_it_opens_the_page_in_the_browser_that_is_set(tmp_path: Path) -> None:
    """A process of its own: which browser there is, is found out once in a process."""
    (tmp_path / "index.html").touch()
    browser = tmp_path / "browser"
    browser.write_text(f'#!/bin/sh\necho "$1" > {tmp_path}/opened\n')
    browser.chmod(0o755)
    program = (
        "from pathlib import Path; from deltactl.cli import docs, main\n"
        f"docs.PLACES = (Path({str(tmp_path)!r}),)\nmain.app(['docs'])"
    )
    done = subprocess.run(
        [sys.executable, "-c", program],
        env=os.environ | {"BROWSER": str(browser)}, capture_output=True, text=True, check=False,
    )  # fmt: skip
    assert done.returncode == 0, done.stderr
    assert (tmp_path / "opened").read_text().strip() == (tmp_path / "index.html").as_uri()


@pytest.mark.parametrize("typed", ["robots", "reference/robots", "Robots.md", "robots.html"])
def test_a_page_is_found_by_its_name(site: Path, typed: str) -> None:
    done = CliRunner().invoke(app, ["docs", typed, "--path"])
    assert done.output.strip() == str(site / "reference" / "robots.html")


def test_a_page_that_is_not_there_names_the_nearest(site: Path) -> None:
    done = CliRunner().invoke(app, ["docs", "wirring", "--path"])
    assert "wiring" in str(done.exception)


def test_without_a_site_one_line_says_how_to_get_it(tmp_path: Path, monkeypatch) -> None:
    """In a clone, and in an installation, where there is no Makefile."""
    monkeypatch.setattr(docs, "PLACES", (tmp_path,))
    for _ in range(2):
        done = CliRunner().invoke(app, ["docs"])
        assert "site" in str(done.exception)
        assert "\n" not in str(done.exception)
        assert "make" in str(done.exception)
        monkeypatch.setattr(docs, "IMPORT_ROOT", tmp_path)
