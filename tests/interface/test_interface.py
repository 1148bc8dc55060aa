"""What a notebook uses: `import deltactl as dc`, the names that it lists, and nothing else."""

from __future__ import annotations

import doctest
import importlib
import inspect
import os
import pkgutil
import subprocess
import sys
from pathlib import Path
from types import ModuleType

import pytest

import deltactl as dc
from deltactl import interface
from deltactl.foundation.errors import ConfigError, MissingFile, RecordingError

ROOT = Path(__file__).parents[2]
LIGHT_S = 0.3
"""Time that an import of the package may take."""
USED = """
import sys, time
start = time.process_time()
import deltactl as dc
print(time.process_time() - start)
print(sorted({"numpy", "pydantic", "pandas", "scipy"} & sys.modules.keys()))
print(dc.Robot.load("zhao-2023.yaml").name)
delta = dc.kinematics("zhao-2023.yaml")
print(delta.forward(delta.inverse([0.0, 0.0, -0.45])).round(3))
job = {"name": "up", "path": {"shape": "points", "points_m": [[0.0, 0.0, -0.44]]}}
job |= {"timing": {"mode": "accelerated", "speed_mps": 0.3}}
job |= {"inverse_kinematics": {"kind": "geometry"}}
print(dc.simulate(job, "zhao-2023.yaml").ended.outcome)
dc.diagnose, dc.Client
"""
PARTS = [
    importlib.import_module(f"{interface.__name__}.{part.name}")
    for part in pkgutil.iter_modules(interface.__path__)
]


@pytest.mark.study
def test_beside_files_of_the_same_names_as_ours_nothing_is_disturbed(tmp_path: Path) -> None:
    """And the package is light: the pulse process imports it too, without numpy."""
    for name in ("models", "config", "drivers", "recording", "charts", "interface", "inspect_"):
        (tmp_path / f"{name}.py").write_text("raise SystemExit('the wrong file')\n")
    done = subprocess.run(
        [sys.executable, "-c", USED],
        cwd=tmp_path,
        env=os.environ | {"PYTHONPATH": f"{tmp_path}{os.pathsep}{ROOT}"},
        capture_output=True,
        text=True,
    )
    assert done.returncode == 0, done.stderr
    seconds, heavy, name, *there, outcome = done.stdout.split("\n")[:-1]
    assert float(seconds) < LIGHT_S
    assert (heavy, name, outcome) == ("[]", "zhao-2023", "done")
    assert there[-1].endswith("-0.45]")
    assert not list(tmp_path.glob("recordings*"))


def test_everything_listed_is_there_and_documented() -> None:
    for name in dc.__all__:
        one = getattr(dc, name)
        assert callable(one)
        assert len(inspect.getdoc(one) or "") > 40
    assert sorted(dc.__all__) == dir(dc)
    with pytest.raises(AttributeError, match="diagnoze"):
        dc.diagnoze  # noqa: B018


@pytest.mark.parametrize("part", PARTS, ids=lambda part: part.__name__.rsplit(".", 1)[-1])
def test_examples_of_the_docstrings_hold(part: ModuleType) -> None:
    pytest.importorskip("pandas", reason="data frames need the extra 'diagnosis'")
    assert doctest.testmod(part, optionflags=doctest.ELLIPSIS).failed == 0


def test_old_names_work_and_name_the_new_ones(tmp_path: Path) -> None:
    (tmp_path / "log.csv").write_text("t,command,position\n0,0,0\n0.1,0.02,0.01\n")
    with pytest.warns(DeprecationWarning, match=r"deltactl\.read\("):
        table = dc.read_recording(tmp_path / "log.csv")
    assert list(table.columns) == ["command", "position"]
    with pytest.warns(DeprecationWarning, match=r"deltactl\.Robot\.load\("):
        assert dc.load_robot("zhao-2023.yaml").kind == "delta"
    with (
        pytest.warns(DeprecationWarning, match=r"deltactl\.Client\("),
        pytest.raises(ConnectionError),
    ):
        dc.run("heart.yaml", socket=tmp_path / "no.sock")
    with pytest.warns(DeprecationWarning, match=r"deltactl\.Diagnosis"):
        assert dc.Answer is dc.Diagnosis


def test_mistakes_are_named_in_one_line(tmp_path: Path) -> None:
    (tmp_path / "log.csv").write_text("time,target,seen\n0,0,0\n0.1,0.02,0.01\n")
    with pytest.raises(MissingFile, match="nowhere"):
        dc.Robot.load("nowhere.yaml")
    with pytest.raises(ConfigError, match="position"):
        dc.read(tmp_path / "log.csv", {"position": 3})  # type: ignore[dict-item]
    with pytest.raises(RecordingError, match="has no column 't'"):
        dc.read(tmp_path / "log.csv")
    with pytest.raises(ConfigError, match="ndarray is no recording"):
        dc.diagnose(table_of_numbers(), "stepper-axis.yaml")
    with pytest.raises(ConfigError, match="int is no robot"):
        dc.diagnose(tmp_path / "log.csv", 3)  # type: ignore[arg-type]
    with pytest.raises(ConfigError, match=r"axis\.yaml: is a stepper_axis; .* needs a delta"):
        dc.kinematics("stepper-axis.yaml")


def table_of_numbers() -> list[object]:
    """What is no recording, though there is one in it."""
    import numpy as np

    return [np.zeros((3, 3))]
