"""Answers of drawn machines on a screen of 25 lines at 80 columns.

    python -m benchmarks.proofs.one_screen --keep DIR [--seed 9402] [--axes 36] [--arms 12]
      [--deltas 14] [--label LABEL]

Deltas, single axes by command and by effort, range sensors and measured arms are drawn, diagnosed
and shown as `deltactl diagnose` shows them. `--label` adds all answers that
`benchmarks.proofs.frozen_answers make LABEL --keep DIR` has kept. Answers are kept in
DIR/answers/one_screen, and made once.

Exit status 1 when an answer has more lines, a longer line, no verdict at its beginning, or no word
of where the rest is at its end.
"""

from __future__ import annotations

import argparse
import contextlib
import gzip
import io
import json
import sys
from collections import defaultdict
from collections.abc import Callable, Iterator, Mapping, Sequence
from functools import partial
from pathlib import Path
from typing import Any, NamedTuple

from rich.text import Text

from benchmarks.proofs import measured_arm, measured_poses
from benchmarks.proofs.frozen_answers import answer_file, write
from deltactl.cli.recordings.init_chain import chain
from deltactl.diagnosis.answer.records import Diagnosis
from deltactl.diagnosis.report.screen import WIDTH, marked, screen_lines
from deltactl.diagnosis.report.templates import TERMINAL
from deltactl.foundation.one_screen import LINES
from deltactl.models.robot import RobotModel
from deltactl.models.robot_files import load_with_effects
from deltactl.proof import cases
from deltactl.proof.axis import cases as axis_cases
from deltactl.proof.prove.one_case import diagnose_blind

KEPT = "one_screen"
Kept = Mapping[str, Any]


class Shown(NamedTuple):
    """An answer on the screen."""

    lines: int
    columns: int
    complete: bool
    """Whether it begins with the verdict and ends with where the rest is."""

    @property
    def fits(self) -> bool:
        """Whether a terminal shows all of it at once."""
        return self.complete and self.lines <= LINES and self.columns <= WIDTH


def on_screen(answer: Diagnosis, robot: RobotModel | None) -> Shown:
    """Measure what the terminal shows of an answer."""
    lines = screen_lines(answer, robot)
    plain = [Text.from_markup(one).plain for one in marked(lines)]
    ends = TERMINAL.rest.split()[0]
    complete = bool(lines) and lines[0].head and any(one.startswith(ends) for one in plain[-3:])
    return Shown(len(plain), max(map(len, plain), default=0), complete)


def delta(folder: Path, seed: int, number: int) -> tuple[str, Path]:
    """Write a drawn delta; its kind, and its robot file."""
    case = cases.draw(seed, number)
    cases.write_blind(case, folder, seed)
    return "delta", folder / cases.ROBOT_FILE


def axis(folder: Path, seed: int, number: int) -> tuple[str, Path]:
    """The same for a single axis or a range sensor."""
    case = axis_cases.draw(seed + number)
    axis_cases.write_blind(case, folder)
    return f"axis, {case.design.machine}", folder / cases.ROBOT_FILE


def arm(folder: Path, seed: int, number: int) -> tuple[str, Path]:
    """The same for an arm that was measured at rest."""
    folder.mkdir(parents=True, exist_ok=True)
    hidden, _, poses = measured_poses.drawn(seed, number)
    (folder / "arm.urdf").write_text(measured_arm.urdf_text())
    with contextlib.redirect_stdout(io.StringIO()):
        chain(folder / cases.ROBOT_FILE, folder / "arm.urdf")
    rows = measured_arm.table(folder, measured_arm.measured(hidden, poses, number))
    (folder / cases.RECORDING).write_bytes(gzip.compress(rows.read_bytes()))
    return "arm, measured at rest", folder / cases.ROBOT_FILE


def drawn(options: argparse.Namespace) -> Iterator[Kept]:
    """The answers of all drawn machines, each made once."""
    wanted: dict[Callable[[Path, int, int], tuple[str, Path]], int] = {
        axis: options.axes,
        arm: options.arms,
        delta: options.deltas,
    }
    for make, count in wanted.items():
        for number in range(count):
            name = f"{make.__name__}_{options.seed}_{number:04d}"
            file = answer_file(options.keep, KEPT, name)
            if not file.exists():
                folder = options.keep / "cases" / name
                write(file, _answered(name, folder, partial(make, folder, options.seed, number)))
            yield json.loads(file.read_text())


def _answered(name: str, folder: Path, make: Callable[[], tuple[str, Path]]) -> Kept:
    kind, robot = make()
    answer, failure = diagnose_blind(folder)
    return {"name": name, "kind": kind, "robot": str(robot), "answer": answer, "failure": failure}


def frozen(keep: Path, label: str) -> Iterator[Kept]:
    """The answers that `frozen_answers` has kept under a label."""
    for file in sorted(answer_file(keep, label, "x").parent.glob("*.json")):
        yield {"name": file.stem, "kind": f"frozen {label}", **json.loads(file.read_text())}


def table(answers: Iterator[Kept]) -> int:
    """Print what each kind takes at most, and each answer that does not fit; how many do not."""
    found: dict[str, list[Shown]] = defaultdict(list)
    refused: dict[str, int] = defaultdict(int)
    for one in answers:
        if one["answer"] is None:
            refused[one["kind"]] += 1
            continue
        robot = load_with_effects(Path(one["robot"])) if one.get("robot") else None
        shown = on_screen(Diagnosis.model_validate(one["answer"]), robot)
        found[one["kind"]].append(shown)
        if not shown.fits:
            print(f"{one['name']}: {shown.lines} lines, {shown.columns} columns, {shown.complete}")
    print(f"{'kind':24} shown refused  most lines  most columns  beyond")
    for kind in sorted({*found, *refused}):
        rows = found[kind]
        most = [max((one[n] for one in rows), default=0) for n in (0, 1)]
        beyond = sum(not one.fits for one in rows)
        print(f"{kind:24} {len(rows):5} {refused[kind]:7} {most[0]:11} {most[1]:13} {beyond:7}")
    return sum(not one.fits for rows in found.values() for one in rows)


def main(words: Sequence[str] | None = None) -> int:
    """Exit status 1 when an answer does not fit."""
    parser = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    parser.add_argument("--keep", type=Path, required=True, metavar="DIR")
    parser.add_argument("--seed", type=int, default=9402)
    parser.add_argument("--axes", type=int, default=36)
    parser.add_argument("--arms", type=int, default=12)
    parser.add_argument("--deltas", type=int, default=14)
    parser.add_argument("--label", action="append", default=[])
    options = parser.parse_args(words)
    kept = (one for label in options.label for one in frozen(options.keep, label))
    return int(table(one for part in (kept, drawn(options)) for one in part) > 0)


if __name__ == "__main__":
    sys.exit(main())
