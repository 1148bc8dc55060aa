"""What a version promises: what is to go has a date, and all that is made carries a version."""

from __future__ import annotations

import contextlib
import json
import re
from importlib import metadata
from pathlib import Path
from typing import Any

import numpy as np
import pytest
import yaml
from packaging.version import Version
from typer.testing import CliRunner

import deltactl as dc
from deltactl.charts.page import page
from deltactl.cli.main import app
from deltactl.cli.old_spellings import OLD_SPELLINGS
from deltactl.foundation.release import GONE_IN, NAMES, own_version
from deltactl.recording.reading.reader import read_run
from tests.release.project import PROJECT, PYTHONS, ROOT, VERSION

CHANGES = (ROOT / "CHANGELOG.md").read_text(encoding="utf-8")
CATEGORIES = {"Added", "Changed", "Deprecated", "Removed", "Fixed", "Security"}
"""Of keepachangelog.com; a topic may stand behind one."""


@pytest.mark.parametrize("old", [*OLD_SPELLINGS, *NAMES])
def test_what_is_to_go_is_still_to_go(old: str) -> None:
    """Fails in the release in which it has to be gone: remove it from the table, and its code."""
    assert Version(VERSION) < Version(GONE_IN), f"{old} goes in {GONE_IN}"


@pytest.mark.parametrize("old", [one for one in NAMES if one.isidentifier()])
def test_an_old_name_in_python_warns_and_names_the_new_one_and_the_release(old: str) -> None:
    assert old not in dc.__all__
    with pytest.warns(DeprecationWarning, match=re.escape(f"deltactl.{old} goes")) as warned:
        _used(getattr(dc, old))
    assert warned[0].filename == __file__
    said = str(warned[0].message)
    assert NAMES[old] in said
    assert f"release {GONE_IN}" in said


def _used(made: Any) -> None:
    """Use it, if it is no class: on a file that is not there."""
    if not isinstance(made, type):
        with contextlib.suppress(OSError, ValueError):
            made(Path("nowhere") / "nothing.yaml")


def test_an_old_command_names_the_release_in_which_it_goes() -> None:
    (old,) = (one for one, new in OLD_SPELLINGS.items() if new == "--version")
    done = CliRunner().invoke(app, [old])
    assert f"release {GONE_IN}" in done.stderr


def test_the_changelog_is_kept_by_release() -> None:
    releases = re.findall(r"^## (.+)$", CHANGES, re.MULTILINE)
    assert releases[0].startswith("[Unreleased]")
    earlier = [re.fullmatch(r"\[(\d+\.\d+\.\d+)\] - \d{4}-\d\d-\d\d", one) for one in releases[1:]]
    assert all(earlier), releases
    numbers = [Version(found[1]) for found in earlier if found]
    assert numbers == sorted(numbers, reverse=True)
    assert numbers[0] <= Version(VERSION)
    topics = re.findall(r"^### (\w+)", CHANGES, re.MULTILINE)
    assert {*topics} <= CATEGORIES


def test_the_policy_names_all_that_is_promised() -> None:
    head = " ".join(CHANGES.split("\n## ")[0].split())
    for promised in (
        *("robot file", "job", "recording", "column", "JSON contract", "`--json`"),
        *("`deltactl.__all__`", "command", "exit status", "socket", "`/api/v1`", "`deltactl mcp`"),
        *("warns", "names what replaces it", "release in which it goes"),
    ):
        assert promised in head, promised
    for free in ("Figures of a diagnosis", "wording"):
        assert free in head, free


def test_all_places_have_one_version() -> None:
    cited = yaml.safe_load((ROOT / "CITATION.cff").read_text(encoding="utf-8"))
    assert cited["version"] == VERSION
    assert PYTHONS[0] == PROJECT["requires-python"].removeprefix(">=")


@pytest.mark.study
def test_every_report_carries_the_version(tmp_path: Path) -> None:
    """Answers as JSON, every HTML page, the metadata of a recording, and `--version`."""
    version = metadata.version("deltactl")
    assert own_version() == version
    assert f'<meta name="generator" content="deltactl {version}">' in page("title", [])
    assert (
        json.loads(CliRunner().invoke(app, ["--version", "--json"]).stdout)["deltactl"] == version
    )

    t_s = np.arange(0.0, 12.0, 0.02)
    asked = np.sin(1.3 * t_s)
    table = {"t": t_s, "command": asked, "position": asked + 1e-4 * np.cos(40.0 * t_s)}
    rows = np.column_stack(list(table.values()))
    np.savetxt(tmp_path / "a.csv", rows, "%.9g", ",", header=",".join(table), comments="")
    robot = dc.Robot.from_text("{kind: servo_axis, name: axis, motion: rotary}")
    diagnosis = dc.diagnose(tmp_path / "a.csv", robot)
    assert diagnosis.to_json()["version"] == version
    diagnosis.save_report(tmp_path / "why.html")
    assert f"deltactl {version}" in (tmp_path / "why.html").read_text(encoding="utf-8")


@pytest.mark.study
def test_a_recording_carries_the_version(tmp_path: Path) -> None:
    job = tmp_path / "short.yaml"
    job.write_text(
        "name: short\nrobot: zhao-2023.yaml\npath: {shape: straight, to_m: [0.0, 0.01, -0.45]}\n"
        "timing: {mode: accelerated, speed_mps: 0.1}\ninverse_kinematics: {kind: geometry}\n"
    )
    asked = ["run", str(job), "--simulate", "--record", str(tmp_path / "r.mcap")]
    done = CliRunner().invoke(app, asked)
    assert done.exit_code == 0, done.output
    version = metadata.version("deltactl")
    assert read_run(tmp_path / "r.mcap").configuration.version == version
    shown = CliRunner().invoke(app, ["report", str(tmp_path / "r.mcap"), "--json"])
    assert json.loads(shown.stdout)["version"] == version
