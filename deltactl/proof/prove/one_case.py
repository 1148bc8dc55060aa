"""The function that runs for each case, on this machine or any other."""

from __future__ import annotations

import tempfile
import time
from collections.abc import Sequence
from pathlib import Path
from typing import Any

from deltactl.foundation.errors import DeltactlError
from deltactl.proof.cases import Case, draw, draw_more
from deltactl.proof.prove.bound import as_recorded, bound, distance
from deltactl.proof.write_case import HOLDOUT, RECORDING, ROBOT_FILE, write_blind

WITH_BOUND = ("single", "faint")


def run_case(seed: int, number: int) -> dict[str, Any]:
    """Draw, simulate, diagnose blind; returns the truth, the answer and what it took as JSON."""
    return _blind(draw(seed, number), seed)


def run_more(seed: int, number: int) -> dict[str, Any]:
    """The same for a case of the second set."""
    return _blind(draw_more(seed, number), seed)


def _blind(case: Case, seed: int) -> dict[str, Any]:
    begun = time.monotonic()
    with tempfile.TemporaryDirectory(prefix="prove-") as folder:
        truth = write_blind(case, Path(folder), seed)
        simulated = time.monotonic()
        answer, failure = diagnose_blind(Path(folder))
        diagnosed = time.monotonic()
    still = as_recorded(case, truth) if case.group in WITH_BOUND else None
    return {
        "seed": seed,
        "truth": case.truth(),
        "diagnosis": answer,
        "failure": failure,
        "bound": bound(case, still) if case.group in WITH_BOUND else None,
        "distance": distance(case, still) if _has_distance(case) else None,
        "simulated_s": simulated - begun,
        "diagnosed_s": diagnosed - simulated,
    }


def _has_distance(case: Case) -> bool:
    """A repeated value is not in the noiseless readings."""
    return case.group in WITH_BOUND and case.answers[0].effect != "stale_reading"


def diagnose_blind(
    folder: Path, also: Sequence[str] = ()
) -> tuple[dict[str, Any] | None, str | None]:
    """Diagnose a folder that holds two recordings and a robot file and nothing else.

    On one core: the others have cases of their own. Returns the contract's JSON, or what went
    wrong: a failure counts as a wrong answer.
    """
    from deltactl.diagnosis.api import diagnose
    from deltactl.diagnosis.estimation.side_by_side import alone

    try:
        with alone():
            answer = diagnose(
                [folder / RECORDING, *(folder / name for name in also)],
                robot=folder / ROBOT_FILE,
                holdout=[folder / HOLDOUT],
            )
    except DeltactlError as error:
        return None, str(error)
    except Exception as error:  # a crash of the engine is a result, not the end of the proof
        return None, f"{type(error).__name__}: {error}"
    return answer.to_json(), None
