"""Files of many moves: what each costs in memory and time, and when a file is refused."""

from __future__ import annotations

import json
import math
import time
import tracemalloc
from pathlib import Path

import numpy as np
import pytest

from deltactl.firmware_py.importing.by_line import checked_job
from deltactl.firmware_py.importing.drawn import job_text
from deltactl.firmware_py.importing.gcode import read_gcode
from deltactl.firmware_py.importing.points_table import read_points
from deltactl.firmware_py.job_file import JobFile
from deltactl.firmware_py.paths.legs import Legs
from deltactl.firmware_py.paths.way import way
from deltactl.foundation.strict_yaml import Document

ORIGIN = (0.0, 0.0, -0.3)
HOW = ("many", "zhao-2023.yaml", 0.05, 0.0005)


def spiral_mm(count: int) -> list[tuple[float, float]]:
    return [(0.01 * n * math.cos(n), 0.01 * n * math.sin(n)) for n in range(count)]


def written(folder: Path, count: int, name: str = "many.nc") -> Path:
    path = folder / name
    is_gcode = name.endswith(".nc")
    head, row = (
        ("G0 X0 Y0 Z0 F900", "G1 X{:.3f} Y{:.3f}") if is_gcode else ("x,y,z", "{:.3f},{:.3f},0")
    )
    path.write_text("\n".join([head, *(row.format(x, y) for x, y in spiral_mm(count))]) + "\n")
    return path


@pytest.mark.parametrize("name", ["many.nc", "many.csv"])
def test_a_move_takes_little_memory_until_it_is_a_job(tmp_path: Path, name: str) -> None:
    path = written(tmp_path, 3000, name)
    tracemalloc.start()
    read = read_gcode if name.endswith(".nc") else read_points
    found = read(path, ORIGIN)
    made = checked_job(path, found, *HOW)
    kept_bytes = tracemalloc.get_traced_memory()[0]
    tracemalloc.stop()
    assert len(found.legs) in (2998, 2999)
    assert kept_bytes < 250 * len(found.legs) + 200_000
    assert made.path is not None


def test_the_text_of_a_job_is_the_job_that_was_checked(tmp_path: Path) -> None:
    path = tmp_path / "mixed.nc"
    path.write_text("G0 X0 Y0 Z0\nG1 X5 F900\nG2 X10 Y5 I0 J5\nG4 P250\nG3 X10 Y5 I3 J0\nG0 Z4\n")
    found = read_gcode(path, ORIGIN)
    text = job_text(found, *HOW)
    assert Document(tmp_path / "mixed.yaml", text).check(JobFile) == checked_job(path, found, *HOW)
    again = JobFile.model_validate_json(checked_job(path, found, *HOW).model_dump_json())
    assert again == checked_job(path, found, *HOW)


def test_a_wrong_leg_among_many_is_named() -> None:
    legs = [{"to_m": [0.0, 0.001 * (n % 2), -0.3]} for n in range(3000)]
    legs[2900] = {"to_m": [0.0, 11.0, -0.3]}
    job = {
        "name": "many", "robot": "zhao-2023.yaml",
        "path": {"shape": "way", "start_m": [0.0, 0.0, -0.3], "legs": legs},
        "timing": {"mode": "accelerated", "speed_mps": 0.1},
        "inverse_kinematics": {"kind": "geometry"},
    }  # fmt: skip
    with pytest.raises(ValueError, match=r"legs\.2900\.to_m\.1"):
        JobFile.model_validate_json(json.dumps(job))


def test_corners_of_many_arcs_take_little_time() -> None:
    rows = []
    for n in range(400):
        end = (0.002 * (n + 1), 0.0, 0.0)
        rows.append({"to_m": end, "centre_m": (0.002 * n + 0.001, 0.0), "clockwise": n % 3 > 0})
    began_s = time.process_time()
    path = way(np.zeros(3), Legs.of(rows), 0.0002, 0.0005)
    assert time.process_time() - began_s < 2.5  # it was 20 ms for each corner
    assert path.rest.sum() == 2
