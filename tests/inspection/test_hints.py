"""What else a column may be is data: a terminal says what to type, a page what to choose."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from deltactl.foundation.errors import RecordingError
from deltactl.recording.foreign.inspection import inspect
from deltactl.recording.foreign.notes import Hint
from deltactl.recording.tables.flat_files import read_flat
from deltactl.web.behind.own_recordings import inspected


def test_a_unit_that_values_suggest_can_be_chosen(tmp_path: Path) -> None:
    t_s = np.arange(400) / 50.0
    asked = 40.0 * np.sin(t_s)
    rows = np.stack([t_s, asked, asked + 0.1], axis=1)
    file = tmp_path / "axis.csv"
    np.savetxt(file, rows, delimiter=",", header="t,command,position", comments="")
    (hint,) = [one for one in inspect(file).warnings if isinstance(one, Hint)]
    assert (hint.kind, hint.choice) == (
        "unit",
        "deg, rad or turn if it turns; mm or inch if it slides",
    )
    assert hint.endswith(hint.command)
    assert hint.command not in hint.chosen, "a page has no command to put it into"
    assert hint.chosen in inspected(file)["warnings"]


def test_a_page_can_leave_out_what_is_typed_in_a_terminal(tmp_path: Path) -> None:
    file = tmp_path / "foreign.csv"
    file.write_text("t,left,right\n0,1,2\n0.1,2,3\n")
    with pytest.raises(RecordingError) as refused:
        read_flat(file)
    error = refused.value
    assert error.typed.endswith(f"deltactl inspect {file}")
    assert str(error).endswith(error.typed)
    assert "left" in str(error).removesuffix(error.typed)
