"""The site is built without a warning, whole, and needs neither another host nor a server."""

from __future__ import annotations

import re
import subprocess
import sys
from pathlib import Path

import pytest

import deltactl
from deltactl.reference.site import notebook_page
from tests.rigs.commands import every_command
from tests.rigs.documented import ROOT

pytestmark = pytest.mark.newcomer
LOADED = re.compile(r"""<(?:script|img|link|iframe)[^>]*(?:src|href)=["'](?:https?:)?//[^"']*""")


@pytest.fixture(scope="module")
def site(tmp_path_factory: pytest.TempPathFactory) -> Path:
    folder = tmp_path_factory.mktemp("site")
    command = [sys.executable, "-m", "deltactl.reference.site", folder / "site", folder / "work"]
    done = subprocess.run(command, cwd=ROOT, capture_output=True, text=True, check=False)
    assert (done.returncode, done.stderr) == (0, ""), done.stdout
    return folder / "site"


def test_no_page_loads_from_another_host(site: Path) -> None:
    pages = sorted(site.rglob("*.html"))
    assert len(pages) > 30
    assert [found for page in pages for found in LOADED.findall(page.read_text("utf-8"))] == []
    styles = "".join(path.read_text("utf-8") for path in site.rglob("*.css"))
    assert not re.search(r"url\([\"']?(?:https?:)?//", styles)


def test_the_search_reads_a_script_and_no_other_page(site: Path) -> None:
    """A page that is opened as a file may load scripts; it may fetch nothing."""
    assert (site / "searchindex.js").read_text("utf-8").startswith("Search.setIndex(")
    options = (site / "_static" / "documentation_options.js").read_text("utf-8")
    assert "SHOW_SEARCH_SUMMARY: false" in options


def test_every_command_and_public_name_has_its_place(site: Path) -> None:
    commands = (site / "reference" / "commands.html").read_text("utf-8")
    shown = set(re.findall(r'<span class="pre">(\w[\w -]*)</span>', commands))
    names = {name for name, command in every_command() if not command.hidden}
    assert {word for name in names for word in name.split()} <= shown
    python = (site / "reference" / "python.html").read_text("utf-8")
    assert [name for name in deltactl.__all__ if f'id="deltactl.{name}"' not in python] == []


def test_a_notebook_shows_its_text_its_code_and_what_it_printed() -> None:
    cells = (
        '{"cells": [{"cell_type": "markdown", "source": ["# A title"]},'
        '{"cell_type": "code", "source": ["1 + 1"], "outputs": [{"data": {"text/plain": ["2"]}}]}]}'
    )
    assert notebook_page(cells) == "# A title\n\n```python\n1 + 1\n```\n\n```text\n2\n```"
