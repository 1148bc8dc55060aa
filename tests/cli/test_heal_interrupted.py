"""A healing that is interrupted: the old file is in force, also in the daemon, and nothing moves.

`python -m benchmarks.endurance.heal_kills` interrupts fifty, in all their steps.
"""

from __future__ import annotations

from pathlib import Path
from random import Random

import pytest

from tests.rigs.faults.heal_kills import KINDS, HealStand, campaign

QUICK = ("client kill -9", "daemon kill -9", "stop", "power loss")
MOVES_S = 10.0
"""From the start of the command into its survey."""


@pytest.mark.study
@pytest.mark.parametrize(
    ("names", "lasts_s", "finished"),
    [
        (QUICK, MOVES_S, False),
        ((*KINDS, *KINDS), 60.0, True),
    ],
)
def test_an_interrupted_healing_leaves_the_old_file_in_force(
    tmp_path: Path, names: tuple[str, ...], lasts_s: float, finished: bool
) -> None:
    stand = HealStand(tmp_path, minutes=0.2)
    kinds = {name: KINDS[name] for name in names}
    try:
        rows = list(campaign(stand, len(names), Random(3), kinds, lasts_s, finished))
    finally:
        stand.close()
    assert [row.kind for row in rows] == list(names)
    assert [(row.kind, row.problems) for row in rows if row.problems] == []
