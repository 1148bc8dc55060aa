"""Questions of `init` are broken between words, as everything else is."""

from __future__ import annotations

import os
import pty
import re
import subprocess
import sys
import time
from pathlib import Path

ENOUGH = 8
"""Questions that are looked at."""


def test_no_question_is_wider_than_the_window(tmp_path: Path) -> None:
    """In a terminal of 80 columns, each answered with a number."""
    ours, theirs = pty.openpty()
    process = subprocess.Popen(
        [sys.executable, "-m", "deltactl.cli.main", "init", "delta", "mine.yaml"],
        stdin=theirs, stdout=theirs, stderr=theirs, cwd=tmp_path,
        env={**os.environ, "COLUMNS": "80"},
    )  # fmt: skip
    os.close(theirs)
    said, asked, until_s = "", 0, time.monotonic() + 60.0
    try:
        while asked < ENOUGH and time.monotonic() < until_s:
            said += os.read(ours, 10_000).decode()
            if re.search(r": $", said) and not said.endswith("\n"):
                os.write(ours, b"150\n")
                said, asked = f"{said}\n", asked + 1
    except OSError:
        pass  # it ended
    process.kill()
    process.wait()
    os.close(ours)
    assert asked >= 2, said
    assert max(map(len, said.splitlines())) <= 80, said
