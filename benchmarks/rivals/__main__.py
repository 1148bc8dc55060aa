"""Beside other tools: the same machines, one table.

    python -m benchmarks.rivals [--axes 20] [--deltas N] [--arms N] [--real FOLDER] [--halves]
        [--seed 1] [--minutes M] [--keep]

deltactl, lmfit with BIC, PySINDy, a textbook's inverse dynamic model and mujoco.sysid get the same
files: drawn single axes, half of them healthy (cases.py), and real recordings (real.py). On drawn
deltas (deltas.py) lmfit, a printer's calibration and mujoco.sysid run beside it, on drawn and real
arms (arms.py) the textbook's model, FIGAROH and mujoco.sysid. Protocols of the others are in
tools_outside.py, delta_tools.py, delta_sysid.py, arm_tools.py and inverse_sysid.py. They run in a
second virtual
environment, which this command makes in build/rivals/venv from benchmarks/rivals/constraints.txt;
each tool has one process on one core.
Written to --out (build/rivals/out): the cases, an answers file a tool, a table a group with what
each tool named otherwise, and drawings of the shares.
"""

from __future__ import annotations

import argparse
import os
import platform
import shutil
import subprocess
import sys
from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass
from functools import partial
from math import inf
from pathlib import Path
from typing import NoReturn

from benchmarks.rivals.arms import scored_arms, write_arms
from benchmarks.rivals.cases import (
    Answers,
    Scored,
    by_deltactl,
    cut_in_halves,
    drawn,
    read_answers,
    scored,
    write_cases,
)
from benchmarks.rivals.deltas import scored_deltas, write_deltas
from benchmarks.rivals.picture import drawing
from benchmarks.rivals.real import ARMS, SINGLE, judged, write_real
from benchmarks.rivals.table import column, markdown, wrong
from deltactl.foundation.errors import ConfigError
from deltactl.foundation.release import own_version

ROOT = Path(__file__).parents[2]
HOME = ROOT / "build" / "rivals"
CONSTRAINTS = Path(__file__).with_name("constraints.txt")
OUTSIDE = ("lmfit", "PySINDy", "textbook")
OUTSIDE_OF_AXES = (*OUTSIDE, "sysid, true set", "sysid, all")
OUTSIDE_OF_ARMS = ("textbook", "FIGAROH", "sysid, true set", "sysid, all")
OUTSIDE_OF_REAL_ARMS = ("textbook", "FIGAROH", "sysid, all")
OUTSIDE_OF_REAL_AXES = (*OUTSIDE, "sysid, all")
OUTSIDE_OF_DELTAS = ("lmfit", "Klipper", "sysid, true set", "sysid, all")
NEED_NOTHING = ("textbook", "Klipper")
"""Tools that run in this environment too."""
ONE_CORE = dict.fromkeys(("OMP_NUM_THREADS", "OPENBLAS_NUM_THREADS", "MKL_NUM_THREADS"), "1")


def environment(folder: Path = HOME / "venv") -> Path:
    """Python of the second environment, made anew where the constraints changed.

    Raises ConfigError where it cannot be made.
    """
    python, made = folder / "bin" / "python", folder / "made-from.txt"
    wanted = CONSTRAINTS.read_text(encoding="utf-8")
    if made.is_file() and made.read_text(encoding="utf-8") == wanted:
        return python
    commands: list[list[str]] = [
        [sys.executable, "-m", "venv", "--clear", str(folder)],
        [str(python), "-m", "pip", "install", "-q", "--no-deps", "-r", str(CONSTRAINTS)],
    ]
    for command in commands:
        done = subprocess.run(command, capture_output=True, text=True, check=False)
        if done.returncode:
            last = (done.stderr or done.stdout).strip().splitlines()[-1:] or ["no message"]
            raise ConfigError(f"cannot make {folder}: {' '.join(command[1:4])}: {last[0]}")
    made.write_text(wanted, encoding="utf-8")
    return python


def outside(python: Path, tool: str, cases: Path, out: Path, most_s: float) -> None:
    """Let a tool answer every case in a process of the second environment."""
    command = [str(python), "-m", "benchmarks.rivals.tools_outside"]
    command += [tool, str(cases), str(out), str(most_s)]
    own = {name: value for name, value in os.environ.items() if name != "PYTHONPATH"}
    done = subprocess.run(command, cwd=ROOT, env=own | ONE_CORE, check=False)
    if done.returncode:
        raise ConfigError(f"{tool} ended with status {done.returncode}; its error is above")


def versions(here: bool) -> str:
    """What ran, and on what kind of machine."""
    pinned = CONSTRAINTS.read_text(encoding="utf-8").split()
    named = () if here else ("lmfit", "pysindy", "mujoco", "figaroh")
    tools = [line.replace("==", " ") for line in pinned if line.startswith(named)]
    own = [f"deltactl {own_version()}", *tools, f"Python {platform.python_version()}"]
    return f"{', '.join(own)}; {platform.machine()}, {os.cpu_count()} cores"


@dataclass(frozen=True)
class Group:
    """Machines of one kind: their cases in a folder, who answers, and who scores."""

    title: str
    folder: Path
    tools: Sequence[str]
    score: Callable[[Answers], list[Scored]]


