"""Degrees that no heading names: by the steps of the reading, or by the names of joints."""

from __future__ import annotations

import re
import shlex
from pathlib import Path

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from deltactl.recording.foreign.doubts import of_encoder
from deltactl.recording.foreign.found import Inspection
from deltactl.recording.foreign.inspection import inspect
from deltactl.recording.foreign.mapping import load_mapping
from deltactl.recording.foreign.reading import read_mapped
from tests.cli.conftest import Deltactl
from tests.rigs.owners_words import owner_says

T_S = 0.02 * np.arange(600)
ASKED = np.sin(0.9 * T_S)


def table(
    path: Path, names: str, amplitude: float, step: float = 0.0, zero: float = 0.0
) -> Inspection:
    """What is found in a table of an axis that goes so far, and is read in such steps."""
    noise = 0.003 * amplitude * np.random.default_rng(3).standard_normal(len(T_S))
    seen = zero + 0.96 * amplitude * ASKED + noise
    seen = step * np.round(seen / step) if step else seen
    cells = np.stack([T_S, amplitude * ASKED, seen], axis=1)
    np.savetxt(path, cells, "%.7f", ",", header=f"time,{names}", comments="")
    return inspect(path)


def units(found: Inspection) -> list[str | None]:
    return [guess.unit for guess in found.guesses.values() if guess.role != "t"]


@pytest.mark.parametrize(
    ("step", "unit"),
    [(360 / 4096, "deg"), (360 / 2**14, "deg"), (300 / 1024, "deg"), (2 * np.pi / 2**14, "rad")],
)
def test_the_steps_of_the_reading_tell(tmp_path: Path, step: float, unit: str) -> None:
    found = table(tmp_path / "a.csv", "goal,read", 5.0, step)
    assert units(found) == [unit, unit]
    assert found.motion == "rotary"
    assert not found.warnings
    read = read_mapped(found.path, load_mapping(None, owner_says(found)))
    size = np.radians(5.0) if unit == "deg" else 5.0
    assert np.ptp(read.column("command")) == pytest.approx(2 * size, rel=1e-3)


def test_a_command_with_another_zero_is_in_the_unit_of_its_reading(tmp_path: Path) -> None:
    assert units(table(tmp_path / "a.csv", "goal,read", 5.0, 360 / 4096, zero=-70.0)) == [
        "deg",
        "deg",
    ]


def test_joints_of_data_sets_are_in_degrees_and_turn(tmp_path: Path) -> None:
    found = table(tmp_path / "a.csv", "elbow_flex.goal,elbow_flex.pos", 4.0)
    assert (units(found), found.motion) == (["deg", "deg"], "rotary")
    assert "inspect it with --set 'position=elbow_flex.pos[rad]'" in found.warnings[0]


def test_a_joint_turns_in_a_unit_that_is_asked_for(tmp_path: Path) -> None:
    found = table(tmp_path / "a.csv", "goal_elbow,read_elbow", 1.2)
    assert found.motion == "rotary"
    columns = ["t=time", "position=read_elbow", "command=goal_elbow"]
    assert found.options[1::2] == ["unit=UNIT", *columns]
    assert {found.mapping.columns[name].unit for name in ("position", "command")} == {"rad"}
    assert found.asked is not None
    assert found.asked.units == "deg, rad or turn if it turns"


@pytest.mark.parametrize(
    ("amplitude", "rotary", "linear"),
    [
        (9.0, ["deg", "rad", "turn"], ["mm", "m", "inch"]),
        (40.0, ["deg", "rad", "turn"], ["mm", "inch"]),
        (300.0, ["deg"], ["mm", "inch"]),
        (20_000.0, ["deg", "arcsec"], ["um"]),
    ],
)
def test_units_that_the_size_excludes_are_not_offered(
    tmp_path: Path, amplitude: float, rotary: list[str], linear: list[str]
) -> None:
    found = table(tmp_path / "a.csv", "goal,read", amplitude)
    assert found.motion is None
    assert found.asked is not None
    assert (found.asked.rotary, found.asked.linear) == (rotary, linear)


