"""A package that the small install leaves out: one line that names a command which adds it."""

from __future__ import annotations

import importlib
import subprocess
import sys
import tomllib
from pathlib import Path

import pytest

from deltactl.foundation import extras
from deltactl.foundation.errors import MissingExtra

ROOT = Path(__file__).parents[2]


SHORT_JOB = """name: short
robot: zhao-2023.yaml
path: {shape: straight, to_m: [0.0, 0.01, -0.45]}
timing: {mode: accelerated, speed_mps: 0.1}
inverse_kinematics: {kind: geometry}
"""


@pytest.mark.study
def test_diagnose_without_scipy_is_one_line() -> None:
    """In a process of its own: modules that are loaded anew here would be there twice."""
    without = "import sys; sys.modules['scipy'] = None; from deltactl.cli.main import main; main()"
    robot = str(ROOT / "config" / "zhao-2023.yaml")
    done = subprocess.run(
        [sys.executable, "-c", without, "diagnose", "x.csv", "--robot", robot],
        capture_output=True, text=True, check=False,
    )  # fmt: skip
    (line,) = done.stderr.splitlines()
    assert done.returncode == 2
    assert line.startswith("deltactl: diagnose needs scipy")


NAMED = f"PYTHON={sys.executable}"
"""make then asks none of the interpreters on the path whether it has pip."""
ON_A_PC = "scipy mujoco bokeh pandas threadpoolctl rosbags pyarrow nicegui sklearn tensorflow keras"
"""What the small install does not bring."""


ONE_AFTER_ANOTHER = f"""
import sys
sys.modules |= dict.fromkeys("{ON_A_PC}".split())
from deltactl.cli.main import main
for line in sys.stdin.read().splitlines():
    sys.argv = ["deltactl", *line.split("|")]
    try:
        main()
    except SystemExit as ended:
        if ended.code:
            raise
"""


@pytest.mark.study
def test_a_raspberry_pi_runs_the_robot_with_what_it_has(tmp_path: Path) -> None:
    (tmp_path / "one.nc").write_text("G0 X0 Y0 Z0\nG1 X5 F600\n")
    (tmp_path / "short.yaml").write_text(SHORT_JOB)
    lines = (
        "convert|one.nc|one.yaml|--robot|zhao-2023.yaml|--origin|0 0 -450",
        "check|short.yaml",
        "run|short.yaml|--simulate|--record|run.mcap|--report|run.html",
    )
    done = subprocess.run(
        [sys.executable, "-c", ONE_AFTER_ANOTHER],
        input="\n".join(lines), capture_output=True, text=True, check=False, cwd=tmp_path,
    )  # fmt: skip
    assert done.returncode == 0, done.stderr
    assert (tmp_path / "one.yaml").is_file()
    assert "Bokeh" in (tmp_path / "run.html").read_text()


@pytest.mark.parametrize("extra", ["diagnosis", "training", "tables", "proof", "proof,training"])
def test_in_a_working_copy_the_command_is_a_target_of_make(
    extra: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.chdir(tmp_path)
    command = extras.how_to_install(extra)
    dry = subprocess.run(
        ["make", "-n", *command.split()[1:], NAMED], capture_output=True, text=True, check=True
    )
    assert f"'.[{extra}]'" in dry.stdout


@pytest.mark.parametrize("extra", ["diagnosis", "training", "tables"])
def test_elsewhere_it_names_the_packages_themselves(
    extra: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """No index has `deltactl`, and a virtual environment may have no pip of its own."""
    monkeypatch.setattr(extras, "IMPORT_ROOT", tmp_path)
    command = extras.how_to_install(extra)
    project = tomllib.loads((ROOT / "pyproject.toml").read_text())["project"]
    parts = project["optional-dependencies"]
    own = [one for one in parts[extra] if not one.startswith("deltactl[")]
    own += parts["charts"] if "deltactl[charts]" in parts[extra] else []
    for wanted in own:
        assert wanted.split(";")[0].split(">")[0].split("<")[0] in command
    assert "deltactl" not in command.split(" install ")[1]


def test_in_an_environment_of_pipx_it_is_pipx_that_adds(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(extras, "IMPORT_ROOT", tmp_path)
    monkeypatch.setattr("sys.prefix", str(tmp_path))
    assert "pipx" not in extras.how_to_install("tables")
    (tmp_path / "pipx_metadata.json").touch()
    assert extras.how_to_install("tables").startswith("pipx inject deltactl 'pyarrow")


@pytest.mark.parametrize(("on_a_pi", "seen"), [("yes", True), ("", False)])
def test_on_a_pi_the_environment_sees_the_packages_of_the_system(
    on_a_pi: str, seen: bool, tmp_path: Path
) -> None:
    """There is no lgpio for Python 3.13 but Debian's."""
    python = f"{tmp_path}/.venv/bin/python"
    asked = ["make", "-n", f"ON_A_PI={on_a_pi}", f"VENV={tmp_path}/.venv", NAMED, python]
    dry = subprocess.run(asked, cwd=ROOT, capture_output=True, text=True, check=True)
    assert ("--system-site-packages" in dry.stdout) is seen


def test_a_broken_package_of_ours_is_no_missing_extra() -> None:
    with pytest.raises(MissingExtra, match="diagnose needs nothing_such"), needs_it():
        importlib.import_module("nothing_such")
    with pytest.raises(ImportError, match="cannot import"), needs_it():
        exec("from deltactl.foundation.errors import no_such_name")


def needs_it():
    return extras.needs("diagnosis", "diagnose")
