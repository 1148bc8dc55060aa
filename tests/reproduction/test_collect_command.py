"""`deltactl network collect`: what it writes, and that nothing is lost however it ends."""

from __future__ import annotations

import os
import signal
import time
from pathlib import Path

import pytest

from deltactl.models.training.dataset import SAMPLES, load_dataset
from tests.rigs.started import started

pytest.importorskip("mujoco", reason="the as-built robot needs the extra 'proof'")


@pytest.mark.study
def test_a_survey_of_the_as_built_robot(here, surveyed: Path, tmp_path: Path) -> None:
    out = tmp_path / "data"
    done = here("network", "collect", "--samples", "60", "--as-built", "zhao-2023", "--out", out)
    assert done.returncode == 0, done.stderr
    assert "60 samples" in done.stdout
    data = load_dataset(out)
    assert len(data) == 60
    assert data.settings.machine == "as-built"
    # A longer survey with the same seed begins with the same samples.
    assert data.first(50).digest == load_dataset(surveyed).first(50).digest


def test_killed_in_the_middle_and_gone_on_with(here, surveyed: Path, tmp_path: Path) -> None:
    out = tmp_path / "data"
    words = [
        "network",
        "collect",
        "--samples",
        "3000",
        "--as-built",
        "zhao-2023",
        "--out",
        str(out),
    ]
    process = started(*words)
    samples = out / SAMPLES
    waited_s = time.monotonic() + 60.0
    while not (samples.exists() and samples.stat().st_size > 6000):
        assert process.poll() is None, process.stderr and process.stderr.read()
        assert time.monotonic() < waited_s
        time.sleep(0.01)
    os.kill(process.pid, signal.SIGKILL)
    process.communicate()
    with samples.open("ab") as file:
        file.write(b"torn,1")
    taken = len(load_dataset(out))
    assert 0 < taken < 3000
    wanted = str(taken + 20)
    done = here("network", "collect", "--samples", wanted, "--as-built", "zhao-2023", "--out", out)
    assert done.returncode == 0, done.stderr
    data, whole = load_dataset(out), load_dataset(surveyed)
    assert len(data) == int(wanted)
    assert data.first(110).digest == whole.first(110).digest


@pytest.mark.study
def test_going_on_gives_what_one_go_gives(here, surveyed: Path, tmp_path: Path) -> None:
    out = tmp_path / "data"
    for samples in ("70", "120"):
        done = here(
            "network", "collect", "--samples", samples, "--as-built", "zhao-2023", "--out", out
        )
        assert done.returncode == 0, done.stderr
    assert (out / SAMPLES).read_bytes() == (surveyed / SAMPLES).read_bytes()


@pytest.mark.study
def test_without_its_state_a_survey_is_gone_through_again_and_kept(
    here, surveyed: Path, tmp_path: Path
) -> None:
    """A copy of the two files of a data set; or a power cut before the first state."""
    out = tmp_path / "data"
    out.mkdir()
    whole = (surveyed / SAMPLES).read_bytes()
    for name in ("settings.yaml", SAMPLES):
        (out / name).write_bytes((surveyed / name).read_bytes())
    fewer = here("network", "collect", "--samples", "30", "--as-built", "zhao-2023", "--out", out)
    assert fewer.returncode == 0, fewer.stderr
    assert "120 samples" in fewer.stdout
    assert (out / SAMPLES).read_bytes() == whole
    (out / SAMPLES).write_bytes(b"".join(whole.splitlines(keepends=True)[:61]))
    more = here("network", "collect", "--samples", "120", "--as-built", "zhao-2023", "--out", out)
    assert more.returncode == 0, more.stderr
    assert (out / SAMPLES).read_bytes() == whole


@pytest.mark.study
def test_a_full_disk_is_one_line_and_keeps_what_was_taken(cli, here, tmp_path: Path) -> None:
    out = tmp_path / "data"
    words = ("network", "collect", "--samples", "300", "--as-built", "zhao-2023", "--out", out)
    full = cli(*words, disk=9000)
    assert full.returncode == 2
    assert len(full.stderr.strip().splitlines()) == 1
    assert "cannot be written" in full.stderr
    kept = len(load_dataset(out))
    assert kept > 0
    again = here(*words)
    assert again.returncode == 0, again.stderr
    assert len(load_dataset(out)) == 300


def test_another_seed_or_robot_is_not_mixed_in(here, surveyed: Path, tmp_path: Path) -> None:
    words = ("network", "collect", "--samples", "130", "--as-built", "zhao-2023", "--out", surveyed)
    other_seed = here(*words, "--seed", "2")
    assert other_seed.returncode == 2
    assert "another seed" in other_seed.stderr
    other_robot = here(*words, "--robot", "zhao-2023-as-printed.yaml")
    assert other_robot.returncode == 2
    assert "is about robot" in other_robot.stderr
    missing = here("network", "collect", "--as-built", "nowhere.yaml", "--out", tmp_path / "x")
    assert missing.returncode == 2
    assert "cannot be read" in missing.stderr


@pytest.mark.study
def test_a_survey_of_the_simulated_chain(here, tmp_path: Path) -> None:
    out = tmp_path / "data"
    done = here("network", "collect", "--samples", "2", "--simulate", "--out", out)
    assert done.returncode == 0, done.stderr
    data = load_dataset(out)
    assert data.settings.machine == "simulated"
    from deltactl.models.linkage import Linkage, forward

    nominal_m = forward(Linkage.of(data.settings.geometry), data.angles_rad).position_m
    assert abs(nominal_m - data.position_m).max() < 0.004  # 1.5 mm of noise, 25 readings
    kept = (out / SAMPLES).read_bytes()
    for samples in ("2", "1"):
        again = here("network", "collect", "--samples", samples, "--simulate", "--out", out)
        assert again.returncode == 0, again.stderr
        assert "2 samples" in again.stdout
        assert (out / SAMPLES).read_bytes() == kept
    changed = kept.replace(b"\n2,", b"\n2,1")
    (out / SAMPLES).write_bytes(changed)
    foreign = here("network", "collect", "--samples", "3", "--simulate", "--out", out)
    assert foreign.returncode == 2
    assert "its last sample is no pose of this survey" in foreign.stderr
    assert (out / SAMPLES).read_bytes() == changed
