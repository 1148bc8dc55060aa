"""Logs with the real column names of forty programs are read as their owners mean them, and the
command that is printed for them runs.
"""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from deltactl.recording.foreign.inspection import inspect
from deltactl.recording.foreign.mapping import load_mapping
from deltactl.recording.foreign.reading import read_mapped
from tests.inspection.heads import Head, heads, truth, write

HEADS = {head.program: head for head in heads(Path(__file__).with_name("heads.yaml"))}
NO_SIZES = ("kind", "t", "effort", "velocity")


@pytest.fixture(params=HEADS)
def head(request: pytest.FixtureRequest) -> Head:
    return HEADS[request.param]


def test_columns_are_what_their_owners_mean(head: Head, tmp_path: Path) -> None:
    """And the options that are printed read them, in the right size."""
    path = tmp_path / "log.csv"
    write(head, path)
    found = inspect(path)
    taken = {"kind": found.kind} | {one.name: one.source for one in found.guesses.values()}
    wrong = {n: taken.get(n) for n, right in head.right.items() if taken.get(n) not in right}
    assert not wrong
    if found.kind is None:
        assert not {"command", "distance", "effort"} & taken.keys()
        return
    read = read_mapped(path, load_mapping(None, found.options[1::2]))
    if "t" in head.right:
        assert read.period_s() == pytest.approx(1.0 / head.rate_hz, rel=0.01)
    elif found.kind != "range_sensor":
        assert any(option.startswith("rate_hz=") for option in found.options)
    moving = [name for name in head.right if name not in NO_SIZES]
    if head.unsaid:
        asked = [one for one in found.warnings if any(str(taken[n]) in one for n in moving)]
        assert asked, "nothing says the unit, and nobody is asked for it"
        return
    for name in moving:
        far = np.ptp(truth(head, str(taken[name])))
        assert np.ptp(read.columns[name]) == pytest.approx(far, rel=0.05), name
