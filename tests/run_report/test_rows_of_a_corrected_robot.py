"""What `check` says of a corrected robot, and what the row of a run shows of it."""

from __future__ import annotations

from deltactl.cli.robot.check import limit_rows
from deltactl.repair.limit import Limit


def test_the_expected_error_is_one_figure_and_names_what_a_row_shows_of_it() -> None:
    """A part was larger than the whole: 0.37 mm, 0.38 mm of it from even motion."""
    corrected = Limit(rms_m=3.8e-4, steps_m=1e-4, sizes_m=3.7e-4, left_m=0.0, counted_m=1e-4)
    ((_, said),) = limit_rows(corrected)
    assert said.startswith("0.38 mm")
    assert "0.37 mm RMS" not in said
    assert "'commanded' of a run shows 0.10 mm" in said
    as_built = Limit(rms_m=1e-4, steps_m=1e-4, sizes_m=0.0, left_m=0.0, counted_m=1.6e-4)
    ((_, said),) = limit_rows(as_built)
    assert said.startswith("0.16 mm")
    assert "'commanded'" in said
