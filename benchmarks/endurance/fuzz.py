"""Fuzzing: python benchmarks/endurance/fuzz.py [-n 100000] [--target job] [--engine atheris].

Job and robot files, the socket, recordings (by their bytes, and well-formed ones by the values in
them), networks and tables, each with hypothesis and with atheris (make extras WITH=fuzz;
x86-64). Every input may be taken or refused with an error of ours in one line. Prints inputs,
errors by kind, the slowest input and how memory grew.
"""

from __future__ import annotations

import argparse
import importlib.util
import json
import subprocess
import sys
from pathlib import Path
from typing import Any

sys.path.insert(0, str(Path(__file__).resolve().parents[2]))

TARGETS = ("job", "socket", "recording", "values", "model", "csv")
ENGINES = ("hypothesis", "atheris")
MOST_GROWTH_MB = 30.0
"""Over a fifth of the inputs again without hypothesis, whose own notes grow; with atheris
after the first fifth of them, its corpus included."""
SLOW_MS = 1000.0


def main() -> int:
    """Exit status 1 when something else than an error of ours came out."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("-n", "--inputs", type=int, default=100_000)
    parser.add_argument("--target", action="append", choices=TARGETS)
    parser.add_argument("--engine", action="append", choices=ENGINES)
    parser.add_argument("--seed", type=int, default=1)
    parser.add_argument("--folder", type=Path, default=Path("build/fuzz"))
    options = parser.parse_args()
    options.folder.mkdir(parents=True, exist_ok=True)
    bad = False
    for target in options.target or TARGETS:
        for engine in options.engine or ENGINES:
            if importlib.util.find_spec(engine) is None:
                print(f"{target} {engine}: not installed", flush=True)
                continue
            bad |= _one(target, engine, options.inputs, options.seed, options.folder)
    return int(bad)


def _one(target: str, engine: str, inputs: int, seed: int, folder: Path) -> bool:
    out = folder / f"{target}-{engine}.json"
    out.unlink(missing_ok=True)
    worker = Path(__file__).with_name("fuzz_worker.py")
    words = [sys.executable, worker, target, engine, inputs, seed, out]
    with (folder / f"{target}-{engine}.log").open("wb") as log:
        done = subprocess.run([str(word) for word in words], stdout=log, stderr=log, check=False)
    found: dict[str, Any] = json.loads(out.read_text()) if out.exists() else {}
    if not found:
        print(f"{target} {engine}: ended with {done.returncode}, see {log.name}")
        return True
    kinds = ", ".join(f"{name} {count}" for name, count in found["kinds"].items())
    print(
        f"{target:10}{engine:11}{found['inputs']:8} inputs  slowest {found['slowest_ms']:6.1f} ms"
        f"  grew {found['grown_mb']:5.1f} MB  {found['cpu_s']:5.0f} s CPU  {kinds}",
        flush=True,
    )
    for what, where in found["strange"].items():
        print(f"    NOT OURS: {what}: {where}")
    if done.returncode:
        print(f"    ended with {done.returncode}, see {log.name}")
    grew, slow = found["grown_mb"] > MOST_GROWTH_MB, found["slowest_ms"] > SLOW_MS
    return bool(found["strange"] or done.returncode or grew or slow)


if __name__ == "__main__":
    sys.exit(main())
