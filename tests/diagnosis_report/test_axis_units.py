"""Whatever a mismatch is drawn against has its unit on the axis, on every kind of machine."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from deltactl.diagnosis.api import diagnose_recordings
from deltactl.diagnosis.plants.delta.model import DeltaModel
from deltactl.diagnosis.report.sizes import covariate_unit
from deltactl.models.robot import RangeSensor, RobotModel, ServoAxis
from deltactl.models.robot_files import load_delta
from deltactl.recording.tables.flat import from_columns
from tests.axes.axis_rigs import ForcedRig

ZHAO = Path(__file__).parents[2] / "config" / "zhao-2023.yaml"


def axis(motion: str) -> ServoAxis:
    return ServoAxis.model_validate({"kind": "servo_axis", "name": "one", "motion": motion})


def test_a_delta_names_no_covariate_without_unit() -> None:
    robot = load_delta(ZHAO)
    t_s = 0.02 * np.arange(100)
    columns = {f"steps_{motor}": np.rint(500.0 * np.sin(t_s)) for motor in (1, 2, 3)}
    columns |= {f"range_{a}": 0.6 + 0.01 * np.sin(t_s) for a in "xyz"}
    recording = from_columns({"t": t_s, **columns}, "made up")
    names = set(DeltaModel(robot, [recording]).covariates()) - {"time"}
    assert "range_x, range_y" in names
    assert {name for name in names if not covariate_unit(name, robot)} == set()
    assert covariate_unit("speed_range_z", robot) == "m/s"


@pytest.mark.parametrize(
    ("robot", "position", "load"),
    [
        (axis("linear"), "m", "N"),
        (axis("rotary"), "rad", "N m"),
        (RangeSensor(kind="range_sensor", name="one"), "m", "N m"),
    ],
)
def test_a_lone_machine_has_units_of_its_motion_whatever_was_measured(
    robot: RobotModel, position: str, load: str
) -> None:
    assert covariate_unit("position", robot) == position
    assert covariate_unit("velocity", robot) == f"{position}/s"
    assert covariate_unit("load", robot) == load


@pytest.mark.study
def test_the_tables_of_an_answer_say_what_they_are_in() -> None:
    """Places of a slide in m beside forces in N: neither number says so by itself."""
    robot = axis("linear").model_copy(update={"inertia": 2.0})
    run = ForcedRig(coulomb=1.0).record(1)
    bumps = 0.3 * np.sin(run.columns["position"] / 0.1)
    run = replace(run, columns=run.columns | {"effort": run.columns["effort"] + bumps})
    answer = diagnose_recordings(robot, [run]).to_json()
    tables = [one["table"] for one in answer["findings"] if one["table"]]
    assert [(one["follows_unit"], one["unit"]) for one in tables] == [("m", "N")]
