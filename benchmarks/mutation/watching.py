"""Which tests run through which lines: looked at once per folder, with the program as it is."""

from __future__ import annotations

import json
import sys
import threading
from collections.abc import Callable, Iterator
from pathlib import Path
from types import FrameType
from typing import Any, NamedTuple

import pytest


class Seen(NamedTuple):
    """Of one test: how long it took [s], and the lines of each watched file that it ran through."""

    took_s: float
    lines: dict[str, set[int]]


class Watcher:
    """A pytest plugin that traces the watched files, and nothing else."""

    def __init__(self, folder: Path, files: list[str]):
        # A folder at the top is imported through the link in the package.
        self._files = {str(folder / name): name for name in files}
        self._files |= {str(folder / "deltactl" / name): name for name in files}
        self._lines: dict[str, set[int]] = {}
        self.took_s: dict[str, float] = {}
        self.lines: dict[str, dict[str, set[int]]] = {}

    @pytest.hookimpl(hookwrapper=True)
    def pytest_runtest_protocol(self, item: pytest.Item) -> Iterator[None]:
        """Trace one test with all that it needs set up."""
        self._lines = {}
        sys.settrace(self._trace)
        threading.settrace(self._trace)
        yield
        sys.settrace(None)
        threading.settrace(None)
        self.lines[item.nodeid] = self._lines

    def pytest_runtest_logreport(self, report: pytest.TestReport) -> None:
        """Add up how long set-up, test and the end of it took."""
        self.took_s[report.nodeid] = self.took_s.get(report.nodeid, 0.0) + report.duration

    def _trace(self, frame: FrameType, event: str, arg: Any) -> Callable[..., Any] | None:
        name = self._files.get(frame.f_code.co_filename)
        if name is None:
            return None
        lines = self._lines.setdefault(name, set())
        lines.add(frame.f_lineno)

        def local(frame: FrameType, event: str, arg: Any) -> Any:
            lines.add(frame.f_lineno)
            return local

        return local

    def write(self, path: Path) -> None:
        """Leave what was seen, and the modules of others that were loaded, for the parent."""
        tests = [
            [name, self.took_s.get(name, 0.0), {k: sorted(v) for k, v in files.items()}]
            for name, files in self.lines.items()
        ]
        path.write_text(json.dumps({"tests": tests, "modules": sorted(sys.modules)}))


class Coverage:
    """What a run of all tests of a folder showed."""

    def __init__(self, tests: dict[str, Seen], modules: list[str]):
        self.tests = tests
        self.modules = modules

    @classmethod
    def read(cls, path: Path) -> Coverage:
        """As a `Watcher` left it."""
        found = json.loads(path.read_text())
        tests = {
            name: Seen(took_s, {file: set(lines) for file, lines in files.items()})
            for name, took_s, files in found["tests"]
        }
        return cls(tests, found["modules"])

    def no_longer_than(self, longest_s: float) -> Coverage:
        """Without tests that take longer: fewer mistakes may be noticed, never more."""
        quick = {name: seen for name, seen in self.tests.items() if seen.took_s <= longest_s}
        return Coverage(quick, self.modules)

    def through(self, file: str, lines: range) -> list[str]:
        """Tests that run through any of these lines, quickest first.

        A line that only runs while its module is loaded: tests that use the file; else all.
        """
        narrow = [n for n, seen in self.tests.items() if seen.lines.get(file, set()) & set(lines)]
        wide = narrow or [name for name, seen in self.tests.items() if seen.lines.get(file)]
        return sorted(wide or self.tests, key=self.took)

    def took(self, name: str) -> float:
        """How long a test takes [s]."""
        return self.tests[name].took_s
