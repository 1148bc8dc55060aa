"""What is said of a corrected robot: its commands are off the targets on purpose."""

from __future__ import annotations

from pathlib import Path

from deltactl.cli.robot.check import limit_rows
from deltactl.firmware_py.run_report.tracking import said_of_corrections
from deltactl.models.robot import EffectEntry
from deltactl.models.robot_files import load_with_effects
from deltactl.repair.limit import Limit

ROBOT = Path(__file__).parents[2] / "config" / "zhao-2023.yaml"


def test_a_run_says_which_corrections_its_commands_hold() -> None:
    plain = load_with_effects(ROBOT)
    play = EffectEntry(effect="gear_backlash", component="motor1", parameters={"width": 0.01})
    home = EffectEntry(effect="home_offset", component="motor2", parameters={"angle": 0.01})
    corrected = plain.model_copy(update={"effects": (play, home)})
    assert said_of_corrections(plain) == ""
    said = said_of_corrections(corrected)
    assert "gear backlash of motor1" in said
    assert "home" not in said, "the places of commands hold those that do not remember"


def test_the_expected_error_is_one_figure_and_promises_no_row_of_a_corrected_robot() -> None:
    """A part was larger than the whole: 0.37 mm, 0.38 mm of it from even motion."""
    corrected = Limit(rms_m=3.8e-4, steps_m=1e-4, sizes_m=3.7e-4, left_m=0.0, counted_m=3.7e-4)
    ((_, said),) = limit_rows(corrected)
    assert said.startswith("0.38 mm")
    assert "0.37 mm RMS" not in said
    assert "'commanded'" not in said
    as_built = Limit(rms_m=1e-4, steps_m=1e-4, sizes_m=0.0, left_m=0.0, counted_m=1.6e-4)
    ((_, said),) = limit_rows(as_built)
    assert said.startswith("0.16 mm")
    assert "'commanded'" in said
