"""The run that an answer proposes can be run as it stands in the answer."""

from __future__ import annotations

import json
from pathlib import Path
from typing import Any

import pytest

from deltactl.diagnosis import api
from deltactl.firmware_py.named_files import find
from deltactl.recording.tables.flat import FlatRecording


def test_the_robot_file_that_the_proposed_job_names_exists(
    make: Any, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """The robot's own name need not be that of its file, nor the folder that of the job."""
    robot = tmp_path / "robots" / "mine.yaml"
    robot.parent.mkdir()
    robot.write_text(find("zhao-2023.yaml").read_text())
    answer = make("explained")
    plan = answer.next_experiment.model_copy(update={"job": {"robot": "zhao-2023.yaml"}})
    monkeypatch.setattr(
        api, "diagnose_recordings",
        lambda *_: answer.model_copy(update={"next_experiment": plan}),
    )  # fmt: skip
    monkeypatch.chdir(tmp_path)
    out = tmp_path / "answer.json"
    empty = FlatRecording.__new__(FlatRecording)
    monkeypatch.setattr(api, "excerpt", lambda *_: empty)
    api.diagnose([Path("x.csv")], Path("robots/mine.yaml"), json_out=out, read=lambda _: empty)
    named = json.loads(out.read_text())["next_experiment"]["job"]["robot"]
    assert Path(named) == robot
