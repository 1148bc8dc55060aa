"""Do the tests notice mistakes? benchmarks/mutation/mutants.py [--folder steps] [--results FILE].

Puts small mistakes into the program one at a time, in a copy of it, and runs those tests of the
folder that run through the changed line, quickest first, until one fails. Known mistakes come
first (benchmarks/mutation/named.yaml), then ones made by rule, spread over the files of
benchmarks/mutation/table.yaml. What survives is listed.
"""

from __future__ import annotations

import argparse
import compileall
import importlib
import json
import os
import py_compile
import shutil
import signal
import subprocess
import sys
import tempfile
import threading
import time
from collections.abc import Callable, Iterator, Sequence
from contextlib import contextmanager, suppress
from functools import partial
from pathlib import Path
from types import FrameType
from typing import Any, NamedTuple

import pytest

sys.path.insert(0, str(Path(__file__).resolve().parents[2]))

from benchmarks.mutation.mistakes import EQUIVALENT, NAMED, TABLE, Mutant, Row, mutants_of


class Seen(NamedTuple):
    """How long one test took [s], and the lines of each watched file that it ran through."""

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


PROGRAM = Path(__file__).resolve().parents[2]
KILLED, SURVIVED, HUNG = "killed", "survived", "hung"
LOG = "pytest.log"
"""What the last tests said, in the copy."""
LOOK_S = 0.02
PATIENCE, LEAST_S = 4.0, 12.0
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
            if name and (PROGRAM / name).exists():
                (folder / name).parent.mkdir(parents=True, exist_ok=True)
                shutil.copy(PROGRAM / name, folder / name, follow_symlinks=False)
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
        if text[mutant.start : mutant.end] != mutant.was:
            raise SystemExit(f"{mutant.path} was changed since this run began; start it again")
        path.write_text(mutant.apply(text))
        try:
            yield
        finally:
            path.write_text(text)

    def watched(self, tests: Sequence[str], files: list[str]) -> Coverage:
        """All tests of a folder with the program as it is, and which lines each runs through."""
        left = self.folder / "watched.json"
        outcome = _forked(
            partial(_run_tests, self.folder, tests, Watcher(self.folder, files), left), 1800.0
        )
        if outcome.verdict != SURVIVED:
            raise SystemExit(f"{' '.join(tests)}: fails without any mistake; see {self.log}")
        seen = Coverage.read(left)
        _load(seen.modules)
        return seen

    def test(self, tests: Sequence[str], usual_s: float) -> Outcome:
        """Run tests, which usually take so long, until the first that fails."""
        limit_s = max(LEAST_S, PATIENCE * usual_s)
        return _forked(partial(_run_tests, self.folder, tests), limit_s)

    @property
    def log(self) -> str:
        """What the last tests said."""
        return (self.folder / LOG).read_text()[-2000:]


def _forked(work: Callable[[], None], limit_s: float) -> Outcome:
    """Do it in a fork, which ends with the status of the tests."""
    start_s, looks = time.monotonic(), 0
    child = os.fork()
    if child == 0:
        work()
    # Patience is counted in looks, not by the clock: on a busy machine they come more slowly.
    while looks * LOOK_S < limit_s:
        ended, status = os.waitpid(child, os.WNOHANG)
        if ended:
            _end_group(child)
            good = os.waitstatus_to_exitcode(status) == 0
            return Outcome(SURVIVED if good else KILLED, time.monotonic() - start_s)
        time.sleep(LOOK_S)
        looks += 1
    _end_group(child)
    os.waitpid(child, 0)
    return Outcome(HUNG, time.monotonic() - start_s)


def _load(modules: list[str]) -> None:
    """Load what is not ours once, for all forks; the program's own modules are left out."""
    for name in modules:
        found = sys.modules.get(name) or _not_ours(name)
        if found:
            with suppress(Exception):
                importlib.import_module(name)


def _not_ours(name: str) -> bool:
    top = name.split(".")[0]
    return not (PROGRAM / top).exists() and top not in ("conftest", "tests")


def _warm_up(folder: Path) -> None:
    """Forks take up the copy, and nothing of the program itself."""
    os.environ |= {"PYTHONDONTWRITEBYTECODE": "1", "PYTHONPATH": str(folder)}
    os.environ["HYPOTHESIS_PROFILE"] = "mutants"
    sys.dont_write_bytecode = True


def _run_tests(
    folder: Path, tests: Sequence[str], watcher: Watcher | None = None, left: Path | None = None
) -> None:
    """In the fork; does not return. A group of its own, so that nothing is left behind."""
    code = 3
    try:
        os.setpgid(0, 0)
        os.chdir(folder)
        others = (
            place for place in sys.path if Path(place or ".").resolve() not in (PROGRAM, folder)
        )
        sys.path[:] = [str(folder), *others]
        for name in [name for name in sys.modules if name.split(".")[0] == "benchmarks"]:
            del sys.modules[name]
        silent = os.open(folder / LOG, os.O_RDWR | os.O_CREAT | os.O_TRUNC)
        for stream in (0, 1, 2):
            os.dup2(silent, stream)
        known = "ignore::pytest.PytestAssertRewriteWarning"  # it was loaded once for all
        words = ["-x", "-q", "-p", "no:xdist", "-W", known, "-m", "not realtime and not hil"]
        code = int(pytest.main([*words, *tests], [watcher] if watcher else []))
        if watcher and left:
            watcher.write(left)
    finally:
        os._exit(code)


