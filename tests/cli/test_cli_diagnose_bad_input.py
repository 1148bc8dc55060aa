"""Bad recordings through the real command line: one line and exit status 2, or honest words."""

from __future__ import annotations

import gzip
import subprocess
from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest

from deltactl.cli.main import main
from deltactl.models.chain import Chain, Commands
from deltactl.models.robot_files import load_delta
from deltactl.recording.tables.flat import FlatRecording
from deltactl.recording.tables.flat_files import write_flat

Deltactl = Callable[..., subprocess.CompletedProcess[str]]
Refused = Callable[[Path, str], None]
Columns = dict[str, np.ndarray]
ROBOT = Path(__file__).parents[2] / "config" / "zhao-2023.yaml"
SAMPLES = 1500


@pytest.fixture
def refused(monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]) -> Refused:
    """Ask `deltactl diagnose` for a file; it must end with status 2 and one line with words."""

    def ask(path: Path, words: str) -> None:
        monkeypatch.setattr("sys.argv", ["deltactl", "diagnose", str(path), "--robot", str(ROBOT)])
        with pytest.raises(SystemExit) as caught:
            main()
        out, err = capsys.readouterr()
        lines = [line for line in err.splitlines() if line.strip()]
        assert caught.value.code == 2, err
        assert len(lines) == 1, err
        assert path.name in lines[0]
        assert words in lines[0]
        assert out == ""

    return ask


@pytest.fixture(scope="module")
def good() -> FlatRecording:
    """Half a minute of three arms that swing, seen by three sensors with noise."""
    rng = np.random.default_rng(3)
    t_s = 0.02 * np.arange(SAMPLES)
    rad = 0.6 + 0.2 * np.sin(t_s[:, None] * np.array([0.5, 0.7, 1.1]))
    robot = load_delta(ROBOT)
    fresh = np.arange(SAMPLES) == 0
    seen = Chain.delta(robot).simulate(Commands.of_angles(t_s, rad, fresh), []).ranges
    seen = np.round(seen + 0.002 * rng.standard_normal(seen.shape), 3)
    columns = {f"command_{j + 1}": rad[:, j] for j in range(3)}
    columns |= {f"range_{a}": seen[:, i] for i, a in enumerate("xyz")}
    columns |= {f"status_{a}": np.zeros(SAMPLES) for a in "xyz"}
    return FlatRecording(t_s, columns, {}, "good")


def _empty_cells(columns: Columns) -> None:
    for axis in "xyz":
        columns[f"range_{axis}"][:] = np.nan


def _degrees(columns: Columns) -> None:
    for motor in (1, 2, 3):
        columns[f"command_{motor}"] = np.degrees(columns[f"command_{motor}"])


def _another_run(columns: Columns) -> None:
    for motor in (1, 2, 3):
        columns[f"command_{motor}"] = columns[f"command_{motor}"][::-1].copy()


@pytest.mark.parametrize(
    ("change", "words"),
    [
        (_empty_cells, "nothing observed"),
        (_degrees, "look like degrees"),
        (_another_run, "do not belong together"),
    ],
)
def test_columns_that_cannot_be_right(
    refused: Refused,
    tmp_path: Path,
    good: FlatRecording,
    change: Callable[[Columns], None],
    words: str,
) -> None:
    columns = {name: values.copy() for name, values in good.columns.items()}
    change(columns)
    path = tmp_path / "run.csv"
    write_flat(FlatRecording(good.t_s, columns, {}, "bad"), path)
    refused(path, words)


def test_shuffled_time(refused: Refused, tmp_path: Path, good: FlatRecording) -> None:
    path = tmp_path / "run.csv"
    write_flat(good, path)
    heading, *rows = path.read_text().splitlines()
    order = np.random.default_rng(1).permutation(len(rows))
    path.write_text("\n".join([heading, *(rows[i] for i in order)]) + "\n")
    refused(path, "increas")


@pytest.mark.parametrize("rows", [0, 1, 20])
def test_too_few_rows(refused: Refused, tmp_path: Path, good: FlatRecording, rows: int) -> None:
    path = tmp_path / "run.csv"
    write_flat(good, path)
    path.write_text("\n".join(path.read_text().splitlines()[: rows + 1]) + "\n")
    refused(path, "")


@pytest.mark.parametrize(
    ("name", "content"),
    [
        ("empty.csv", b""),
        ("words.csv", b"these are no numbers\n"),
        ("cut.csv.gz", gzip.compress(b"t,range_x\n" + b"0.1,0.2\n" * 5000, mtime=0)[:60]),
        ("cut.parquet", b"PAR1\0\0\0"),
        ("cut.mcap", b"\x89MCAP0\r\n\x01"),
        ("no.mcap", b"something else"),
    ],
    ids=["empty", "words", "cut gzip", "cut parquet", "cut mcap", "no mcap"],
)
def test_files_that_are_none(refused: Refused, tmp_path: Path, name: str, content: bytes) -> None:
    path = tmp_path / name
    path.write_bytes(content)
    refused(path, "")


@pytest.mark.study
def test_in_a_process_of_its_own(deltactl: Deltactl, tmp_path: Path, good: FlatRecording) -> None:
    path = tmp_path / "run.csv"
    write_flat(good, path)
    micro = ROBOT.with_name("uzunovic-2013.yaml")
    done = deltactl("diagnose", str(path), "--robot", str(micro), status=2)
    lines = [line for line in done.stderr.splitlines() if line.strip()]
    assert len(lines) == 1
    assert "another robot's file" in lines[0]
    assert done.stdout == ""
