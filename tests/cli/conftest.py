"""The command line in an empty folder: in this process."""

from __future__ import annotations

import os
import subprocess
import sys
from collections.abc import Callable
from pathlib import Path

import pytest

from tests.rigs.in_process import called

Deltactl = Callable[..., subprocess.CompletedProcess[str]]


@pytest.fixture
def deltactl(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capfd: pytest.CaptureFixture[str]
) -> Deltactl:
    """Run `deltactl ...` in an empty folder; `status` is what it must exit with.

    The entry point is called here: to start Python and import everything anew takes longer than
    most of the commands do.
    """

    def run(*arguments: str, status: int = 0) -> subprocess.CompletedProcess[str]:
        with monkeypatch.context() as here, Path(os.devnull).open() as nothing:
            here.chdir(tmp_path)
            here.setattr(sys, "stdin", nothing)
            here.setenv("COLUMNS", "100")
            here.setenv("XDG_RUNTIME_DIR", str(tmp_path))
            done = called(arguments, capfd)
        assert done.returncode == status, (done.stdout, done.stderr)
        return done

    return run