def _end_group(leader: int) -> None:
    with suppress(ProcessLookupError, PermissionError):
        os.killpg(leader, signal.SIGKILL)


Results = dict[str, dict[str, str]]


def main() -> int:
    """Exit status 1 when less than nine in ten of those that are not equivalent are noticed."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--folder", action="append", help="only folders whose name holds this")
    parser.add_argument("--only", help="only mutants whose name holds this")
    parser.add_argument("--named", action="store_true", help="only the known mistakes")
    parser.add_argument(
        "--again", action="store_true", help="those that survived and have no reason, once more"
    )
    parser.add_argument("--list", action="store_true", help="only say which there are")
    parser.add_argument(
        "--longest", type=float, default=float("inf"), help="leave out tests that take longer [s]"
    )
    parser.add_argument("--results", type=Path, help="go on from here, and write here")
    options = parser.parse_args()
    rows = [
        row for row in TABLE if not options.folder or any(f in row.folder for f in options.folder)
    ]
    results = _known(options.results)
    if options.list:
        for row in rows:
            print("\n".join(mutant.name for mutant in _mutants(row, options.named)))
        return 0
    with tempfile.TemporaryDirectory(prefix="deltactl-mutants-") as folder:
        copy = Copy(Path(folder))
        for row in rows:
            _row(copy, row, results, options)
    return _report(results, rows, options.named)


def _row(copy: Copy, row: Row, results: Results, options: argparse.Namespace) -> None:
    """All mutants of a folder that are not known yet."""
    due = [
        mutant
        for mutant in _mutants(row, options.named)
        if (not options.only or options.only in mutant.name)
        and _is_due(results, mutant, options.again)
    ]
    if not due:
        return
    paths = [f"{row.folder}/{name}" for name in row.files]
    watched = list({*paths, *(mutant.path for mutant in due)})
    coverage = copy.watched(row.tests, watched).no_longer_than(options.longest)
    usual_s = sum(map(coverage.took, coverage.tests))
    print(f"{row.folder}: {len(due)} mutants, {usual_s:.0f} s of tests", flush=True)
    for mutant in due:
        tests = coverage.through(mutant.path, mutant.lines)
        with copy.with_mutant(mutant):
            outcome = copy.test(tests, sum(map(coverage.took, tests)))
        results[mutant.name] = {"folder": row.folder, "verdict": outcome.verdict}
        print(f"  {outcome.verdict:8} {outcome.took_s:5.1f} s  {mutant.name}", flush=True)
        if options.results:
            options.results.write_text(json.dumps(results, indent=1))


def _mutants(row: Row, named_only: bool) -> list[Mutant]:
    found = [known for known in NAMED if known.path.startswith(row.folder)]
    made = [_placed(known.path, known.was, known.now) for known in found]
    for name, count in () if named_only else row.files.items():
        path = f"{row.folder}/{name}"
        made += mutants_of(path, (PROGRAM / path).read_text(), count)
    return list({mutant.name: mutant for mutant in made}.values())


def _placed(path: str, was: str, now: str) -> Mutant:
    text = (PROGRAM / path).read_text()
    if text.count(was) != 1:
        raise SystemExit(f"{path}: {was!r} stands there {text.count(was)} times; mend the table")
    start = text.index(was)
    lines = range(text[:start].count("\n") + 1, text[: start + len(was.rstrip())].count("\n") + 2)
    return Mutant(path, start, start + len(was), was, now, "named", lines)


def _is_due(results: Results, mutant: Mutant, again: bool) -> bool:
    known = results.get(mutant.name)
    if known is None:
        return True
    return again and known["verdict"] == SURVIVED and mutant.name not in EQUIVALENT


def _known(path: Path | None) -> Results:
    if path is None or not path.exists():
        return {}
    known: Results = json.loads(path.read_text())
    return known


def _report(results: Results, rows: list[Row], named_only: bool) -> int:
    """The table, and the survivors with their reasons."""
    print(f"{'folder':24} {'mutants':>8} {'killed':>7} {'equivalent':>11} {'of the rest':>12}")
    total = killed = equal = 0
    for row in rows:
        mine = [mutant.name for mutant in _mutants(row, named_only) if mutant.name in results]
        dead = [name for name in mine if results[name]["verdict"] in (KILLED, HUNG)]
        same = [name for name in mine if name in EQUIVALENT and name not in dead]
        total, killed, equal = total + len(mine), killed + len(dead), equal + len(same)
        part = len(dead) / max(1, len(mine) - len(same))
        print(f"{row.folder:24} {len(mine):8d} {len(dead):7d} {len(same):11d} {part:12.1%}")
        for name in mine:
            if name not in dead:
                print(f"    survived: {name}\n        {EQUIVALENT.get(name, 'no test notices')}")
    part = killed / max(1, total - equal)
    print(
        f"{'all':24} {total:8d} {killed:7d} {equal:11d} {part:12.1%}  {time.strftime('%Y-%m-%d')}"
    )
    return int(part < 0.9)


if __name__ == "__main__":
    sys.exit(main())
