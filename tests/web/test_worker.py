"""What the page has done for it by processes of their own, when the files are bad."""

from __future__ import annotations

import asyncio
import json
import subprocess
import sys
from pathlib import Path

import pytest

from deltactl.firmware_py.named_files import CONFIG_FOLDER
from deltactl.foundation.errors import ServiceError
from deltactl.recording.format.configuration import RunConfiguration
from deltactl.recording.writing.writer import RunRecorder
from deltactl.web.behind.known_robots import KnownRobots
from deltactl.web.behind.link import DaemonLink
from deltactl.web.behind.site import Site
from deltactl.web.behind.tasks import LIMITS_S, Tasks
from deltactl.web.behind.worker import KINDS


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


@pytest.mark.study
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
    site = Site(DaemonLink(None), KnownRobots(), tmp_path, tmp_path)
    assert {one.path.stem for one in site.listed()} == set(jobs)


def workers_on(file: Path) -> list[str]:
    """Processes that have to do with a file."""
    found = []
    for line in Path("/proc").glob("[0-9]*/cmdline"):
        try:
            text = line.read_text(errors="replace")
        except OSError:
            continue
        if str(file) in text:
            found.append(text)
    return found


def test_a_task_has_a_time_limit_and_then_the_next_has_its_turn(tmp_path: Path) -> None:
    table = tmp_path / "table.csv"
    table.write_text("t,q\n" + "".join(f"{k * 0.01},{k % 7}\n" for k in range(400)))

    async def both() -> dict[str, object]:
        with pytest.raises(ServiceError, match=r"given up after 0\.05 s") as short:
            await Tasks({"inspect": 0.05}).run("inspect", table)
        assert "deltactl inspect" in str(short.value)
        assert not workers_on(table)
        patient = Tasks({"inspect": 60.0, "diagnose": 0.05})
        first = asyncio.create_task(patient.run("diagnose", tmp_path, tmp_path / "r.yaml", table))
        said: list[str] = []
        second = patient.run("diagnose", tmp_path, tmp_path / "r.yaml", table, progress=said.append)
        ended = await asyncio.gather(first, second, return_exceptions=True)
        assert all("given up" in str(one) for one in ended)
        assert said == ["waiting for its turn"]
        return await patient.run("inspect", table)

    assert asyncio.run(both())["columns"]
    assert not workers_on(table)


def test_each_kind_of_task_has_a_limit_of_minutes_and_not_of_hours() -> None:
    assert LIMITS_S.keys() == KINDS.keys()
    assert all(30.0 <= limit_s <= 3600.0 for limit_s in LIMITS_S.values())
