"""The functions that run for each single axis: one that is drawn, or one of a practice folder."""

from __future__ import annotations

import json
import tempfile
import time
from pathlib import Path
from typing import Any

from deltactl.proof.axis.cases import draw
from deltactl.proof.axis.write import write_blind
from deltactl.proof.prove.one_case import diagnose_blind

ANSWERS = "answers.json"
BOUNDED = ("single", "gross", "faint", "pair", "three")


def run_axis(seed: int, number: int) -> dict[str, Any]:
    """Draw the case of seed `number`, diagnose it blind; the truth, the answer and the bound."""
    begun = time.monotonic()
    case = draw(number)
    with tempfile.TemporaryDirectory(prefix="prove-") as folder:
        write_blind(case, Path(folder))
        simulated = time.monotonic()
        answer, failure = diagnose_blind(Path(folder))
        diagnosed = time.monotonic()
    return {
        "seed": number,
        "truth": case.truth(),
        "diagnosis": answer,
        "failure": failure,
        "bound": case.bound() if case.tier in BOUNDED else None,
        "simulated_s": simulated - begun,
        "diagnosed_s": diagnosed - simulated,
    }


def run_practice(folder: str, seed: int, number: int) -> dict[str, Any]:
    """Diagnose case `number` of a folder that has answers of another generator beside it."""
    truth = practice_answers(Path(folder))[number]
    begun = time.monotonic()
    answer, failure = diagnose_blind(Path(folder) / str(truth["case"]))
    return {
        "seed": number,
        "truth": truth,
        "diagnosis": answer,
        "failure": failure,
        "bound": None,
        "simulated_s": 0.0,
        "diagnosed_s": time.monotonic() - begun,
    }


def practice_answers(folder: Path) -> list[dict[str, Any]]:
    """What is hidden in each case of a practice folder. Raises OSError where there is no file."""
    found: list[dict[str, Any]] = json.loads((folder / ANSWERS).read_text(encoding="utf-8"))
    return found
