"""One tie: diagnose, run what the answer proposes on the same robot, diagnose both recordings."""

from __future__ import annotations

import tempfile
from pathlib import Path
from typing import Any

import numpy as np

from deltactl.foundation.errors import DeltactlError
from deltactl.proof.cases import Case, move
from deltactl.proof.hidden.build_in import construct, hidden
from deltactl.proof.hidden.ties import TIES, Tie
from deltactl.proof.motion.job import from_job
from deltactl.proof.prove.one_case import diagnose_blind
from deltactl.proof.recorded import Machine, record
from deltactl.proof.sensors.noise import Noise
from deltactl.proof.write_case import write_blind
from deltactl.recording.tables.flat_files import write_flat

SECOND = "second.csv.gz"
LONGEST_S = 900.0
T_PWM_S, SECONDS = 0.002, 90.0


def draw_tie(seed: int, number: int) -> tuple[Case, Tie, list[tuple[str, str]]]:
    """The case, its pair, and the names of the rival explanation. Pairs and truths take turns."""
    tie = TIES[number % len(TIES)]
    rng = np.random.default_rng([seed, number, 2])
    parts, rival = tie.build(rng, int(rng.integers(3)), number // len(TIES) % 2 == 0)
    noise = Noise(float(rng.uniform(0.0015, 0.003)), float(rng.choice([0.0, 0.3, 0.6])))
    machine = Machine(noise=noise)
    construct(machine, parts, with_events=False)
    trains = [move(rng, tie.motion, SECONDS, T_PWM_S) for _ in range(2)]
    answers = [hidden(part) for part in parts]
    case = Case(number, "tie", tie.motion, machine, machine, trains[0], trains[1], answers, parts)
    return case, tie, rival


def run_tie(seed: int, number: int) -> dict[str, Any]:
    """The truth, the rival, the first answer and, when a job was proposed, the second."""
    case, tie, rival = draw_tie(seed, number)
    second: dict[str, Any] | None = None
    with tempfile.TemporaryDirectory(prefix="prove-") as name:
        folder = Path(name)
        write_blind(case, folder, seed)
        first, failure = diagnose_blind(folder)
        proposal = (first or {}).get("next_experiment")
        if proposal is not None:
            second, failure = _second(case, proposal["job"], folder, seed)
    return {
        "seed": seed, "truth": case.truth(), "pair": tie.name, "settleable": tie.settleable,
        "rival": [list(name) for name in rival], "first": first, "second": second,
        "proposed": None if proposal is None else proposal["job"], "failure": failure,
    }  # fmt: skip


def _second(
    case: Case, job: dict[str, Any], folder: Path, seed: int
) -> tuple[dict[str, Any] | None, str | None]:
    try:
        train = from_job(job)
        if train.seconds > LONGEST_S:
            return None, f"the proposed job takes {train.seconds / 60.0:.0f} minutes"
        rng = np.random.default_rng([seed, case.number, 3])
        write_flat(record(case.machine, train, rng), folder / SECOND)
    except (DeltactlError, KeyError, TypeError, ValueError) as error:
        return None, f"the proposed job cannot be run: {type(error).__name__}: {error}"
    return diagnose_blind(folder, also=(SECOND,))
