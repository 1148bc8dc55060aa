"""Columns of command, position and effort: which were used, and which would tell more."""

from __future__ import annotations

import html
from collections.abc import Callable
from pathlib import Path
from subprocess import CompletedProcess

import numpy as np
import pytest

from tests.axes.axis_rigs import ForcedRig
from tests.cli.test_cli_save_robot import ROBOT, slide

Deltactl = Callable[..., CompletedProcess[str]]
FORCED = f"{ROBOT}inertia: 2.0\n"


@pytest.mark.study
def test_a_command_that_is_not_used_beside_an_effort_is_told(
    deltactl: Deltactl, tmp_path: Path
) -> None:
    run = ForcedRig(coulomb=1.0).record(1, span_s=8.0)
    read = run.columns["position"]
    table = np.column_stack([run.t_s, read, read, run.columns["effort"]])
    head = "t,Soll,position,U"
    np.savetxt(tmp_path / "log.csv", table, "%.9g", ",", header=head, comments="")
    (tmp_path / "slide.yaml").write_text(FORCED, encoding="utf-8")
    words = ("diagnose", "log.csv", "--robot", "slide.yaml", "--set", "command=Soll")
    (line,) = deltactl(*words, "--set", "effort=U").stderr.splitlines()
    assert line.startswith("log.csv: the command (Soll) is not used: with `inertia` in the robot")
    assert line.endswith("leave out --set effort=U")
    assert not deltactl(*words).stderr


@pytest.mark.study
def test_an_effort_that_is_there_is_named_with_what_to_type(
    deltactl: Deltactl, tmp_path: Path
) -> None:
    slide(tmp_path / "plain.csv")
    table = np.loadtxt(tmp_path / "plain.csv", delimiter=",", skiprows=1)
    table = np.column_stack([table, np.sign(np.gradient(table[:, 1]))])
    head = "t,command,position,Stellgröße [V]"
    np.savetxt(tmp_path / "log.csv", table, "%.9g", ",", header=head, comments="", encoding="utf-8")
    (tmp_path / "slide.yaml").write_text(ROBOT, encoding="utf-8")
    said = deltactl("diagnose", "log.csv", "--robot", "slide.yaml", "--report", "page.html").stdout
    said = " ".join(said.split())
    assert "or record the effort" not in said
    page = html.unescape((tmp_path / "page.html").read_text(encoding="utf-8"))
    assert "or have the effort read as well: --set 'effort=Stellgröße', with `inertia`" in page


@pytest.mark.study
def test_a_force_that_is_multiplied_by_a_gain_of_currents_is_told(
    deltactl: Deltactl, tmp_path: Path
) -> None:
    run = ForcedRig(coulomb=1.0).record(1, span_s=8.0)
    table = np.column_stack([run.t_s, run.columns["position"], run.columns["effort"]])
    head = "t,position,F [N]"
    np.savetxt(tmp_path / "log.csv", table, "%.9g", ",", header=head, comments="")
    (tmp_path / "slide.yaml").write_text(f"{FORCED}effort_gain: 1.2\n", encoding="utf-8")
    words = ("diagnose", "log.csv", "--robot", "slide.yaml")
    said = " ".join(deltactl(*words, "--set", "effort=F [N]").stderr.split())
    assert "'F' is in N already and is multiplied by the robot file's effort_gain (1.2)" in said
    (tmp_path / "slide.yaml").write_text(FORCED, encoding="utf-8")
    assert "multiplied" not in deltactl(*words, "--set", "effort=F [N]").stderr
