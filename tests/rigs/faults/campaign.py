"""The campaign: many faults in random order at random moments, and a table of the worst."""

from __future__ import annotations

import itertools
import tempfile
from collections.abc import Callable, Iterator, Mapping, Sequence
from pathlib import Path
from random import Random

import numpy as np

from deltactl.foundation.errors import DeltactlError
from tests.rigs.faults.called_off_kinds import CALLED_OFF_KINDS
from tests.rigs.faults.daemon_stand import DAEMON_KINDS, DaemonFault, DaemonStand
from tests.rigs.faults.judge import try_fault
from tests.rigs.faults.kind import Kind
from tests.rigs.faults.motion_kinds import MOTION_KINDS
from tests.rigs.faults.rest_kinds import REST_KINDS, RestFault, try_at_rest
from tests.rigs.faults.run_delay import all_waits_s
from tests.rigs.faults.sensor_kinds import SENSOR_KINDS
from tests.rigs.faults.stand import Stand
from tests.rigs.faults.system_kinds import SYSTEM_KINDS
from tests.rigs.faults.verdict import Verdict

KINDS: tuple[Kind, ...] = (*MOTION_KINDS, *SENSOR_KINDS, *SYSTEM_KINDS)
BESIDE_KINDS: dict[str, RestFault] = REST_KINDS | CALLED_OFF_KINDS
"""Faults beside a run, requests that are called off among them."""
RUN_OF = 6
"""A run bears so many faults that do not end it; then its recording is judged."""


def campaign(count: int, seed: int, kinds: Sequence[Kind] = KINDS) -> Iterator[Verdict]:
    """`count` faults, every kind in turn in a shuffled order. Yields a verdict for each."""
    chance = Random(seed)
    with tempfile.TemporaryDirectory(prefix="deltactl-faults-") as folder:
        stand = Stand(Path(folder))
        try:
            for number, kind in enumerate(_order(count, kinds, chance)):
                yield _try(stand, kind, chance)
                if number % RUN_OF == RUN_OF - 1:
                    stand.end_run()
        finally:
            stand.close()


def rest_campaign(
    count: int, seed: int, kinds: Mapping[str, RestFault] = BESIDE_KINDS
) -> Iterator[Verdict]:
    """`count` faults beside a run, every kind in turn. Yields a verdict for each."""
    chance, turns = Random(seed), itertools.cycle(kinds.items())
    with tempfile.TemporaryDirectory(prefix="deltactl-faults-") as folder:
        stand = Stand(Path(folder))
        try:
            for name, fault in itertools.islice(turns, count):
                before_s = stand.waited_s()
                verdict = try_at_rest(stand, name, fault, chance)
                verdict.waited_s = all_waits_s(before_s, stand.waited_s())
                yield verdict
        finally:
            stand.close()


def daemon_campaign(
    count: int, seed: int, kinds: Mapping[str, DaemonFault] = DAEMON_KINDS
) -> Iterator[Verdict]:
    """`count` faults of the daemon's own process. Yields a verdict for each."""
    chance, turns = Random(seed), itertools.cycle(kinds.items())
    with tempfile.TemporaryDirectory(prefix="deltactl-faults-") as folder:
        stand = DaemonStand(Path(folder))
        try:
            for name, fault in itertools.islice(turns, count):
                before_s = stand.waited_s()
                try:
                    yield fault(stand, chance)
                except (DeltactlError, AssertionError, OSError) as error:
                    waited = all_waits_s(before_s, stand.waited_s())
                    problems = [f"{type(error).__name__}: {error}"]
                    yield Verdict(name, waited_s=waited, problems=problems)
                    stand.restart()
        finally:
            stand.close()


ATTEMPTS = 4


def settled(attempt: Callable[[int], Verdict], first: Verdict | None = None) -> Verdict:
    """Again where the machine had no core for us; a failure with a core counts at once.

    What fails every time fails here, however busy the machine is.
    """
    verdict = first or attempt(0)
    for number in range(1, ATTEMPTS):
        if not verdict.problems or verdict.counts:
            break
        verdict = attempt(number)
    return verdict


def once_more(name: str, number: int) -> Verdict:
    """One more fault of a kind, at another moment for each number."""
    if name in BESIDE_KINDS:
        tried = rest_campaign(1, number, {name: BESIDE_KINDS[name]})
    elif name in DAEMON_KINDS:
        tried = daemon_campaign(1, number, {name: DAEMON_KINDS[name]})
    else:
        tried = campaign(1, number, [kind for kind in KINDS if kind.name == name])
    (verdict,) = tried
    return verdict


def _order(count: int, kinds: Sequence[Kind], chance: Random) -> Iterator[Kind]:
    for start in range(0, count, len(kinds)):
        round_of_kinds = list(kinds)
        chance.shuffle(round_of_kinds)
        yield from round_of_kinds[: count - start]


def _try(stand: Stand, kind: Kind, chance: Random) -> Verdict:
    try:
        return try_fault(stand, kind, chance)
    except (DeltactlError, AssertionError, OSError) as error:
        verdict = Verdict(kind.name, problems=[f"{type(error).__name__}: {error}"])
        stand.restart()
        return verdict


HEADER = (
    f"{'fault':28} {'n':>4} {'bad':>4} {'last edge/well':>15} {'p99':>9} {'seen':>8}"
    f" {'pause':>8} {'min gap':>8} {'off':>4} {'unrecorded':>10} {'no core':>8}"
)


def table(verdicts: Sequence[Verdict]) -> list[str]:
    """One line for each kind, with its worst figures."""
    names = list(dict.fromkeys(one.kind for one in verdicts))
    order = {kind.name: place for place, kind in enumerate(KINDS)}
    names.sort(key=lambda name: order.get(name, len(order)))
    return [HEADER, *(_row(name, [v for v in verdicts if v.kind == name]) for name in names)]


def _row(name: str, rows: Sequence[Verdict]) -> str:
    last_ms = np.array([row.last_edge_s for row in rows]) * 1e3
    bad = sum(bool(row.problems) for row in rows)
    return (
        f"{name:28} {len(rows):4d} {bad:4d} {last_ms.max():12.1f} ms"
        f" {np.percentile(last_ms, 99):6.1f} ms {max(r.seen_s for r in rows):6.2f} s"
        f" {max(r.pause_s for r in rows) * 1e3:5.0f} ms {min(r.gap_part for r in rows):8.3f}"
        f" {max(r.miscounted for r in rows):4d} {max(r.unrecorded_s for r in rows):8.3f} s"
        f" {max(r.waited_s for r in rows):6.2f} s"
    )
