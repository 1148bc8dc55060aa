"""A folder or module of the reader's that is called as one of the program's shadows nothing."""

from __future__ import annotations

import os
import subprocess
import sys
import tomllib
from pathlib import Path

import pytest

from deltactl_start import HOME, OwnPackages, own_packages

NAMES = sorted(own_packages(HOME))
START = "from deltactl_start import main; main()"
"""What the `deltactl` script does."""


def start(folder: Path, *words: str, path: str) -> subprocess.CompletedProcess[str]:
    return subprocess.run(
        [sys.executable, *words], cwd=folder,
        env=os.environ | {"PYTHONPATH": path, "COLUMNS": "100"},
        capture_output=True, text=True, check=False,
    )  # fmt: skip


@pytest.fixture
def shadowing(tmp_path: Path) -> Path:
    """A folder with a package of each name, half of which are modules."""
    for index, name in enumerate([*NAMES, "config", "tests"]):
        if index % 2:
            (tmp_path / f"{name}.py").write_text("raise RuntimeError('the wrong one')\n")
        else:
            (tmp_path / name).mkdir()
            (tmp_path / name / "__init__.py").write_text("raise RuntimeError('the wrong one')\n")
    return tmp_path


def test_every_package_that_is_shipped_is_known() -> None:
    find = tomllib.loads((HOME / "pyproject.toml").read_text())["tool"]["setuptools"]["packages"]
    shipped = {name.rstrip("*") for name in find["find"]["include"]}
    assert {name for name in shipped if (HOME / name / "__init__.py").is_file()} <= set(NAMES)
    assert {"foundation", "firmware_py", "repair", "command_line", "web", "fleet"} <= set(NAMES)


@pytest.mark.parametrize("name", NAMES)
def test_an_empty_package_of_that_name_before_the_program(tmp_path: Path, name: str) -> None:
    (tmp_path / name).mkdir()
    (tmp_path / name / "__init__.py").write_text("")
    path = os.pathsep.join([str(tmp_path), str(HOME)])
    done = start(tmp_path, "-P", "-c", START, "check", "heart.yaml", path=path)
    assert (done.returncode, done.stderr) == (0, "")
    assert "may run" in done.stdout


def test_all_names_at_once_in_the_working_folder(shadowing: Path) -> None:
    """The folder itself stands in PYTHONPATH, as with `PYTHONPATH=` or a trailing colon."""
    path = os.pathsep.join(["", str(HOME)])
    done = start(shadowing, "-c", START, "run", "heart.yaml", path=path)
    assert done.returncode == 0, done.stderr
    assert "heart" in done.stdout


def test_processes_that_the_program_starts_find_it_too(shadowing: Path) -> None:
    """The page's workers are started with `python -m`."""
    asked = (
        "import deltactl_start, subprocess, sys; deltactl_start.own_packages_first();"
        "subprocess.run([sys.executable, '-P', '-m', 'command_line.main', '--version'])"
    )
    path = os.pathsep.join([str(shadowing), str(HOME)])
    done = start(shadowing, "-P", "-c", asked, path=path)
    assert (done.stdout[:9], done.stderr) == ("deltactl ", "")


def test_in_a_wheel_only_the_program_s_own_are_taken_from_its_folder(tmp_path: Path) -> None:
    """Beside others in site-packages: who sets PYTHONPATH may mean another numpy."""
    for name in ("web", "numpy", "systemd"):
        (tmp_path / name).mkdir()
        (tmp_path / name / "__init__.py").write_text("")
    record = tmp_path / "deltactl-0.1.0.dist-info" / "RECORD"
    record.parent.mkdir()
    record.write_text(
        "web/__init__.py,sha256=x,0\nweb/shapes/__init__.py,sha256=x,0\n"
        "systemd/99-deltactl.rules,sha256=x,9\ndeltactl_start.py,sha256=x,9\n"
    )
    assert own_packages(tmp_path) == {"web"}
    finder = OwnPackages(tmp_path)
    found = finder.find_spec("web", None)
    assert found is not None
    assert found.origin == str(tmp_path / "web" / "__init__.py")
    assert finder.find_spec("numpy", None) is None
