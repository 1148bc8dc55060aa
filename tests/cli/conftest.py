"""The command line in an empty folder: in this process."""

from __future__ import annotations

import os
import subprocess
import sys
from collections.abc import Callable
from pathlib import Path

import pytest

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
        from deltactl.cli.main import main

        words = ["deltactl", *map(str, arguments)]
        capfd.readouterr()
        with monkeypatch.context() as here, Path(os.devnull).open() as nothing:
            here.chdir(tmp_path)
            here.setattr(sys, "argv", words)
            here.setattr(sys, "stdin", nothing)
            here.setenv("COLUMNS", "100")
            here.setenv("XDG_RUNTIME_DIR", str(tmp_path))
            try:
                main()
                code = 0
            except SystemExit as ended:
                code = int(ended.code or 0)
        said = capfd.readouterr()
        assert code == status, (said.out, said.err)
        return subprocess.CompletedProcess(words, code, said.out, said.err)

    return run