def compare(group: Group, options: argparse.Namespace) -> tuple[str, dict[str, dict[str, str]]]:
    """Run every tool, or those of this environment; the table as Markdown and as it is drawn."""
    if options.halves:
        cut_in_halves(group.folder)
    columns, mistakes, short, here = {}, "", "", options.here
    python = Path(sys.executable) if here else environment()
    for tool in ("deltactl", *(one for one in group.tools if not here or one in NEED_NOTHING)):
        print(f"{group.title}: {tool} ...", file=sys.stderr, flush=True)
        out = group.folder.with_name(
            f"{group.folder.name}-{tool.replace(', ', '-').replace(' ', '-')}.json"
        )
        if not (options.keep and out.exists()):
            if tool == "deltactl":
                by_deltactl(group.folder, out, 60.0 * options.minutes)
            else:
                outside(python, tool, group.folder, out, 60.0 * options.minutes)
        answers = read_answers(out)
        if left := answers.unbegun():
            of = len(answers.by_case)
            short += f"- {tool}: {of - left} of {of} cases in {options.minutes:g} minutes\n"
        own = group.score(answers)
        columns[tool] = column(tool, own, answers.peak_mb)
        mistakes += wrong(tool, own)
    text = f"{group.title}; {versions(here)}\n\n{markdown(columns)}{short}"
    group.folder.with_name(f"{group.folder.name}.md").write_text(
        f"{text}\n## Named otherwise\n\n{mistakes}", encoding="utf-8"
    )
    return text, columns


def axes(count: int, seed: int, out: Path) -> Group:
    """Drawn single axes."""
    folder = _empty(out / f"axes-{seed}")
    truths = write_cases(drawn(count, seed), folder)
    return Group(
        f"{count} single axes, seed {seed}", folder, OUTSIDE_OF_AXES, partial(scored, truths)
    )


def deltas(count: int, seed: int, out: Path) -> Group:
    """Drawn deltas."""
    folder = _empty(out / f"deltas-{seed}")
    truths = write_deltas(count, seed, folder)
    score = partial(scored_deltas, truths)
    return Group(f"{count} deltas, seed {seed}", folder, OUTSIDE_OF_DELTAS, score)


def arms(count: int, seed: int, out: Path) -> Group:
    """Drawn arms, by the second environment."""
    folder = _empty(out / f"arms-{seed}")
    truths = write_arms(environment(), ROOT, count, seed, folder)
    return Group(
        f"{count} arms, seed {seed}", folder, OUTSIDE_OF_ARMS, partial(scored_arms, truths)
    )


def real(given: Path, out: Path, here: bool) -> Iterator[Group]:
    """Real recordings, of single axes and of arms; prints what is left out and why."""
    groups = (
        ("recordings", SINGLE, OUTSIDE_OF_REAL_AXES),
        ("arms", ARMS, OUTSIDE_OF_REAL_ARMS),
    )
    for name, kinds, tools in groups:
        folder = _empty(out / f"real-{name}")
        known, skipped = write_real(given, folder, kinds)
        for line in skipped:
            print(f"left out of {name}: {line}", file=sys.stderr)
        title = f"{len(known)} real {name}, {len(skipped)} entries left out"
        others = () if here and name == "arms" else tools
        if known:
            yield Group(title, folder, others, partial(judged, known, group=f"real {name}"))


def _empty(folder: Path) -> Path:
    shutil.rmtree(folder, ignore_errors=True)
    folder.mkdir(parents=True)
    return folder


DRAWN = {"axes": axes, "deltas": deltas, "arms": arms}


def _refuse_wrong(options: argparse.Namespace, refuse: Callable[[str], NoReturn]) -> None:
    for name in DRAWN:
        count = getattr(options, name)
        if count < 0 or count == 1:
            refuse(f"--{name} {count}: 0, or at least a healthy one and another")
    if options.seed < 0:
        refuse(f"--seed {options.seed}: at least 0")
    if options.arms and options.here:
        refuse("--arms: Pinocchio draws them, in the second environment; leave --here out")
    if options.out.exists() and not options.out.is_dir():
        refuse(f"--out {options.out}: is a file; name a folder")


def main(words: Sequence[str] | None = None) -> int:
    """Print a table a group; status 2 where something is missing."""
    parser = argparse.ArgumentParser(
        prog="python -m benchmarks.rivals", description=(__doc__ or "").splitlines()[0]
    )
    parser.add_argument("--axes", type=int, default=20, help="how many, half healthy; 0: none")
    parser.add_argument("--deltas", type=int, default=0, help="how many, half healthy")
    parser.add_argument(
        "--arms", type=int, default=0, help="how many, half healthy; needs the second environment"
    )
    parser.add_argument("--real", type=Path, metavar="FOLDER", help="recordings with answers")
    parser.add_argument("--halves", action="store_true", help="answer halves of each case too")
    parser.add_argument(
        "--here", action="store_true", help=f"no second environment: {', '.join(NEED_NOTHING)} only"
    )
    parser.add_argument("--seed", type=int, default=1, help="another seed draws other machines")
    parser.add_argument(
        "--minutes", type=float, default=inf, help="processor time of a tool in a group"
    )
    parser.add_argument("--keep", action="store_true", help="answers in --out are not asked again")
    parser.add_argument("--out", type=Path, default=HOME / "out", help="folder for what is written")
    options = parser.parse_args(words)
    _refuse_wrong(options, parser.error)
    out = options.out.resolve()
    try:
        groups: list[Group] = []
        for name, drawn_group in DRAWN.items():
            if count := getattr(options, name):
                groups.append(drawn_group(count, options.seed, out))
        groups += real(options.real, out, options.here) if options.real else []
        tables: list[dict[str, dict[str, str]]] = []
        for group in groups:
            text, columns = compare(group, options)
            print(text, flush=True)
            tables.append(columns)
        for name, brief in (("shares.svg", False), ("brief.svg", True)):
            (out / name).write_text(drawing(tables, brief), encoding="utf-8")
    except ConfigError as error:
        print(f"error: {error}", file=sys.stderr)
        return 2
    return 0


if __name__ == "__main__":
    sys.exit(main())
