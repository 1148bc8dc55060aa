"""Is a hidden cause named from the disturbance estimate? Blind: the diagnosis sees two files.

    python -m deltactl.reproduction.uzunovic_2013.control_blind --out DIR [--cases 24] [--seed N]

Each case hides one thing (or nothing) in a MuJoCo micro delta, moves it at random, and writes
its recording and the shipped robot file into a folder of their own; the hidden cause is written
elsewhere, after the answer.
"""

from __future__ import annotations

import argparse
import json
import shutil
from collections import Counter
from collections.abc import Callable, Sequence
from dataclasses import asdict, dataclass
from pathlib import Path
from secrets import randbelow

import numpy as np
from rich.console import Console
from rich.table import Table

from deltactl.firmware_py.servo.law import LawSettings
from deltactl.foundation.plain_file import write_whole
from deltactl.models.servo_drive import ServoDrive
from deltactl.proof.micro.as_built import MicroDelta
from deltactl.proof.micro.hidden_causes import case, random_motion
from deltactl.proof.prove.reliability import wilson
from deltactl.recording.tables.flat import FlatRecording
from deltactl.recording.tables.flat_files import write_flat
from deltactl.reproduction.uzunovic_2013.control_loop import ROBOT_FILE, micro_delta, recorded, run

RUN_S, HOLDOUT_S = 30.0, 10.0
ROBOT, RECORDING, HOLDOUT = "robot.yaml", "recording.csv.gz", "holdout.csv.gz"
NOTHING = "nothing"


@dataclass(frozen=True, slots=True)
class Outcome:
    """One case: the truth, what was said (first finding first), and how large it was said to be."""

    number: int
    effect: str
    component: str
    size: float
    said: tuple[tuple[str, str], ...]
    value: float | None
    ci95: tuple[float, float] | None
    alternatives: tuple[tuple[str, str], ...]
    verdict: str

    @property
    def right(self) -> bool:
        """Exactly the hidden cause at its place, and nothing else."""
        truth = () if self.effect == NOTHING else ((self.effect, self.component),)
        return self.said == truth

    @property
    def first(self) -> str:
        """Effect of the first finding."""
        return self.said[0][0] if self.said else NOTHING

    @property
    def at_its_joint(self) -> bool:
        """Whether the first finding is the hidden cause at its place."""
        return self.right or (self.effect, self.component) in self.said[:1]

    @property
    def covered(self) -> bool | None:
        """Whether the interval holds the true size; None without a right answer."""
        if not self.right or self.ci95 is None:
            return None
        return self.ci95[0] <= self.size <= self.ci95[1]


def run_case(
    seed: int, number: int, out: Path, run_s: float = RUN_S, holdout_s: float = HOLDOUT_S
) -> Outcome:
    """Hide, record, diagnose. Raises what the diagnosis raises: that is no answer at all."""
    from deltactl.diagnosis.api import diagnose

    hidden, rng = case(seed, number)
    folder = out / f"case_{number:03d}"
    shutil.rmtree(folder, ignore_errors=True)
    folder.mkdir(parents=True)
    write_whole(folder / ROBOT, ROBOT_FILE.read_bytes())
    _, drive = micro_delta()
    write_flat(record(hidden.robot, drive, rng, run_s), folder / RECORDING)
    write_flat(record(hidden.robot, drive, rng, holdout_s), folder / HOLDOUT)
    answer = diagnose([folder / RECORDING], folder / ROBOT, [folder / HOLDOUT])
    first = answer.findings[0] if answer.findings else None
    size = next(iter(first.parameters.values())) if first is not None else None
    outcome = Outcome(
        number,
        hidden.effect,
        hidden.component,
        hidden.size,
        tuple((found.effect, found.component) for found in answer.findings),
        float(size.value) if size is not None and isinstance(size.value, float) else None,
        _ends(size.ci95) if size is not None else None,
        tuple((a.effect, a.component) for found in answer.findings for a in found.alternatives),
        answer.verdict,
    )
    write_whole(out / f"case_{number:03d}.json", json.dumps(asdict(outcome), indent=1) + "\n")
    return outcome


