"""Do the tests notice mistakes? benchmarks/mutation/mutants.py [--folder steps] [--results FILE].

Puts small mistakes into the program one at a time, in a copy of it, and runs those tests of the
folder that run through the changed line, quickest first, until one fails. Known mistakes come
first (benchmarks/mutation/named.yaml), then ones made by rule, spread over the files of
benchmarks/mutation/table.yaml. What survives is listed.
"""

from __future__ import annotations

import argparse
import json
import sys
import tempfile
import time
from pathlib import Path

sys.path.insert(0, str(Path(__file__).resolve().parents[2]))

from benchmarks.mutation.operators import Mutant, mutants_of
from benchmarks.mutation.run import HUNG, KILLED, PROGRAM, SURVIVED, Copy
from benchmarks.mutation.table import EQUIVALENT, NAMED, TABLE, Row

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
        one
        for one in _mutants(row, options.named)
        if (not options.only or options.only in one.name) and _is_due(results, one, options.again)
    ]
    if not due:
        return
    paths = [f"{row.folder}/{name}" for name in row.files]
    watched = list({*paths, *(one.path for one in due)})
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
    found = [one for one in NAMED if one.path.startswith(row.folder)]
    made = [_placed(one.path, one.was, one.now) for one in found]
    for name, count in () if named_only else row.files.items():
        path = f"{row.folder}/{name}"
        made += mutants_of(path, (PROGRAM / path).read_text(), count)
    return list({one.name: one for one in made}.values())


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
        mine = [one.name for one in _mutants(row, named_only) if one.name in results]
        dead = [one for one in mine if results[one]["verdict"] in (KILLED, HUNG)]
        same = [one for one in mine if one in EQUIVALENT and one not in dead]
        total, killed, equal = total + len(mine), killed + len(dead), equal + len(same)
        part = len(dead) / max(1, len(mine) - len(same))
        print(f"{row.folder:24} {len(mine):8d} {len(dead):7d} {len(same):11d} {part:12.1%}")
        for one in mine:
            if one not in dead:
                print(f"    survived: {one}\n        {EQUIVALENT.get(one, 'no test notices')}")
    part = killed / max(1, total - equal)
    print(
        f"{'all':24} {total:8d} {killed:7d} {equal:11d} {part:12.1%}  {time.strftime('%Y-%m-%d')}"
    )
    return int(part < 0.9)


if __name__ == "__main__":
    sys.exit(main())
