"""A short fault campaign: the long one is benchmarks/faults.py."""

from __future__ import annotations

from pathlib import Path
from random import Random

import pytest

from firmware_py.faults.campaign import KINDS, campaign, table
from firmware_py.faults.daemon_stand import DaemonStand, stop_daemon
from firmware_py.faults.verdict import MINIMUM_GAP

ENDING = (
    "e-stop pressed",
    "drive alarm",
    "interpreter stalls 2 s",
    "pulse process kill -9",
    "steps lost",
)
GOING_ON = ("brown-out to 0x29", "torn data (bits flipped)", "disk full", "client floods")


def chosen(names: tuple[str, ...]) -> list:
    return [kind for kind in KINDS if kind.name in names]


@pytest.mark.parametrize("names", [ENDING, GOING_ON], ids=["ending", "going on"])
def test_faults_in_the_middle_of_a_run(names: tuple[str, ...]) -> None:
    kinds = chosen(names)
    assert len(kinds) == len(names)
    verdicts = list(campaign(len(kinds), seed=7, kinds=kinds))
    assert {one.kind for one in verdicts} == set(names)
    assert [(one.kind, one.problems) for one in verdicts if one.problems] == []
    assert len(table(verdicts)) == 1 + len(names)
    assert all(0.8 < one.gap_part < 1.1 for one in verdicts)
    assert MINIMUM_GAP == 0.9


def test_a_daemon_that_wakes_up_does_not_just_go_on(tmp_path: Path) -> None:
    stand = DaemonStand(tmp_path)
    try:
        verdict = stop_daemon(stand, Random(1))
    finally:
        stand.close()
    assert verdict.problems == []
    assert 0.0 < verdict.last_edge_s < 0.25


def test_every_kind_has_a_name_of_its_own_and_enough_of_them() -> None:
    assert len({kind.name for kind in KINDS}) == len(KINDS) >= 15
