"""Commands that write files, where the disk is full: what was there stays, nothing half is left."""

from __future__ import annotations

import os
import resource
import shutil
import subprocess
from collections.abc import Callable, Iterator
from contextlib import contextmanager, suppress
from pathlib import Path

import pytest
from typer.testing import CliRunner

from deltactl.cli.main import app
from deltactl.foundation.errors import DeltactlError

ROBOT = ("--base-radius-mm", "120", "--platform-radius-mm", "40", "--upper-arm-mm", "150",
         "--forearm-mm", "320", "--gear-ratio", "5", "--microsteps-per-rev", "1600")  # fmt: skip
LINES = "G21 G90\nG0 X0 Y0 Z0\nG1 X10 F600\nG1 Y10\n" + "".join(
    f"G1 X{10 + n % 7} Y{n % 5}\n" for n in range(60)
)
LIMIT_BYTES = 256


@pytest.fixture(scope="module")
def made(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A folder with a robot, a job, a recording and G-code."""
    folder = tmp_path_factory.mktemp("made")
    before = Path.cwd()
    os.chdir(folder)
    try:
        for words in (
            ("init", "delta", "my-delta.yaml", *ROBOT),
            ("run", "my-delta-circle.yaml", "--simulate", "--record", "run.mcap"),
        ):
            done = CliRunner().invoke(app, list(words))
            assert done.exit_code == 0, (done.output, done.exception)
        (folder / "part.gcode").write_text(LINES)
    finally:
        os.chdir(before)
    return folder


@contextmanager
def limited(folder: Path) -> Iterator[None]:
    """No file may grow beyond LIMIT_BYTES: a write fails half-way, as on a full disk."""
    del folder
    soft, hard = resource.getrlimit(resource.RLIMIT_FSIZE)
    resource.setrlimit(resource.RLIMIT_FSIZE, (LIMIT_BYTES, hard))
    try:
        yield
    finally:
        resource.setrlimit(resource.RLIMIT_FSIZE, (soft, hard))


@contextmanager
def mounted(folder: Path) -> Iterator[None]:
    """A disk of a megabyte, on which one page is left."""
    mount = shutil.which("mount")
    if mount is None or os.geteuid() != 0:
        pytest.skip("needs root, to mount a small disk")
    kept = {one.name: one.read_bytes() for one in folder.iterdir()}
    options = ["-t", "tmpfs", "-o", "size=1m", "tmpfs", str(folder)]
    done = subprocess.run([mount, *options], capture_output=True, text=True, check=False)
    if done.returncode:
        pytest.skip(f"a small disk cannot be mounted here: {done.stderr.strip()}")
    try:
        for name, content in kept.items():
            (folder / name).write_bytes(content)
        fill(folder)
        yield
    finally:
        os.chdir(folder.parent)
        subprocess.run(["umount", "-l", str(folder)], check=False)


def fill(folder: Path) -> None:
    descriptor = os.open(folder / "fill", os.O_WRONLY | os.O_CREAT)
    try:
        with suppress(OSError):
            while True:
                os.write(descriptor, bytes(4096))
    finally:
        os.close(descriptor)


WRITING = {
    "csv": ("export", "{made}/run.mcap", "kept.csv"),
    "gz": ("export", "{made}/run.mcap", "kept.csv.gz"),
    "parquet": ("export", "{made}/run.mcap", "kept.parquet"),
    "mat": ("export", "{made}/run.mcap", "kept.mat"),
    "report": ("report", "{made}/run.mcap", "-o", "kept.html"),
    "convert": ("convert", "{made}/part.gcode", "kept.yaml", "--robot", "{made}/my-delta.yaml",
                "--origin", "0 0 -350"),
    "init": ("init", "delta", "kept.yaml", *ROBOT),
}  # fmt: skip


@pytest.mark.parametrize("disk", [limited, mounted], ids=["limited", "mounted"])
@pytest.mark.parametrize("words", WRITING.values(), ids=WRITING)
@pytest.mark.parametrize("before", [None, "the old one, kept\n"], ids=["new", "old"])
def test_the_old_file_stays_and_nothing_else(
    made: Path,
    tmp_path: Path,
    monkeypatch: pytest.MonkeyPatch,
    words: tuple[str, ...],
    before: str | None,
    disk: Callable[[Path], Iterator[None]],
) -> None:
    folder = tmp_path / "disk"
    folder.mkdir()
    named = next(one for one in words if one.startswith("kept"))
    if before is not None:
        (folder / named).write_text(before)
        words = (*words, "--force")
    with disk(folder):  # type: ignore[attr-defined]
        there = sorted(os.listdir(folder))
        monkeypatch.chdir(folder)
        refused = CliRunner().invoke(app, [one.format(made=made) for one in words])
        assert isinstance(refused.exception, DeltactlError | OSError), refused.output
        assert "kept" in str(refused.exception)
        assert sorted(os.listdir(folder)) == there
        if before is not None:
            assert (folder / named).read_text() == before


def test_a_refused_job_leaves_the_one_before(
    made: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.chdir(tmp_path)
    (tmp_path / "job.yaml").write_text("the old one\n")
    (tmp_path / "job.yaml").chmod(0o640)
    far = ("--origin", "900 0 -350", "--force", "--robot", f"{made}/my-delta.yaml")
    refused = CliRunner().invoke(app, ["convert", f"{made}/part.gcode", "job.yaml", *far])
    assert isinstance(refused.exception, DeltactlError)
    assert (tmp_path / "job.yaml").read_text() == "the old one\n"
    assert (tmp_path / "job.yaml").stat().st_mode & 0o777 == 0o640
    assert os.listdir(tmp_path) == ["job.yaml"]


@pytest.mark.parametrize("named", ["my-delta.yaml", "./my-delta.yaml", "../made/my-delta.yaml"])
def test_a_robot_is_looked_for_in_the_current_folder(
    made: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch, named: str
) -> None:
    here = tmp_path / "made"
    (here / "sub").mkdir(parents=True)
    for name in ("my-delta.yaml", "part.gcode"):
        shutil.copy(made / name, here / name)
    monkeypatch.chdir(here)
    words = ["convert", "part.gcode", "sub/part.yaml", "--robot", named, "--origin", "0 0 -350"]
    done = CliRunner().invoke(app, words)
    assert done.exit_code == 0, (done.output, done.exception)
    here.rename(tmp_path / "moved")
    monkeypatch.chdir(tmp_path)
    done = CliRunner().invoke(app, ["check", "moved/sub/part.yaml", "--json"])
    assert done.exit_code == 0, (done.output, done.exception)


@pytest.mark.parametrize("wrong", ["file", "folder"])
def test_a_run_that_cannot_be_recorded_says_why(
    made: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch, wrong: str
) -> None:
    monkeypatch.chdir(tmp_path)
    if wrong == "file":
        (tmp_path / "recordings").write_text("")
    elif os.geteuid() == 0:
        pytest.skip("root may write everywhere")
    else:
        tmp_path.chmod(0o555)
    refused = CliRunner().invoke(app, ["run", f"{made}/my-delta-circle.yaml", "--simulate"])
    tmp_path.chmod(0o755)
    said = str(refused.exception)
    assert isinstance(refused.exception, DeltactlError)
    assert ("File exists" if wrong == "file" else "Permission denied") in said
    assert "refused" in said
