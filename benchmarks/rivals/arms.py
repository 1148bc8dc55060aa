"""Arms that every tool gets, drawn ones and real ones, and how answers about the drawn are scored.

The proof's generator draws them and Pinocchio moves them, in the second environment
(arm_cases.py). Real ones are recordings of chains as real.py reads them.
"""

from __future__ import annotations

import contextlib
import io
import json
import subprocess
from collections.abc import Sequence
from pathlib import Path
from typing import Any

import numpy as np

from benchmarks.proofs.moving_arms import expected
from benchmarks.rivals.arm_cases import TRUTHS
from benchmarks.rivals.arm_signals import URDF
from benchmarks.rivals.cases import Answers, Scored, in_place, in_places, write_names
from deltactl.cli.recordings.init_chain import chain
from deltactl.foundation.errors import ConfigError
from deltactl.proof.cases import ROBOT_FILE

Json = dict[str, Any]
SEED_FROM = 46_001
"""Odd seeds of the generator that nothing else draws from: this and every second one."""
GROUP = "arms"


def write_arms(python: Path, root: Path, count: int, seed: int, folder: Path) -> list[Json]:
    """A folder an arm, every other one healthy. Returns the truths, which no tool sees.

    python: of an environment that has Pinocchio. Raises ConfigError where it cannot draw.
    """
    own_seed = str(SEED_FROM + 2 * seed)
    command = [str(python), "-m", "benchmarks.rivals.arm_cases", own_seed, str(count), str(folder)]
    done = subprocess.run(command, cwd=root, capture_output=True, text=True, check=False)
    if done.returncode:
        last = done.stderr.strip().splitlines()[-1:] or ["no message"]
        raise ConfigError(f"cannot draw arms: {last[0]}")
    for own in folder.iterdir():
        with contextlib.redirect_stdout(io.StringIO()):
            chain(own / ROBOT_FILE, own / URDF)
    written = folder.with_name(f"{folder.name}-{TRUTHS}").read_text(encoding="utf-8")
    truths: list[Json] = json.loads(written)
    for truth in truths:
        faults = [(str(key), str(at), float(size)) for key, at, size in truth.pop("hidden")]
        truth["answers"] = [
            {"effect": effect, "where": at, "parameter": name, "size": size}
            for effect, at, name, size in expected(faults)
        ]
    write_names(truths, folder)
    return truths


def scored_arms(truths: Sequence[Json], answers: Answers) -> list[Scored]:
    """Right: the findings are the hidden effects in their places, no more and no less."""
    found = []
    for truth in truths:
        own = answers.by_case[truth["case"]]
        if own["seconds"] is None:
            continue
        hidden, said = in_places(truth, own)
        sizes = [
            bool(low <= line["size"] <= high)
            for name, line in hidden.items()
            if name in said and (stated := said[name]["parameters"].get(line["parameter"]))
            for low, high in [np.ravel(np.array(stated["ci95"], dtype=np.float64))[:2]]
            if np.isfinite(high - low)
        ]
        found.append(in_place(GROUP, truth, answers, hidden, said, sizes=sizes))
    return found
