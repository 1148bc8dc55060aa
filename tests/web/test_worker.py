"""What the page has done for it by processes of their own, when the files are bad."""

from __future__ import annotations

import json
import subprocess
import sys
from pathlib import Path

import pytest

from deltactl.firmware_py.named_files import CONFIG_FOLDER
from deltactl.recording.format.configuration import RunConfiguration
from deltactl.recording.writing.writer import RunRecorder
from deltactl.web.behind.belief import Beliefs
from deltactl.web.behind.link import DaemonLink
from deltactl.web.behind.site import Site


@pytest.fixture
def torn(tmp_path: Path) -> Path:
    """A recording of which the second half is missing."""
    path = tmp_path / "torn.mcap"
    text = (CONFIG_FOLDER / "zhao-2023.yaml").read_text(encoding="utf-8")
    job = (CONFIG_FOLDER / "heart.yaml").read_text(encoding="utf-8")
    with RunRecorder(path, RunConfiguration(text, job, "zhao-2023", "torn")) as recorder:
        for k in range(2000):
            recorder.commanded(k * 20_000_000, (1333, 1333, 1333))
    path.write_bytes(path.read_bytes()[: path.stat().st_size // 2])
    return path


@pytest.mark.parametrize("kind", ["diagnose", "run_report"])
def test_a_recording_cut_off_is_one_line_or_a_report_that_says_so(
    kind: str, torn: Path, tmp_path: Path
) -> None:
    out = tmp_path / "made"
    out.mkdir()
    made = out / "run.html"
    files = [out, out / "robot.yaml", torn] if kind == "diagnose" else [torn, made]
    call = [sys.executable, "-P", "-m", "deltactl.web.behind.worker", kind, *map(str, files)]
    done = subprocess.run(call, capture_output=True, text=True, timeout=60.0)
    said = [json.loads(line) for line in done.stdout.splitlines()]
    assert "Traceback" not in done.stderr
    if kind == "run_report":
        assert said[-1] == {"result": {}}
        assert "cut off" in made.read_text(encoding="utf-8")
    else:
        assert "torn.mcap" in said[-1]["error"]
        assert "\n" not in said[-1]["error"]


def test_moves_by_hand_are_not_listed(tmp_path: Path) -> None:
    when = "2026-01-02T03-04-05"
    jobs, moves = (f"heart-{when}", f"jog-wheel-{when}"), ("jog", "go-to", "goto")
    for name in (*jobs, *(f"{move}-{when}" for move in moves), f"jog-{when}-2"):
        (tmp_path / f"{name}.mcap").write_bytes(b"")
    site = Site(DaemonLink(None), Beliefs(), tmp_path, tmp_path)
    assert {one.path.stem for one in site.listed()} == set(jobs)
