"""The blind proof of repairing: for every effect, pairs and unknowns, true errors before and after.

Each case is a robot of another make with something drawn by seed and number. It is recorded in one
survey, diagnosed, corrected and run again; what is compared is where its platform truly was.
"""

from __future__ import annotations

import json
import time
from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass
from functools import partial
from pathlib import Path
from typing import Any

import numpy as np

from deltactl.diagnosis.estimation.side_by_side import alone
from deltactl.foundation.errors import DeltactlError
from deltactl.foundation.plain_file import write_whole
from deltactl.models.effects import Compensated, compensated
from deltactl.proof.hidden.build_in import SINGLES
from deltactl.proof.prove.workers import workers
from deltactl.repair.case import Case, run

ENOUGH, ENOUGH_M = 1.3, 0.15e-3
"""As good as can be asked: within this factor of the possible, or below this."""
WORSE, WORSE_M = 1.05, 0.02e-3
"""Beyond both, correcting made a job worse."""
EXTRA = ("pair", "pair", "pair", "unknown", "nothing")
BESIDE_FROM = 104
"""From this case on: an effect that is compensated, and an unknown beside it."""
# Without what rings: another list would make other robots of the same numbers.
_WAYS = (
    Compensated.INVERSE, Compensated.AHEAD, Compensated.AT_REVERSALS, Compensated.WARMING,
)  # fmt: skip
COMPENSATED = tuple(name for name in SINGLES if name in compensated(*_WAYS))
Show = Callable[[int, int], None]


@dataclass(frozen=True)
class Row:
    """One case; distances from the target, RMS [m].

    possible_m: of the same robot with nothing concealed. limit_m: what the corrected robot file
    believes to be possible. network: before and after of the job with a network; tables_m: after,
    with tables of what has no name. NaN where it was not worked out.
    """

    number: int
    concealed: tuple[str, ...]
    found: tuple[str, ...]
    before_m: float
    after_m: float
    possible_m: float
    limit_m: float = np.nan
    network_before_m: float = np.nan
    network_after_m: float = np.nan
    tables_m: float = np.nan
    corrected: tuple[str, ...] = ()
    failure: str = ""

    @property
    def enough(self) -> bool:
        """Whether it draws as well as could be asked."""
        return self._is_enough(self.after_m)

    @property
    def network_enough(self) -> bool:
        """The same with a network."""
        return self._is_enough(self.network_after_m)

    @property
    def tables_enough(self) -> bool:
        """The same with tables of what has no name."""
        return self._is_enough(self.tables_m)

    @property
    def worse(self) -> bool:
        """Whether a job got worse, in whatever way it was corrected."""
        pairs = (
            (self.before_m, self.after_m),
            (self.before_m, self.tables_m),
            (self.network_before_m, self.network_after_m),
        )
        return any(after > max(WORSE * before, before + WORSE_M) for before, after in pairs)

    def _is_enough(self, after_m: float) -> bool:
        return after_m <= max(ENOUGH * self.possible_m, ENOUGH_M)


def kinds_of(seed: int, number: int) -> tuple[list[str], bool]:
    """What is concealed in a case, and whether something unknown as well.

    Every effect alone first, then pairs, an unknown and nothing in turn; at last an effect with an
    unknown beside it.
    """
    if number >= BESIDE_FROM:
        return [COMPENSATED[(number - BESIDE_FROM) % len(COMPENSATED)]], True
    if number < len(SINGLES):
        return [SINGLES[number]], False
    group = EXTRA[(number - len(SINGLES)) % len(EXTRA)]
    rng = np.random.default_rng([seed, number, 7])
    if group == "pair":
        return [str(name) for name in rng.permutation(SINGLES)[:2]], False
    return [], group == "unknown"


def run_case(seed: int, number: int, folder: Path, networks: bool) -> dict[str, Any]:
    """One case as JSON; an error of the program is a result, not the end."""
    effects, unknown = kinds_of(seed, number)
    case = Case(number, seed, tuple(effects), unknown, folder)
    with alone():
        try:
            return run(case, networks)
        except DeltactlError as error:
            named = [*effects, *(["unknown"] if unknown else [])]
            return {"number": number, "concealed": named, "failure": str(error)}


def prove_repair(
    cases: int, seed: int, out: Path, networks: bool, workers_here: int, scheduler: str | None,
    show: Show, say: Callable[[str], None], minutes: float = np.inf,
) -> list[Row]:  # fmt: skip
    """Run what is not in `out` yet; returns all rows in order.

    minutes: no further case is begun after that time; the rows are of those that are there.
    """
    until = time.monotonic() + 60.0 * minutes
    out.mkdir(parents=True, exist_ok=True)
    missing = [number for number in range(cases) if not _is_there(out, seed, number, networks)]
    show(cases - len(missing), cases)
    case = partial(run_case, folder=out.resolve(), networks=networks)
    with workers(workers_here, scheduler, say) as at_work:
        jobs = [(case, seed, number) for number in missing]
        for done, (place, result) in enumerate(at_work(jobs), start=1):
            write_whole(_file(out, seed, missing[place]), json.dumps(result, indent=1) + "\n")
            show(cases - len(missing) + done, cases)
            if time.monotonic() > until and done < len(missing):
                say(f"stopped after {minutes:g} minutes; the same command again goes on")
                break
    return list(read_rows(out, seed, cases))


def _is_there(out: Path, seed: int, number: int, networks: bool) -> bool:
    path = _file(out, seed, number)
    if not path.exists():
        return False
    return not networks or "network_after_m" in json.loads(path.read_text())


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
    by_network = [row for row in ran if np.isfinite(row.network_after_m)]
    tables = [row for row in ran if np.isfinite(row.tables_m)]
    sound = [row for row in ran if not row.concealed]
    changed = sum(bool(row.corrected) for row in sound)
    return [
        ("as good as can be asked", f"{sum(row.enough for row in ran)} of {len(ran)}"),
        ("the same with a network", f"{sum(row.network_enough for row in by_network)}"
         f" of {len(by_network)}"),
        ("better with a table", f"{sum(row.tables_m < row.after_m for row in tables)}"
         f" of {len(tables)}"),
        ("as good with a table as can be asked", f"{sum(row.tables_enough for row in tables)}"
         f" of {len(tables)}"),
        ("made worse", f"{gone} of {len(ran)}"),
        ("changed with nothing wrong", f"{changed} of {len(sound)}"),
        ("failed", str(len(rows) - len(ran))),
    ]  # fmt: skip


def _row(found: dict[str, Any]) -> Row:
    names = (
        *("before_m", "after_m", "possible_m", "limit_m", "tables_m"),
        *("network_before_m", "network_after_m"),
    )
    sizes = {name: found.get(name) for name in names}
    return Row(
        number=found["number"],
        concealed=tuple(found["concealed"]),
        found=tuple(found.get("found", ())),
        corrected=tuple(found.get("corrected", ())),
        failure=found.get("failure", ""),
        **{name: np.nan if size is None else float(size) for name, size in sizes.items()},
    )


def _file(out: Path, seed: int, number: int) -> Path:
    return out / f"repair-{seed}-{number:04d}.json"
