"""The real command line in a process of its own."""

from __future__ import annotations

import os
import subprocess
import sys
from collections.abc import Callable
from pathlib import Path

import pytest

Deltactl = Callable[..., subprocess.CompletedProcess[str]]


@pytest.fixture
def deltactl(tmp_path: Path) -> Deltactl:
    """Run `deltactl ...` in an empty folder; `status` is what it must exit with."""

    def run(*arguments: str, status: int = 0) -> subprocess.CompletedProcess[str]:
        done = subprocess.run(
            [sys.executable, "-m", "deltactl.cli.main", *arguments],
            cwd=tmp_path,
            env=os.environ | {"COLUMNS": "100", "XDG_RUNTIME_DIR": str(tmp_path)},
            capture_output=True,
            text=True,
            timeout=100,
            check=False,
        )
        assert done.returncode == status, (done.stdout, done.stderr)
        return done

    return run
