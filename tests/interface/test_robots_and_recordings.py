"""Recordings and robots of the Python interface: to files, to data frames, and back."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

import deltactl as dc
from deltactl.foundation.errors import RecordingError, UnreachablePoint

pd = pytest.importorskip("pandas", reason="data frames need the extra 'diagnosis'")

COLUMNS = {"t": "time_ms[ms]", "command": "target[deg]", "position": "angle[deg]"}


@pytest.fixture
def frame() -> pd.DataFrame:
    """A log of another program: ms and degrees."""
    t_s = np.arange(50) * 0.02
    asked_deg = 10.0 * np.sin(t_s)
    return pd.DataFrame({"time_ms": 1e3 * t_s, "target": asked_deg, "angle": asked_deg + 0.1})


def test_a_frame_is_read_as_its_file_is(frame: pd.DataFrame, tmp_path: Path) -> None:
    frame.to_csv(tmp_path / "log.csv", index=False)
    from_file = dc.read(tmp_path / "log.csv", COLUMNS)
    from_frame = dc.Recording.from_pandas(frame, COLUMNS, source="mine")
    assert from_frame.source == "mine"
    for name in ("t", "command", "position"):
        np.testing.assert_array_equal(from_file[name], from_frame[name])
    np.testing.assert_allclose(from_frame["position"], np.deg2rad(frame["angle"]))
    assert not {"target", "angle"} & set(from_file.table.extra)


def test_what_an_inspection_found_is_read_as_it_is(frame: pd.DataFrame, tmp_path: Path) -> None:
    frame.to_csv(tmp_path / "log.csv", index=False)
    found = dc.inspect(tmp_path / "log.csv", COLUMNS)
    as_found = dc.read(tmp_path / "log.csv", found.options)
    np.testing.assert_array_equal(
        as_found["command"], dc.read(tmp_path / "log.csv", COLUMNS)["command"]
    )


def test_to_pandas_and_back_and_through_every_file(frame: pd.DataFrame, tmp_path: Path) -> None:
    recording = dc.Recording.from_pandas(frame.assign(mark=range(50)), COLUMNS)
    table = recording.to_pandas()
    assert list(table.columns) == ["t", "command", "position", "mark"]
    assert table.attrs["units"]["t"] == "s"
    again = [dc.Recording.from_pandas(table), dc.Recording.from_pandas(table.set_index("t"))]
    for ending in ("csv", "csv.gz", "parquet", "mat"):
        recording.save(tmp_path / f"out.{ending}")
        again.append(dc.Recording.from_file(tmp_path / f"out.{ending}"))
    for one in again:
        assert len(one) == 50
        for name in ("t", "command", "position", "mark"):
            np.testing.assert_allclose(one[name], recording[name], rtol=1e-12)


def test_what_a_frame_lacks_is_named_as_the_frame_is_called(frame: pd.DataFrame) -> None:
    with pytest.raises(RecordingError, match=r"^mine: has no column 't'; it has time_ms, target"):
        dc.Recording.from_pandas(frame, source="mine")
    with pytest.raises(RecordingError, match=r"^mine: .*speed"):
        dc.Recording.from_pandas(frame, COLUMNS | {"velocity": "speed[rad/s]"}, source="mine")
    with pytest.raises(KeyError, match="there are t, command, position"):
        dc.Recording.from_pandas(frame, COLUMNS)["angle"]


def test_a_robot_is_loaded_written_and_read_again(tmp_path: Path) -> None:
    robot = dc.Robot.load("zhao-2023.yaml")
    robot.save(tmp_path / "mine.yaml")
    again = dc.Robot.load(tmp_path / "mine.yaml")
    assert (again.model, again.text) == (robot.model, robot.text)
    with pytest.raises(RecordingError, match="exists already"):
        again.save(tmp_path / "mine.yaml")
    again.save(tmp_path / "mine.yaml", replace=True)


def test_kinematics_of_many_positions_and_back() -> None:
    delta = dc.kinematics(dc.Robot.load("zhao-2023.yaml"))
    xyz = np.random.default_rng(1).uniform([-0.1, -0.1, -0.5], [0.1, 0.1, -0.4], (500, 3))
    angles = delta.inverse(xyz)
    assert angles.shape == (500, 3)
    np.testing.assert_allclose(delta.forward(angles), xyz, atol=1e-12)
    assert delta.inverse(xyz[0]).shape == (3,)
    np.testing.assert_allclose(delta.inverse(xyz[0]), angles[0], atol=1e-12)


def test_what_is_out_of_reach_is_refused_or_not_a_number() -> None:
    delta = dc.kinematics("zhao-2023.yaml")
    xyz = [[0.0, 0.0, -0.45], [0.0, 0.0, -2.0], [0.0, 0.0, -3.0]]
    with pytest.raises(UnreachablePoint, match=r"row 1: \(0, 0, -2\) m .* 1 more row"):
        delta.inverse(xyz)
    there = np.isfinite(delta.inverse(xyz, strict=False)).all(axis=1)
    assert there.tolist() == [True, False, False]
    with pytest.raises(UnreachablePoint, match="row 1"):
        delta.forward([[0.5, 0.5, 0.5], [np.nan, 0.0, 0.0]])
    with pytest.raises(ValueError, match=r"xyz must have shape \(n, 3\)"):
        delta.inverse([0.0, 0.1])


def test_kinematics_takes_known_effects_into_account() -> None:
    robot = dc.Robot.load("zhao-2023.yaml")
    off = "effects: [{effect: home_offset, component: motor2, parameters: {angle: 0.01}}]"
    corrected = dc.kinematics(dc.Robot.from_text(f"{robot.text}\n{off}\n"))
    plain = dc.kinematics(robot)
    there = [0.02, 0.01, -0.45]
    np.testing.assert_allclose(
        corrected.inverse(there) - plain.inverse(there), [0.0, -0.01, 0.0], atol=1e-9
    )
    np.testing.assert_allclose(corrected.forward(corrected.inverse(there)), there, atol=1e-9)
