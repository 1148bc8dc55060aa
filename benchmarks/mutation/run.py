"""Runs tests against mutants: in a copy of the program, one fork of a warm interpreter each."""

from __future__ import annotations

import compileall
import os
import py_compile
import shutil
import signal
import subprocess
import sys
import time
from collections.abc import Iterator
from contextlib import contextmanager, suppress
from pathlib import Path
from typing import NamedTuple

from benchmarks.mutation.operators import Mutant

PROGRAM = Path(__file__).resolve().parents[2]
KILLED, SURVIVED, HUNG = "killed", "survived", "hung"
LOG = "pytest.log"
"""What the last tests said, in the copy."""
PATIENCE, LEAST_S = 4.0, 30.0
"""A mutant that takes so many times as long as the unchanged program hangs."""


class Outcome(NamedTuple):
    """What the tests made of it, and how long they took."""

    verdict: str
    took_s: float


class Copy:
    """A copy of the program in which mutants are put; never the program itself."""

    def __init__(self, folder: Path):
        self.folder = folder
        listed = subprocess.run(
            ["git", "ls-files", "-z"], cwd=PROGRAM, check=True, capture_output=True, text=True
        )
        for name in listed.stdout.split("\0"):
            if name and (PROGRAM / name).is_file():
                (folder / name).parent.mkdir(parents=True, exist_ok=True)
                shutil.copy(PROGRAM / name, folder / name)
        # Compiled by what the source says, not by its date: a mutant is always noticed.
        checked = py_compile.PycInvalidationMode.CHECKED_HASH
        for package in folder.iterdir():
            if package.is_dir():
                compileall.compile_dir(package, quiet=2, invalidation_mode=checked)
        _warm_up(folder)

    @contextmanager
    def with_mutant(self, mutant: Mutant) -> Iterator[None]:
        """The mutant in its place, for a while."""
        path = self.folder / mutant.path
        text = path.read_text()
        path.write_text(mutant.apply(text))
        try:
            yield
        finally:
            path.write_text(text)

    def test(self, test: str, limit_s: float) -> Outcome:
        """Run a file of tests until the first that fails."""
        start_s = time.monotonic()
        child = os.fork()
        if child == 0:
            _run_tests(self.folder, test)
        while time.monotonic() - start_s < limit_s:
            ended, status = os.waitpid(child, os.WNOHANG)
            if ended:
                _end_group(child)
                good = os.waitstatus_to_exitcode(status) == 0
                return Outcome(SURVIVED if good else KILLED, time.monotonic() - start_s)
            time.sleep(0.02)
        _end_group(child)
        os.waitpid(child, 0)
        return Outcome(HUNG, time.monotonic() - start_s)


def limit_s(usual_s: float) -> float:
    """When a mutant counts as hanging."""
    return max(LEAST_S, PATIENCE * usual_s)


def _warm_up(folder: Path) -> None:
    """Load what is not ours once, for all forks; the program's own modules are left out."""
    import hypothesis
    import numpy
    import pydantic
    import pytest
    import yaml

    del hypothesis, numpy, pydantic, pytest, yaml
    os.environ |= {"PYTHONDONTWRITEBYTECODE": "1", "PYTHONPATH": str(folder)}
    sys.dont_write_bytecode = True


def _run_tests(folder: Path, test: str) -> None:
    """In the fork; does not return. A group of its own, so that nothing is left behind."""
    code = 3
    try:
        os.setpgid(0, 0)
        os.chdir(folder)
        others = (one for one in sys.path if Path(one or ".").resolve() not in (PROGRAM, folder))
        sys.path[:] = [str(folder), *others]
        for name in [name for name in sys.modules if name.split(".")[0] == "benchmarks"]:
            del sys.modules[name]
        silent = os.open(folder / LOG, os.O_RDWR | os.O_CREAT | os.O_TRUNC)
        for stream in (0, 1, 2):
            os.dup2(silent, stream)
        import pytest

        known = "ignore::pytest.PytestAssertRewriteWarning"  # it was loaded once for all
        words = ["-x", "-q", "-p", "no:xdist", "-W", known, "-m", "not realtime and not hil"]
        code = int(pytest.main([*words, test]))
    finally:
        os._exit(code)


def _end_group(leader: int) -> None:
    with suppress(ProcessLookupError, PermissionError):
        os.killpg(leader, signal.SIGKILL)
