"""Each case in a process of its own, for the memory of one case. Imports nothing of deltactl.

What one process keeps of a hundred cases before says nothing about a case. Libraries are loaded
before the first case, and processor time is counted, which other work on the machine leaves alone.
"""

from __future__ import annotations

import importlib
from collections.abc import Callable, Sequence
from functools import partial
from math import inf
from multiprocessing import get_context
from pathlib import Path

from benchmarks.rivals.axis_signals import Json, peak_mb

Answer = Callable[[Path], Json]
UNBEGUN: Json = {"findings": None, "diagnosis": None, "failure": None, "heldout": None}
UNBEGUN |= {"seconds": None, "unbegun": True}
"""Of a case that the tool had no time for."""


def each_case(
    answer: Answer, folder: Path, libraries: Sequence[str], most_s: float = inf
) -> tuple[dict[str, Json], float]:
    """Answers of every case begun in so much processor time, and the most memory of one [MB]."""
    for name in libraries:
        importlib.import_module(name)
    answers: dict[str, Json] = {}
    most_mb = 0.0
    for case in sorted(folder.iterdir()):
        if sum(own["seconds"] or 0.0 for own in answers.values()) > most_s:
            answers[case.name] = dict(UNBEGUN)
            continue
        with get_context("fork").Pool(1) as pool:
            answers[case.name], own_mb = pool.apply(partial(_measured, answer), (case,))
        most_mb = max(most_mb, own_mb)
    return answers, most_mb


def _measured(answer: Answer, case: Path) -> tuple[Json, float]:
    return answer(case), peak_mb()