def test_where_the_size_leaves_one_unit_it_is_taken(tmp_path: Path) -> None:
    found = table(tmp_path / "a.csv", "goal_elbow,read_elbow", 300.0)
    assert (units(found), found.asked) == (["deg", "deg"], None)
    assert "taken for degrees; if it is radians, inspect it with" in found.warnings[0]


@pytest.mark.parametrize("names", ["goal,read", "command,position"])
def test_what_stays_open_is_asked_and_explicit_in_the_command(
    deltactl: Deltactl, tmp_path: Path, names: str
) -> None:
    table(tmp_path / "a.csv", names, 1.2)
    done = deltactl("inspect", "a.csv")
    assert "turns:  MOTION is rotary, UNIT is deg, rad or turn\n" in done.stdout
    assert "slides: MOTION is linear, UNIT is mm, m or inch\n" in done.stdout
    command = next(line for line in done.stdout.split("\n") if line.startswith("diagnose it:"))
    assert "unit=UNIT" in shlex.split(command)
    assert "[" not in command


@given(
    bits=st.integers(8, 24), turn=st.sampled_from([(360.0, "deg"), (2.0 * np.pi, "rad")]),
    moves=st.lists(st.integers(-1, 1), min_size=60, max_size=200),
    decimals=st.integers(1, 3), zero=st.floats(-5.0, 5.0),
)  # fmt: skip
def test_any_encoder(
    bits: int, turn: tuple[float, str], moves: list[int], decimals: int, zero: float
) -> None:
    full, unit = turn
    step = full / 2.0**bits
    digits = decimals - int(np.floor(np.log10(step)))
    places = np.cumsum([1] * 8 + moves)
    found = of_encoder(np.round(step * places + step * round(zero / step), digits))
    assert found is not None
    assert found[0] == unit
    assert str(2**bits) in found[1]


def test_the_count_of_a_geared_encoder_is_no_step_of_degrees() -> None:
    """2 pi/16384 behind a gear of 9 is within 0.8 % of 360/2^23 degrees."""
    step = 2.0 * np.pi / 2**14 / 9.0
    assert of_encoder(step * np.round(0.5 * ASKED / step)) is None


@pytest.mark.parametrize("step", [0.5, 0.1, 0.05, 0.025, 0.02, 0.01, 0.005, 0.002, 0.001, 0.0001])
def test_decimal_steps_are_those_of_no_encoder(step: float) -> None:
    assert of_encoder(step * np.round(8.0 * ASKED / step)) is None


@pytest.mark.study
def test_a_table_of_degrees_beside_our_names_is_diagnosed_as_it_is_inspected(
    deltactl: Deltactl, tmp_path: Path
) -> None:
    """`t` and `command` are names of the contract; `theta` up to 150 is not, and in degrees."""
    asked = 150.0 * ASKED
    seen = 2.0 + asked + 0.02 * np.random.default_rng(2).standard_normal(len(T_S))
    cells = np.stack([T_S, asked, seen, np.gradient(seen, T_S)], axis=1)
    head = "t,command,theta,rate"
    np.savetxt(tmp_path / "own.csv", cells, "%.7f", ",", header=head, comments="")
    (tmp_path / "axis.yaml").write_text("kind: servo_axis\nname: a\nmotion: rotary\n")
    found = deltactl("diagnose", "own.csv", "--robot", "axis.yaml")
    assert found.returncode == 0, found.stderr
    assert "position=theta[deg]" in found.stderr
    assert re.search(r"\+(1\.99|2\.00)\d* degrees", found.stdout)
    assert "Settle this first" not in found.stdout


@pytest.mark.study
def test_columns_of_the_contract_beyond_a_joint_get_the_proposal_of_inspect(
    deltactl: Deltactl, tmp_path: Path
) -> None:
    """A motor may turn so far, so that only the reader knows."""
    table(tmp_path / "far.csv", "command,position", 150.0)
    (tmp_path / "axis.yaml").write_text("kind: servo_axis\nname: a\nmotion: rotary\n")
    heading = (tmp_path / "far.csv").read_text().replace("time,", "t,", 1)
    (tmp_path / "far.csv").write_text(heading)
    found = deltactl("diagnose", "far.csv", "--robot", "axis.yaml")
    assert "--set 'position=position[deg]' --set 'command=command[deg]'" in found.stderr
    assert found.stdout.startswith("Settle this first")
