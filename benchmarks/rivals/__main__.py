"""Beside other tools: the same drawn axes, one table.

    python -m benchmarks.rivals [--axes 20] [--seed 1] [--out build/rivals/out]

deltactl, lmfit with BIC, PySINDy and a textbook's inverse dynamic model get the same files of
single axes, half of them healthy (cases.py). Protocols of the others are in tools_outside.py. They
run in a second virtual environment, which this command makes in build/rivals/venv from
benchmarks/rivals/constraints.txt; each tool has one process on one core. Written in the folder:
the cases, an answers file a tool, and table.md with what each tool named otherwise.
"""

from __future__ import annotations

import argparse
import os
import platform
import shutil
import subprocess
import sys
from collections.abc import Sequence
from pathlib import Path

from benchmarks.rivals.cases import Answers, by_deltactl, drawn, read_answers, scored, write_cases
from benchmarks.rivals.table import column, markdown, wrong
from deltactl.foundation.errors import ConfigError
from deltactl.foundation.release import own_version

ROOT = Path(__file__).parents[2]
HOME = ROOT / "build" / "rivals"
CONSTRAINTS = Path(__file__).with_name("constraints.txt")
OUTSIDE = ("lmfit", "PySINDy", "textbook")
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


def outside(python: Path, tool: str, cases: Path, out: Path) -> Answers:
    """Let a tool answer every case in a process of the second environment."""
    command = [str(python), "-m", "benchmarks.rivals.tools_outside", tool, str(cases), str(out)]
    own = {name: value for name, value in os.environ.items() if name != "PYTHONPATH"}
    done = subprocess.run(command, cwd=ROOT, env=own | ONE_CORE, check=False)
    if done.returncode:
        raise ConfigError(f"{tool} ended with status {done.returncode}; its error is above")
    return read_answers(out)


def versions() -> str:
    """What ran, and on what kind of machine."""
    pinned = CONSTRAINTS.read_text(encoding="utf-8").split()
    tools = [line.replace("==", " ") for line in pinned if line.startswith(("lmfit", "pysindy"))]
    own = [f"deltactl {own_version()}", *tools, f"Python {platform.python_version()}"]
    return f"{', '.join(own)}; {platform.machine()}, {os.cpu_count()} cores"


def compare(axes: int, seed: int, out: Path) -> str:
    """Run every tool; the table as Markdown."""
    python = environment()
    files = out / f"cases-{seed}"
    shutil.rmtree(files, ignore_errors=True)
    truths = write_cases(drawn(axes, seed), files)
    columns, mistakes = {}, ""
    for tool in ("deltactl", *OUTSIDE):
        print(f"{tool} ...", file=sys.stderr, flush=True)
        answers = (
            by_deltactl(files)
            if tool == "deltactl"
            else outside(python, tool, files, out / f"{tool}-{seed}.json")
        )
        own = scored(truths, answers)
        columns[tool] = column(tool, own, answers.peak_mb)
        mistakes += wrong(tool, own)
    text = f"{axes} single axes, seed {seed}; {versions()}\n\n{markdown(columns)}"
    (out / f"table-{seed}.md").write_text(f"{text}\n## Named otherwise\n\n{mistakes}")
    return text


def main(words: Sequence[str] | None = None) -> int:
    """Print the table; status 2 where something is missing."""
    parser = argparse.ArgumentParser(
        prog="python -m benchmarks.rivals", description=(__doc__ or "").splitlines()[0]
    )
    parser.add_argument("--axes", type=int, default=20, help="how many, half of them healthy")
    parser.add_argument("--seed", type=int, default=1, help="another seed draws other axes")
    parser.add_argument("--out", type=Path, default=HOME / "out", help="folder for what is written")
    options = parser.parse_args(words)
    if options.axes < 2:
        parser.error(f"--axes {options.axes}: at least 2, a healthy one and another")
    if options.seed < 0:
        parser.error(f"--seed {options.seed}: at least 0")
    if options.out.exists() and not options.out.is_dir():
        parser.error(f"--out {options.out}: is a file; name a folder")
    try:
        print(compare(options.axes, options.seed, options.out.resolve()), end="")
    except ConfigError as error:
        print(f"error: {error}", file=sys.stderr)
        return 2
    return 0


if __name__ == "__main__":
    sys.exit(main())
