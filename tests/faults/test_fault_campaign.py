"""A short fault campaign: the long one is benchmarks/endurance/faults.py."""

from __future__ import annotations

from functools import partial

import pytest

from tests.rigs.faults.called_off_kinds import CALLED_OFF_KINDS
from tests.rigs.faults.campaign import (
    KINDS,
    campaign,
    once_more,
    rest_campaign,
    settled,
    table,
)
from tests.rigs.faults.daemon_stand import DAEMON_KINDS
from tests.rigs.faults.rest_kinds import REST_KINDS
from tests.rigs.faults.verdict import MINIMUM_GAP, Verdict

ENDING = ("drive alarm", "pulse process kill -9", "steps lost")
GOING_ON = ("torn data (bits flipped)",)
FURTHER = (
    "e-stop pressed",
    "interpreter stalls 2 s",
    "e-stop, and a slow disk",
    "brown-out to 0x29",
    "disk full",
    "client floods",
)
"""Tried in a study."""


CALLED_OFF = ("off while planning", "client dies in mid-run", "client dies while homing")
"""The others are tried on a virtual clock, in tests/daemon."""


def chosen(names: tuple[str, ...]) -> list:
    return [kind for kind in KINDS if kind.name in names]


@pytest.mark.parametrize(
    "names",
    [ENDING, GOING_ON, pytest.param(FURTHER, marks=pytest.mark.study)],
    ids=["ending", "going on", "further"],
)
def test_faults_in_the_middle_of_a_run(names: tuple[str, ...]) -> None:
    kinds = {kind.name: kind for kind in chosen(names)}
    assert len(kinds) == len(names)

    tried = list(campaign(len(kinds), seed=7, kinds=list(kinds.values())))
    verdicts = [settled(partial(once_more, one.kind), one) for one in tried]
    assert {one.kind for one in verdicts} == set(names)
    assert [(one.kind, one.problems, one.waited_s) for one in verdicts if one.problems] == []
    assert len(table(verdicts)) == 1 + len(names)
    assert all(0.8 < one.gap_part < 1.1 for one in verdicts)
    assert MINIMUM_GAP == 0.9


ON_A_VIRTUAL_CLOCK = ("home switch", "robot file changed")
"""How the names of those begin; tests/controller tries them, beside other tests."""


BRIEF = ("stop during homing", "client dies in mid-run")
"""The others take a study."""


@pytest.mark.parametrize("brief", [True, pytest.param(False, marks=pytest.mark.study)])
def test_faults_beside_a_run(brief: bool) -> None:
    kinds = {name: kind for name, kind in REST_KINDS.items()
             if not name.startswith(ON_A_VIRTUAL_CLOCK)}  # fmt: skip
    kinds |= {name: CALLED_OFF_KINDS[name] for name in CALLED_OFF}
    kinds = {name: kind for name, kind in kinds.items() if (name in BRIEF) is brief}
    assert kinds
    verdicts = list(rest_campaign(len(kinds), seed=5, kinds=kinds))
    for verdict in verdicts:
        settled_one = settled(partial(once_more, verdict.kind), verdict)
        assert (settled_one.kind, settled_one.problems) == (verdict.kind, [])


def test_a_daemon_without_its_pulse_process_releases_the_drives_and_ends() -> None:
    verdict = settled(partial(once_more, "daemon without pulse process"))
    assert verdict.problems == []


def test_a_daemon_that_wakes_up_does_not_just_go_on() -> None:
    verdict = settled(partial(once_more, "daemon SIGSTOP"))
    assert verdict.problems == []
    assert 0.0 < verdict.last_edge_s < 0.25


def test_a_failure_is_excused_only_where_the_machine_was_too_busy_and_not_for_ever() -> None:
    good, own = Verdict("x"), Verdict("x", problems=["own"], waited_s=0.05)
    busy = Verdict("x", problems=["busy"], waited_s=1.0)
    assert settled([own, good].__getitem__) is own
    assert settled([busy, own, good].__getitem__) is own
    assert settled([busy, busy, good].__getitem__) is good
    assert settled(lambda number: busy) is busy


def test_every_kind_has_a_name_of_its_own_and_enough_of_them() -> None:
    names = [*(kind.name for kind in KINDS), *REST_KINDS, *DAEMON_KINDS]
    assert len(set(names)) == len(names) >= 40
