"""The demonstration on another make of robot: what is found is corrected, else nothing changes."""

from __future__ import annotations

import json
import re
from pathlib import Path
from types import SimpleNamespace
from typing import cast

import numpy as np
import pytest
from typer.testing import CliRunner

pytest.importorskip("mujoco", reason="the robot of the proof is MuJoCo's")

from deltactl.cli.main import app
from deltactl.firmware_py.named_files import CONFIG_FOLDER
from deltactl.firmware_py.planner.plan import plan_of
from deltactl.foundation.errors import ConfigError
from deltactl.proof.hidden.hidden import Hidden
from deltactl.repair.demonstration import (
    CORRECTED,
    RECORDING,
    HiddenFaults,
    _size,
    demonstrate,
)
from deltactl.repair.machine import faulty_robot
from deltactl.repair.played import Drawn, played

JOB, ROBOT = CONFIG_FOLDER / "demo-heart.yaml", CONFIG_FOLDER / "zhao-2023.yaml"


@pytest.mark.study
def test_a_wrong_home_is_found_and_the_heart_is_drawn_as_well_as_it_can_be(tmp_path: Path) -> None:
    """By the command, which hides at seed 3, prints its figures and writes the page."""
    typed = ["--hide", "home_offset", "--minutes", "1", "--out", str(tmp_path / "demo"), "--json"]
    answer = json.loads(CliRunner().invoke(app, ["demo", *typed]).stdout)
    before, after, possible = (answer[f"{when}_rms_m"] for when in ("before", "after", "possible"))
    assert before > 2e-3
    assert after < 1.3 * possible + 2e-5
    assert before - after > 0.98 * (before - possible)
    assert [one["effect"] for one in answer["effects"] if one["how"]] == ["home_offset"]
    page = Path(answer["page"]).read_text(encoding="utf-8")
    assert "The heart" in page
    assert "home_offset" in page
    assert "<script src" not in page  # the charts' library stands in the page
    markup = re.sub(r"<script.*?</script>", "", page, flags=re.DOTALL)
    assert "http" not in markup.replace("http://www.w3.org", "").replace("http-equiv", "")


@pytest.mark.parametrize(
    ("main", "unit", "value", "says"),
    [
        ("angle", "rad", 0.0129, "+0.739 degrees"),
        ("rotation", "rad", [0.01, -0.02, 0.0], "+0.573 degrees, -1.15 degrees, 0.000 degrees"),
        ("scale", "1", 1.01, "+1.00 %"),
    ],
)
def test_what_was_hidden_is_told_in_the_units_of_what_was_found(
    main: str, unit: str, value: float | list[float], says: str
) -> None:
    hidden = SimpleNamespace(main=main, unit=unit, parameters={main: value})
    assert _size(cast(Hidden, hidden)) == says


@pytest.mark.study
def test_where_nothing_is_wrong_nothing_is_changed(tmp_path: Path) -> None:
    shown = demonstrate(JOB, ROBOT, tmp_path, HiddenFaults([], 5), survey_s=60.0)
    assert shown.corrected.read_text() == ROBOT.read_text()
    assert shown.after is shown.before


def test_what_is_played_are_the_counts_of_the_plan_with_rotors_that_turn_evenly() -> None:
    plan = plan_of(JOB)
    job = played(plan)
    assert tuple(job.counts[-1]) == plan.last_counts
    t_s = np.linspace(0.0, job.seconds, 5001)
    smooth = job.smooth(t_s)
    assert np.abs(smooth - job.at(t_s)).max() <= 1.0
    assert np.array_equal(np.rint(smooth[-1]), job.counts[-1])


def test_the_distance_is_a_length_in_space() -> None:
    off = np.array([[3e-3, 4e-3, 0.0], [0.0, 0.0, 0.0]])
    run = Drawn(np.arange(2.0), np.zeros((2, 3)), off)
    assert run.worst_m == pytest.approx(5e-3)
    assert run.rms_m == pytest.approx(5e-3 / np.sqrt(2.0))


def test_an_effect_there_is_none_of_is_refused() -> None:
    with pytest.raises(ConfigError, match="cannot be hidden"):
        faulty_robot(["gremlins"], 1)


def test_a_demonstration_replaces_one_before_it_and_nothing_else(tmp_path: Path) -> None:
    from deltactl.cli.recordings.demo import PAGE, make_room

    names = (PAGE, RECORDING, CORRECTED)
    assert not make_room(tmp_path / "new", names, force=False)
    assert not make_room(tmp_path / "new", names, force=False)  # begun, and broken off
    (tmp_path / "new" / PAGE).write_text("the last one")
    assert make_room(tmp_path / "new", names, force=False)
    (tmp_path / CORRECTED).write_text("mine")
    with pytest.raises(ConfigError, match="exists already"):
        make_room(tmp_path, names, force=False)
    assert not make_room(tmp_path, names, force=True)
