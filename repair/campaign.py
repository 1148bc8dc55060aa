"""The blind proof of repairing: for every effect, pairs and unknowns, true errors before and after.

Each case is a robot of another make with something drawn by seed and number. It is recorded in one
survey, diagnosed, corrected and run again; what is compared is where its platform truly was.
"""

from __future__ import annotations

import json
import tempfile
from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np

from diagnosis.estimation.side_by_side import alone
from firmware_py.robot_file import CONFIG_FOLDER
from foundation.errors import DeltactlError
from proof.hidden.build_in import SINGLES
from proof.prove.workers import workers
from repair.demonstration import Demonstration, demonstrate

JOB, ROBOT = CONFIG_FOLDER / "demo-heart.yaml", CONFIG_FOLDER / "zhao-2023.yaml"
SURVEY_S = 240.0
ENOUGH, ENOUGH_M = 1.3, 0.15e-3
"""As good as can be asked: within this factor of the possible, or below this."""
WORSE, WORSE_M = 1.05, 0.02e-3
"""Beyond both, correcting made a job worse."""
EXTRA = ("pair", "pair", "pair", "unknown", "nothing")
Show = Callable[[int, int], None]


@dataclass(frozen=True)
class Row:
    """One case. `compensable`: whether all that is concealed can be compensated by commands."""

    number: int
    concealed: tuple[str, ...]
    found: tuple[str, ...]
    before_m: float
    after_m: float
    possible_m: float
    failure: str = ""

    @property
    def enough(self) -> bool:
        """Whether it draws as well as could be asked."""
        return self.after_m <= max(ENOUGH * self.possible_m, ENOUGH_M)

    @property
    def worse(self) -> bool:
        """Whether the job got worse."""
        return self.after_m > max(WORSE * self.before_m, self.before_m + WORSE_M)


def kinds_of(seed: int, number: int) -> tuple[list[str], bool]:
    """What is concealed in a case, and whether something unknown as well.

    Every effect alone first, then pairs, an unknown and nothing in turn.
    """
    if number < len(SINGLES):
        return [SINGLES[number]], False
    group = EXTRA[(number - len(SINGLES)) % len(EXTRA)]
    rng = np.random.default_rng([seed, number, 7])
    if group == "pair":
        return [str(name) for name in rng.permutation(SINGLES)[:2]], False
    return [], group == "unknown"


def run_case(seed: int, number: int) -> dict[str, Any]:
    """One case as JSON; an error of the program is a result, not the end."""
    effects, unknown = kinds_of(seed, number)
    named = [*effects, *(["unknown"] if unknown else [])]
    with tempfile.TemporaryDirectory(prefix="repair-") as folder, alone():
        try:
            shown = demonstrate(
                JOB, ROBOT, Path(folder), effects, 1000 * seed + number, unknown, SURVEY_S
            )
        except DeltactlError as error:
            return {"number": number, "concealed": named, "failure": str(error)}
    return _as_json(number, shown)


def _as_json(number: int, shown: Demonstration) -> dict[str, Any]:
    return {
        "number": number,
        "concealed": [f"{one.effect} on {one.where}" for one in shown.answers],
        "found": [f"{one.effect} on {one.component}" for one in shown.diagnosis.findings],
        "before_m": shown.before.rms_m,
        "after_m": shown.after.rms_m,
        "possible_m": shown.possible.rms_m,
        "failure": "",
    }


def prove_repair(
    cases: int, seed: int, out: Path, workers_here: int, scheduler: str | None, show: Show,
    say: Callable[[str], None],
) -> list[Row]:  # fmt: skip
    """Run what is not in `out` yet; returns all rows in order."""
    out.mkdir(parents=True, exist_ok=True)
    missing = [number for number in range(cases) if not _file(out, seed, number).exists()]
    show(cases - len(missing), cases)
    with workers(workers_here, scheduler, say) as run:
        jobs = [(run_case, seed, number) for number in missing]
        for done, (place, result) in enumerate(run(jobs), start=1):
            _file(out, seed, missing[place]).write_text(json.dumps(result, indent=1) + "\n")
            show(cases - len(missing) + done, cases)
    return list(read_rows(out, seed, cases))


def read_rows(out: Path, seed: int, cases: int) -> Iterator[Row]:
    """The rows there are."""
    for number in range(cases):
        path = _file(out, seed, number)
        if path.exists():
            yield _row(json.loads(path.read_text()))


def summary(rows: Sequence[Row]) -> list[tuple[str, str]]:
    """The figures of all rows in words."""
    ran = [row for row in rows if not row.failure]
    gone = sum(row.worse for row in ran)
    return [
        ("as good as can be asked", f"{sum(row.enough for row in ran)} of {len(ran)}"),
        ("made worse", f"{gone} of {len(ran)}"),
        ("failed", str(len(rows) - len(ran))),
    ]


def _row(found: dict[str, Any]) -> Row:
    return Row(
        number=found["number"],
        concealed=tuple(found["concealed"]),
        found=tuple(found.get("found", ())),
        before_m=found.get("before_m", np.nan),
        after_m=found.get("after_m", np.nan),
        possible_m=found.get("possible_m", np.nan),
        failure=found["failure"],
    )


def _file(out: Path, seed: int, number: int) -> Path:
    return out / f"repair-{seed}-{number:04d}.json"