def _ends(
    ci95: Sequence[float | None] | Sequence[Sequence[float | None]],
) -> tuple[float, float] | None:
    low, high = ci95[0], ci95[-1]
    return (low, high) if isinstance(low, float) and isinstance(high, float) else None


def confusion(outcomes: Sequence[Outcome]) -> tuple[list[str], list[tuple[str, ...]]]:
    """Rows: the hidden cause. Columns: the first finding, at the right joint or elsewhere."""
    names = list(dict.fromkeys([NOTHING, *(outcome.effect for outcome in outcomes)]))
    columns = list(dict.fromkeys([*names, *(outcome.first for outcome in outcomes)]))
    head = ["hidden", *columns, "at its joint", "exactly this", "interval holds"]
    rows: list[tuple[str, ...]] = []
    for name in names:
        own = [outcome for outcome in outcomes if outcome.effect == name]
        counts = Counter(outcome.first for outcome in own)
        held = [outcome.covered for outcome in own if outcome.covered is not None]
        rows.append(
            (
                name,
                *(str(counts[column] or "") for column in columns),
                f"{sum(outcome.at_its_joint for outcome in own)} of {len(own)}",
                f"{sum(outcome.right for outcome in own)} of {len(own)}",
                f"{sum(held)} of {len(held)}" if held else "",
            )
        )
    return head, rows


def prove(
    cases: int, seed: int, out: Path, progress: Callable[[Outcome], None] = lambda outcome: None
) -> list[Outcome]:
    """All cases of a seed, one after another."""
    outcomes = []
    for number in range(cases):
        outcomes.append(run_case(seed, number, out))
        progress(outcomes[-1])
    return outcomes


def line(outcome: Outcome) -> str:
    """One case in words."""
    said = ", ".join(" ".join(part) for part in outcome.said) or NOTHING
    ties = f" (or {', '.join(' '.join(part) for part in outcome.alternatives)})" * bool(
        outcome.alternatives
    )
    size = f" {outcome.component} {outcome.size:.3g}" if outcome.size else ""
    truth = f"{outcome.effect}{size}"
    value = f" {outcome.value:.4g}" if outcome.value is not None else ""
    return f"{outcome.number}: {truth} -> {said}{value}{ties}{'' if outcome.right else '  WRONG'}"


def main() -> None:
    """Run the proof and print its table."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--out", type=Path, required=True, help="folder for the cases")
    parser.add_argument("--cases", type=int, default=24)
    parser.add_argument("--seed", type=int, default=None, help="a fresh one if left out")
    given = parser.parse_args()
    seed = randbelow(10**6) if given.seed is None else given.seed
    console = Console()
    console.print(f"seed {seed}")
    outcomes = prove(given.cases, seed, given.out, lambda outcome: console.print(line(outcome)))
    head, rows = confusion(outcomes)
    table = Table(title=f"{len(outcomes)} cases of seed {seed}: hidden (rows), found (columns)")
    for name in head:
        table.add_column(name, justify="left" if name == "hidden" else "right")
    for row in rows:
        table.add_row(*row)
    console.print(table)
    right = sum(outcome.right for outcome in outcomes)
    low, high = wilson(right, len(outcomes))
    console.print(
        f"exactly right: {right} of {len(outcomes)} (95 % limits {100 * low:.0f} to"
        f" {100 * high:.0f} %)"
    )


if __name__ == "__main__":
    main()


def record(
    robot: MicroDelta, drive: ServoDrive, rng: np.random.Generator, seconds: float
) -> FlatRecording:
    """Move the robot at random under the paper's law, and record it."""
    t_s = np.arange(round(seconds / drive.period_s)) * drive.period_s
    reference_rad = random_motion(rng, t_s)
    first, second, third = reference_rad[0].tolist()
    ran = run(
        LawSettings.of(drive), robot, t_s, reference_rad, on_s=0.0, start_rad=(first, second, third)
    )
    return recorded(ran, drive)
