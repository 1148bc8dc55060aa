"""A data set survives what interrupts its collection, and says in one line why it is no use."""

from __future__ import annotations

import contextlib
import resource
import signal
from collections.abc import Iterator
from pathlib import Path

import numpy as np
import pytest

from deltactl.foundation.errors import MissingFile, RecordingError
from deltactl.models.network.metadata import fingerprint
from deltactl.models.robot import DeltaRobot
from deltactl.models.robot_files import load_delta
from deltactl.models.training.dataset import SAMPLES, DataSettings, DataSetWriter, load_dataset

CONFIG = Path(__file__).resolve().parents[2] / "config"


@pytest.fixture(scope="module")
def robot() -> DeltaRobot:
    return load_delta(CONFIG / "zhao-2023.yaml")


def settings_of(robot: DeltaRobot, seed: int = 1) -> DataSettings:
    assert robot.drive is not None
    assert robot.sensors is not None
    return DataSettings(
        robot=robot.name,
        fingerprint=fingerprint(robot.geometry),
        geometry=robot.geometry,
        drive=robot.drive,
        sensors=robot.sensors,
        machine="as-built",
        seed=seed,
        angle_deg=(-20.0, 110.0),
        t_pwm_s=0.006,
        dwell_s=0.5,
    )


def samples(count: int, seed: int = 0) -> list[tuple[np.ndarray, np.ndarray]]:
    rng = np.random.default_rng(seed)
    counts, position_m = (
        rng.integers(-800, 4000, (count, 3)),
        rng.normal(scale=0.1, size=(count, 3)),
    )
    return list(zip(counts, position_m, strict=True))


@contextlib.contextmanager
def disk_of(bytes_left: int) -> Iterator[None]:
    """Files of this process may not grow beyond so many bytes: a full disk without a disk."""
    before = resource.getrlimit(resource.RLIMIT_FSIZE)
    handler = signal.signal(signal.SIGXFSZ, signal.SIG_IGN)
    resource.setrlimit(resource.RLIMIT_FSIZE, (bytes_left, before[1]))
    try:
        yield
    finally:
        resource.setrlimit(resource.RLIMIT_FSIZE, before)
        signal.signal(signal.SIGXFSZ, handler)


def test_what_was_written_is_read_again(tmp_path: Path, robot: DeltaRobot) -> None:
    taken = samples(60)
    for part in (taken[:25], taken[25:]):
        with DataSetWriter(tmp_path, settings_of(robot)) as writer:
            writer.append(part)
    data = load_dataset(tmp_path)
    data.check(robot)
    assert np.array_equal(data.counts, [counts for counts, _ in taken])
    assert np.allclose(data.position_m, [position for _, position in taken], atol=5.1e-7)
    assert data.digest != data.first(59).digest


def test_a_torn_line_is_left_out_and_cut_off(tmp_path: Path, robot: DeltaRobot) -> None:
    with DataSetWriter(tmp_path, settings_of(robot)) as writer:
        writer.append(samples(60))
    whole = (tmp_path / SAMPLES).read_bytes()
    (tmp_path / SAMPLES).write_bytes(whole + b"61,12,3")
    data = load_dataset(tmp_path)
    assert data.torn
    assert len(data) == 60
    with DataSetWriter(tmp_path, settings_of(robot)) as writer:
        assert writer.count == 60
    assert (tmp_path / SAMPLES).read_bytes() == whole


def test_a_full_disk_is_one_line_and_loses_nothing(tmp_path: Path, robot: DeltaRobot) -> None:
    with DataSetWriter(tmp_path, settings_of(robot)) as writer:
        writer.append(samples(10))
        whole = (tmp_path / SAMPLES).read_bytes()
        with disk_of(len(whole) + 70), pytest.raises(RecordingError, match="cannot be written"):
            writer.append(samples(10, seed=1))
        assert (tmp_path / SAMPLES).read_bytes() == whole
        writer.append(samples(10, seed=1))
    assert len(load_dataset(tmp_path)) == 20


def test_another_robot_or_seed_is_refused(tmp_path: Path, robot: DeltaRobot) -> None:
    with DataSetWriter(tmp_path, settings_of(robot)) as writer:
        writer.append(samples(60))
    with pytest.raises(RecordingError, match="seed"):
        DataSetWriter(tmp_path, settings_of(robot, seed=2))
    other = load_delta(CONFIG / "zhao-2023-as-printed.yaml")
    with pytest.raises(RecordingError, match="not with"):
        load_dataset(tmp_path).check(other)


def test_useless_samples_are_named(tmp_path: Path, robot: DeltaRobot) -> None:
    taken = samples(60)
    taken[6][1][:] = np.nan
    with DataSetWriter(tmp_path / "nan", settings_of(robot)) as writer:
        writer.append(taken)
    with pytest.raises(RecordingError, match="sample 7 has no position"):
        load_dataset(tmp_path / "nan").check(robot)
    for name, row, column, value in (("gone", 7, 4, "1e9"), ("turned", 9, 1, "99999999999")):
        with DataSetWriter(tmp_path / name, settings_of(robot)) as writer:
            writer.append(samples(60))
        lines = (tmp_path / name / SAMPLES).read_text().splitlines()
        parts = lines[row].split(",")
        parts[column] = value
        lines[row] = ",".join(parts)
        (tmp_path / name / SAMPLES).write_text("\n".join([*lines, ""]))
        with pytest.raises(RecordingError, match=f"sample {row} is none of this robot"):
            load_dataset(tmp_path / name).check(robot)
    for _, position_m in taken:
        position_m[:] = [0.1, position_m[1] if np.isfinite(position_m[1]) else 0.0, 0.3]
    with DataSetWriter(tmp_path / "same", settings_of(robot)) as writer:
        writer.append(taken)
    with pytest.raises(RecordingError, match="column x_m is the same"):
        load_dataset(tmp_path / "same").check(robot)
    with pytest.raises(RecordingError, match="has 60 samples and 100 are needed"):
        load_dataset(tmp_path / "nan").check(robot, fewest=100)


def test_a_damaged_data_set_is_not_gone_on_with(tmp_path: Path, robot: DeltaRobot) -> None:
    with DataSetWriter(tmp_path, settings_of(robot)) as writer:
        writer.append(samples(60))
    whole = (tmp_path / SAMPLES).read_text()
    lines = whole.splitlines()
    lines[7] = ",".join([*lines[7].split(",")[:5], "nan", "-0.3"])
    damaged = "\n".join([*lines, ""])
    (tmp_path / SAMPLES).write_text(damaged)
    with pytest.raises(RecordingError, match=r"sample 7 has no position \(NaN\)"):
        DataSetWriter(tmp_path, settings_of(robot))
    assert (tmp_path / SAMPLES).read_text() == damaged
    (tmp_path / SAMPLES).write_text(whole)
    with DataSetWriter(tmp_path, settings_of(robot)) as writer:
        assert writer.count == 60


def test_a_damaged_line_and_a_missing_folder_are_named(tmp_path: Path, robot: DeltaRobot) -> None:
    with DataSetWriter(tmp_path, settings_of(robot)) as writer:
        writer.append(samples(60))
    lines = (tmp_path / SAMPLES).read_text().splitlines(keepends=True)
    lines[5] = lines[5].replace(",", ";")
    (tmp_path / SAMPLES).write_text("".join(lines))
    with pytest.raises(RecordingError, match=r"samples.csv:6: is not sample 5"):
        load_dataset(tmp_path)
    with pytest.raises(MissingFile):
        load_dataset(tmp_path / "nowhere")
