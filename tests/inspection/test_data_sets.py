"""LeRobot data sets: the folder of version 2 and 3, joints by name, values in degrees or not."""

from __future__ import annotations

import json
import subprocess
from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest

from tests.rigs import needs

pytest.importorskip("pyarrow", reason=needs.LOGS)

import pyarrow as pa
import pyarrow.parquet as pq

from deltactl.foundation.errors import RecordingError
from deltactl.recording.foreign.inspection import inspect
from deltactl.recording.foreign.mapping import load_mapping
from deltactl.recording.foreign.reading import read_mapped

Deltactl = Callable[..., subprocess.CompletedProcess[str]]
NAMES = ["shoulder_pan.pos", "elbow_flex.pos", "gripper.pos"]
ROWS = 300
T_S = np.arange(ROWS) / 30.0


def episode(number: int, largest: float, joints: int = len(NAMES)) -> pa.Table:
    """Each joint follows 60 ms late; the last goes furthest."""
    sizes = largest * np.arange(1, joints + 1) / joints
    asked = np.stack([a * np.sin((1.0 + 0.1 * a / largest) * T_S + number) for a in sizes], axis=1)
    seen = np.stack([np.interp(T_S - 0.06, T_S, one) for one in asked.T], axis=1)
    return pa.table({
        "action": asked.astype(np.float32).tolist(),
        "observation.state": seen.astype(np.float32).tolist(),
        "timestamp": T_S.astype(np.float32), "frame_index": np.arange(ROWS),
        "episode_index": np.full(ROWS, number), "task_index": np.zeros(ROWS, dtype=int),
    })  # fmt: skip


def write(folder: Path, version: int, largest: float = 90.0) -> None:
    """Two episodes: in a file each (version 2), or in one (version 3)."""
    names = NAMES if version == 3 else {"motors": NAMES}
    feature = {"dtype": "float32", "shape": [len(NAMES)], "names": names}
    features = {"action": feature, "observation.state": feature}
    chunk = folder / "data" / "chunk-000"
    for made in (folder / "meta", chunk):
        made.mkdir(parents=True)
    (folder / "meta" / "info.json").write_text(json.dumps({"fps": 30, "features": features}))
    episodes = [episode(number, largest) for number in (0, 1)]
    if version == 3:
        pq.write_table(pa.concat_tables(episodes), chunk / "file-000.parquet")
        return
    for number, one in enumerate(episodes):
        pq.write_table(one, chunk / f"episode_{number:06d}.parquet")


@pytest.mark.study
@pytest.mark.parametrize("version", [2, 3])
def test_a_folder_is_looked_at_and_diagnosed(
    deltactl: Deltactl, tmp_path: Path, version: int
) -> None:
    write(tmp_path / "arm", version)
    shown = deltactl("inspect", "arm").stdout
    assert f"joints   {', '.join(NAMES)}" in shown
    assert "uneven" not in shown
    assert "command=action.shoulder_pan.pos[deg]" in shown
    asked = ["--set", "command=action.elbow_flex.pos"]
    assert (
        "position=observation.state.elbow_flex.pos[deg]"
        in deltactl("inspect", "arm", *asked).stdout
    )
    deltactl("init", "axis", "axis.yaml", "--motion", "rotary")
    refused = deltactl("diagnose", "arm", "--robot", "axis.yaml", status=2).stderr
    assert "one of its joints is diagnosed at a time" in refused
    seen = ["--set", "position=observation.state.elbow_flex.pos[deg]"]
    times = ["--set", "t=timestamp", "--set", "segment=episode_index"]
    answer = deltactl(
        "diagnose", "arm", "--robot", "axis.yaml", "--set", f"{asked[1]}[deg]", *seen, *times
    )
    assert "follows late" in " ".join(answer.stdout.split())


def test_a_joint_by_its_place_is_the_one_with_that_name(tmp_path: Path) -> None:
    write(tmp_path / "arm", 3)
    options = ["t=timestamp", "segment=episode_index", "command=action.{}[deg]"]
    by_place, by_name = (
        read_mapped(tmp_path / "arm", load_mapping(None, [one.format(joint) for one in options]))
        for joint in (1, NAMES[1])
    )
    np.testing.assert_array_equal(by_place.column("command"), by_name.column("command"))
    assert len(by_place.stretches()) == 2


@pytest.mark.parametrize(
    ("largest", "says"),
    [(170.0, "go up to 1"), (99.0, "normalised values of -100 to 100"), (3.0, None)],
)
def test_what_the_joints_are_in(tmp_path: Path, largest: float, says: str | None) -> None:
    """A joint that hardly moves is in the unit of the others."""
    write(tmp_path / "arm", 3, largest)
    found = inspect(tmp_path / "arm")
    assert (
        any(says in one for one in found.warnings)
        if says
        else not found.guesses[f"action.{NAMES[0]}"].unit
    )
    assert says is None or found.guesses[f"action.{NAMES[0]}"].unit == "deg"


def test_two_joints_are_no_delta(tmp_path: Path) -> None:
    pq.write_table(episode(0, 90.0, joints=2), tmp_path / "two.parquet")
    found = inspect(tmp_path / "two.parquet")
    assert found.kind == "servo_axis"
    assert found.guesses["action.0"].name == "command"
    assert any("more joints than one: action.1" in one for one in found.warnings)


@pytest.mark.parametrize(
    ("info", "says"), [("{}", r"info\.json: is not that of"), ('{"features": {}}', "fetch those")]
)
def test_a_data_set_that_is_not_whole(tmp_path: Path, info: str, says: str) -> None:
    (tmp_path / "arm" / "meta").mkdir(parents=True)
    (tmp_path / "arm" / "meta" / "info.json").write_text(info)
    with pytest.raises(RecordingError, match=says):
        inspect(tmp_path / "arm")
