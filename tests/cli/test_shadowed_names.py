"""A folder or module of the reader's that is called as a part of the program shadows nothing."""

from __future__ import annotations

import os
import subprocess
import sys
from pathlib import Path

import pytest

from deltactl.foundation.process import IMPORT_ROOT, PACKAGE

NAMES = sorted(path.name for path in PACKAGE.iterdir() if path.is_dir() and path.name[0] != "_")


@pytest.fixture
def shadowing(tmp_path: Path) -> Path:
    """A folder with a package or module of each name, which may not be imported."""
    for index, name in enumerate([*NAMES, "tests"]):
        if index % 2:
            (tmp_path / f"{name}.py").write_text("raise RuntimeError('the wrong one')\n")
        else:
            (tmp_path / name).mkdir()
            (tmp_path / name / "__init__.py").write_text("raise RuntimeError('the wrong one')\n")
    return tmp_path


@pytest.mark.study
def test_names_of_the_reader_s_come_first_on_the_path(shadowing: Path) -> None:
    """The folder itself stands in PYTHONPATH, as with a trailing colon; planning is a process."""
    heart = (PACKAGE / "config" / "heart.yaml").read_text(encoding="utf-8")
    (shadowing / "quick.yaml").write_text(heart.replace("t_pwm_s: 0.006", "t_pwm_s: 0.002"))
    words = ["run", "quick.yaml", "--simulate"]
    done = subprocess.run(
        [sys.executable, "-m", "deltactl.cli.main", *words], cwd=shadowing,
        env=os.environ | {"PYTHONPATH": os.pathsep.join(["", str(shadowing), str(IMPORT_ROOT)])},
        capture_output=True, text=True, check=False,
    )  # fmt: skip
    assert (done.returncode, "heart" in done.stdout) == (0, True), done.stderr


def test_the_package_is_whole() -> None:
    """A link that is missing from a working copy would only show where it is used."""
    stays_at_the_top = {"config", "drivers", "firmware_py", "models", "systemd"}
    assert stays_at_the_top <= set(NAMES)
    for name in stays_at_the_top:
        place = PACKAGE / name
        assert not place.is_symlink() or not os.path.isabs(os.readlink(place))
