"""What README and docs tell a newcomer to type, typed on a clean clone, in the order it stands.

Takes some minutes, and downloads what `make run` installs: `make newcomer`.
"""

from __future__ import annotations

import os
import shutil
import subprocess
from collections.abc import Iterator
from pathlib import Path

import pytest

from tests.rigs.documented import PAGES, ROOT, fenced

pytestmark = pytest.mark.newcomer
TYPED = {page: [one for one in fenced(page) if not one.why] for page in PAGES}
LONGEST_S = 1800
_BROKEN = ("Traceback (most recent call last)", "Warning:")


@pytest.fixture(scope="module")
def clone(tmp_path_factory: pytest.TempPathFactory) -> Iterator[Path]:
    """A clean clone of what is committed here."""
    folder = tmp_path_factory.mktemp("newcomer") / "deltactl"
    subprocess.run(["git", "clone", "--quiet", str(ROOT), str(folder)], check=True)
    yield folder
    shutil.rmtree(folder)


def test_the_small_install_says_how_to_get_the_diagnosis(clone: Path) -> None:
    """As on a Pi, where pip brings no scipy; what it says is then typed, and helps."""
    _typed(clone, "make run WITH=")
    _typed(clone, "rm -r .venv/lib/python*/site-packages/scipy*")
    refused = _run(clone, ".venv/bin/deltactl diagnose none.csv --robot zhao-2023.yaml")
    assert refused.returncode == 2
    assert "Traceback" not in refused.stderr
    _typed(clone, "source .venv/bin/activate\n" + refused.stderr.strip().split("type: ")[1])
    there = _run(clone, ".venv/bin/deltactl diagnose none.csv --robot zhao-2023.yaml")
    assert "none.csv" in there.stderr
    shutil.rmtree(clone / ".venv")


@pytest.mark.parametrize("page", [page for page in PAGES if TYPED[page]], ids=lambda p: p.name)
def test_a_page_typed_from_top_to_bottom(clone: Path, page: Path) -> None:
    """README comes first, and makes the environment that the others use."""
    commands = [one.text for one in TYPED[page]]
    if page.name != "README.md":
        commands = ["source .venv/bin/activate", *commands]
    _typed(clone, "\n".join(commands))


def _typed(clone: Path, script: str) -> None:
    done = _run(clone, script)
    assert done.returncode == 0, (done.stdout[-2000:], done.stderr[-2000:])
    assert not any(words in done.stderr for words in _BROKEN), done.stderr[-2000:]


def _run(clone: Path, script: str) -> subprocess.CompletedProcess[str]:
    """In a shell without this test's environment, that stops at the first failure."""
    kept = {k: v for k, v in os.environ.items() if k not in ("VIRTUAL_ENV", "PYTHONPATH")}
    own = str(ROOT / ".venv" / "bin")
    path = os.pathsep.join(p for p in kept["PATH"].split(os.pathsep) if p != own)
    return subprocess.run(
        ["bash", "-e", "-c", script], cwd=clone, env=kept | {"PATH": path},
        capture_output=True, text=True, timeout=LONGEST_S, check=False,
    )  # fmt: skip
