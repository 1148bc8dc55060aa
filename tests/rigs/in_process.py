"""Commands called in the process of their test: Python is not started anew."""

from __future__ import annotations

import subprocess
import sys
from collections.abc import Sequence

import pytest


def called(
    words: Sequence[object], capture: pytest.CaptureFixture[str]
) -> subprocess.CompletedProcess[str]:
    """What `deltactl WORDS` prints, and its exit status."""
    from deltactl.cli.main import main

    typed = ["deltactl", *map(str, words)]
    capture.readouterr()
    code = 0
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(sys, "argv", typed)
        try:
            main()
        except SystemExit as ended:
            code = int(ended.code or 0)
    said = capture.readouterr()
    return subprocess.CompletedProcess(typed, code, said.out, said.err)
