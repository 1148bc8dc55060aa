"""Logs of many makers' tools are taken for what they are, or it is said what to type."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from deltactl.foundation.errors import RecordingError
from deltactl.recording.foreign.inspection import inspect
from deltactl.recording.foreign.mapping import load_mapping
from deltactl.recording.foreign.reading import read_mapped
from tests.inspection.logs_of_makers import LOGS, NO_TABLES, PERIOD_S
from tests.rigs.owners_words import owner_says


@pytest.mark.parametrize("name", LOGS)
def test_a_log_is_taken_for_what_it_is(tmp_path: Path, name: str) -> None:
    log = LOGS[name]
    path = tmp_path / "log.csv"
    path.write_text(log.text, encoding="utf-8")
    found = inspect(path)
    assert {guess.name: guess.source for guess in found.guesses.values()} == log.taken
    assert found.kind == log.kind
    by_name = {guess.name: guess for guess in found.guesses.values()}
    assert {name: by_name[name].unit for name in log.units} == log.units
    said = " ".join([found.kind_why, *found.warnings])
    assert not [part for part in log.says if part not in said]
    if found.kind is not None:
        read = read_mapped(path, load_mapping(None, owner_says(found)))
        assert set(log.taken) - {"t"} <= set(read.columns)
        if "rate_hz" not in said:
            assert read.period_s() == pytest.approx(PERIOD_S, rel=1e-3)
        places = [name for name in read.columns if name not in ("velocity", "effort")]
        np.testing.assert_array_less(np.abs(read.side_by_side(places)), 105.0)


@pytest.mark.parametrize("name", NO_TABLES)
def test_what_is_no_table_is_refused_in_words(tmp_path: Path, name: str) -> None:
    path = tmp_path / "log.csv"
    path.write_text(NO_TABLES[name], encoding="utf-8")
    with pytest.raises(RecordingError, match=r"no columns of numbers|no table of numbers"):
        inspect(path)
