"""Stops, waits and outputs of a G-code file become steps of the job, and are carried out."""

from __future__ import annotations

import json
import math
import subprocess
import time
from collections.abc import Callable
from pathlib import Path

import pytest

from deltactl.firmware_py.importing.by_line import checked_job
from deltactl.firmware_py.importing.drawn import job_text
from deltactl.firmware_py.importing.gcode import read_gcode
from deltactl.firmware_py.importing.gcode_tables import meanings_of
from deltactl.firmware_py.job_file import load_job
from deltactl.firmware_py.job_targets import path_of
from deltactl.firmware_py.named_files import find
from deltactl.firmware_py.path_file import Way
from deltactl.firmware_py.robot_file import load_robot
from deltactl.foundation.errors import ConfigError

Deltactl = Callable[..., subprocess.CompletedProcess[str]]
PART = """\
M3 S1000
G4 P100
G0 X0 Y0 Z0
M0 (mount: "the part", 'é')
G1 X20 F1200
G3 X10 Y10 I-10 J0
M5
G1 X0
"""
OPTIONS = ["--robot", "gripper-delta.yaml", "--origin", "0 0 -300"]
CODES = ["--code", "M3=gripper on", "--code", "M5=gripper off"]


@pytest.mark.parametrize("codes", [[], ["M3=gripper on", "M5=gripper off"]])
def test_the_job_that_is_checked_is_the_one_that_is_written(
    tmp_path: Path, codes: list[str]
) -> None:
    source, path = tmp_path / "part.nc", tmp_path / "part.yaml"
    source.write_text(PART + "G20\nG1 X0.123456789 Y-0.3333333 F3.3333333\n")
    drawn = read_gcode(source, (1e-7, 0.0, -1 / 3), meanings_of([], codes, ["gripper"]))
    how = ("part", "gripper-delta.yaml", 0.05, 0.0005)
    path.write_text(job_text(drawn, *how), encoding="utf-8")
    assert load_job(path) == checked_job(source, drawn, *how)


@pytest.mark.study
def test_from_stops_and_outputs_to_a_run(deltactl: Deltactl, tmp_path: Path) -> None:
    (tmp_path / "part.nc").write_text(PART)
    said = deltactl("convert", "part.nc", "part.yaml", *OPTIONS, *CODES)
    assert "pauses" in said.stdout
    steps = load_job(tmp_path / "part.yaml").steps
    assert steps is not None
    kinds = [next(key for key, value in dict(one).items() if value is not None) for one in steps]
    assert kinds == ["set", "wait_s", "path", "pause", "path", "set", "path"]
    ran = deltactl("run", "part.yaml", "--simulate", "--json")
    assert json.loads(ran.stdout)["outcome"] == "done"
    assert "the part" in ran.stderr


def test_an_output_that_the_robot_has_not_is_named(deltactl: Deltactl, tmp_path: Path) -> None:
    (tmp_path / "part.nc").write_text(PART)
    words = ("convert", "part.nc", "part.yaml", *OPTIONS, "--code", "M3=spindle on")
    assert "which has gripper" in " ".join(deltactl(*words, status=2).stderr.split())


@pytest.mark.parametrize("far", [2, 5, 6, 8])
def test_a_place_out_of_reach_is_told_by_its_line_behind_a_step(
    deltactl: Deltactl, tmp_path: Path, far: int
) -> None:
    lines = ["M3", "G0 X0 Y0 Z0", "M0", "G1 X20 F1200", "G1 X30", "M0", "M5", "G1 X0", "G1 X10"]
    move = lines[far] if lines[far].startswith("G") else lines[far + 1]
    number = 1 + lines.index(move, far)
    lines[number - 1] = "G1 X900 F600"
    (tmp_path / "part.nc").write_text("\n".join(lines))
    refused = deltactl("convert", "part.nc", "part.yaml", *OPTIONS, *CODES, status=2).stderr
    assert f"part.nc:{number}: " in " ".join(refused.split())
    assert "steps." not in refused


def test_all_moves_out_of_reach_are_named(deltactl: Deltactl, tmp_path: Path) -> None:
    (tmp_path / "part.nc").write_text("G0 X0 Y0 Z0\nX900\nX0\nX800\nX0\nX700\n")
    refused = deltactl("convert", "part.nc", "part.yaml", *OPTIONS, status=2).stderr
    assert "part.nc:2: " in refused
    assert "lines 4, 6" in " ".join(refused.split())


def test_what_no_job_may_have_is_told_by_all_its_lines(tmp_path: Path) -> None:
    source = tmp_path / "part.nc"
    source.write_text("G0 X0 Y0 Z0\nG1 X20000 F600\nX1 F1e9\n".replace("1e9", "900000000") + "X9")
    drawn = read_gcode(source, (0.0, 0.0, 0.0))
    with pytest.raises(ConfigError) as error:
        checked_job(source, drawn, "part", "gripper-delta.yaml", 0.05, 0.0)
    assert [one.split(":")[1] for one in error.value.args] == ["2", "3", "4"]


def test_a_job_of_many_short_moves_is_made_in_a_bounded_time(tmp_path: Path) -> None:
    """Each of them took a look at a thousand others."""
    source = tmp_path / "many.nc"
    places = ((20 * math.cos(n), 20 * math.sin(n * 0.7)) for n in range(10_000))
    source.write_text("".join(f"G1 X{x:.3f} Y{y:.3f} Z0 F600 E1\n" for x, y in places))
    begun_s = time.process_time()
    drawn = read_gcode(source, (0.0, 0.0, -0.3))
    job = checked_job(source, drawn, "many", "gripper-delta.yaml", 0.05, 0.0005)
    assert isinstance(job.path, Way)
    job = job.model_copy(update={"path": job.path.model_copy(update={"spacing_m": 0.02})})
    path_of(job, load_robot(find("gripper-delta.yaml")))
    assert time.process_time() - begun_s < 6.0
