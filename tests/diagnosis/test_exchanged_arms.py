"""Angles of a delta in the columns of other arms are refused, with which follows which."""

from __future__ import annotations

import itertools

import pytest

from deltactl.diagnosis.admission.arm_columns import refuse_exchanged_arms
from deltactl.foundation.errors import RecordingError
from deltactl.recording.tables.flat import FlatRecording
from tests.rigs.picker import nominal, recorded

ORDERS = [order for order in itertools.permutations((1, 2, 3)) if order != (1, 2, 3)]


def exchanged(order: tuple[int, ...]) -> FlatRecording:
    """The angle of arm n stands in the column of arm order[n - 1]."""
    whole = recorded(4)
    angles = {f"theta_{to}": whole.columns[f"theta_{n}"] for n, to in enumerate(order, 1)}
    return FlatRecording(whole.t_s, {**whole.columns, **angles}, {}, "log.csv")


@pytest.mark.parametrize("order", ORDERS)
def test_each_exchange_is_named(order: tuple[int, ...]) -> None:
    with pytest.raises(RecordingError, match="columns") as refused:
        refuse_exchanged_arms(nominal(), exchanged(order))
    for arm, column in enumerate(order, 1):
        assert (f"theta_{column} follows command_{arm}" in str(refused.value)) == (arm != column)


def test_late_drives_and_a_wrong_home_are_no_exchange() -> None:
    refuse_exchanged_arms(nominal(), recorded(4, warm_rad=0.4))


def test_arms_that_move_alike_are_not_judged() -> None:
    whole = recorded(4)
    alike = {f"command_{arm}": whole.columns["command_1"] for arm in (1, 2, 3)}
    seen = {f"theta_{arm}": whole.columns["theta_1"] + 0.1 * arm for arm in (1, 2, 3)}
    refuse_exchanged_arms(nominal(), FlatRecording(whole.t_s, alike | seen, {}, "log.csv"))
