"""What `check` says of its figures: whether they are good; first, whether a robot is too coarse."""

from __future__ import annotations

import json
from pathlib import Path

import pytest

SIZES = (
    "--base-radius-mm", "95", "--platform-radius-mm", "35", "--upper-arm-mm", "110",
    "--forearm-mm", "260", "--microsteps-per-rev", "3200", "--gear-ratio", "4",
)  # fmt: skip


@pytest.fixture
def printed(deltactl, tmp_path: Path) -> Path:
    deltactl("init", "delta", "printed.yaml", *SIZES, "--sensors", "none")
    return tmp_path / "printed.yaml"


def flat(text: str) -> str:
    return " ".join(text.split())


def test_a_fine_robot_is_said_to_be_one(deltactl, printed: Path) -> None:
    said = flat(deltactl("check", f"{printed.stem}-circle.yaml").stdout)
    assert said.startswith("printed-circle may run robot")
    assert "RMS in x, y and z together (good: less than 1 % of the path's 88 mm)" in said
    assert "as the row 'commanded' of a run shows it" in said
    assert "singularity margin 0.64 (good: 1 is best" in said
    assert (
        json.loads(deltactl("check", "printed-circle.yaml", "--json").stdout)["too_coarse"] is None
    )


def test_a_robot_as_coarse_as_its_path_is_named_first(deltactl, printed: Path) -> None:
    printed.write_text(printed.read_text().replace("per_rev: 3200", "per_rev: 4"))
    said = deltactl("check", "printed-circle.yaml").stdout
    first = flat(said).split("robot printed")[0]
    assert "may run, but printed is too coarse for it: one microstep moves the platform" in first
    assert "the path is 88 mm wide" in first
    rates = next(line for line in said.splitlines() if line.startswith("peak step rate"))
    assert " 0," not in rates
    assert "(too coarse for a path of 88 mm)" in flat(said)
    found = json.loads(deltactl("check", "printed-circle.yaml", "--json").stdout)
    assert "too coarse" in found["too_coarse"]


@pytest.mark.parametrize(
    ("speeds", "said"), [(("20", "40"), "20 to 40 mm/s"), (("40", "40"), "40 mm/s")]
)
@pytest.mark.usefixtures("printed")
def test_the_speed_is_that_of_the_legs(
    deltactl, tmp_path: Path, speeds: tuple[str, str], said: str
) -> None:
    """The job's own 50 mm/s holds for none of them."""
    rows = ["x,y,z,speed", "0,0,0,", f"30,0,0,{speeds[0]}", f"30,30,0,{speeds[1]}"]
    (tmp_path / "p.csv").write_text("\n".join(rows))
    words = ("p.yaml", "--robot", "printed.yaml", "--origin", "0 0 -287", "--speed", "50")
    shown = deltactl("convert", "p.csv", *words).stdout
    assert f"accelerated, {said}" in shown
