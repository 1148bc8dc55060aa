"""What a notebook uses: `import deltactl` and the functions that it lists."""

from __future__ import annotations

import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest

import deltactl
from deltactl.foundation.errors import ConfigError, MissingFile

AXIS = """\
kind: servo_axis
name: slide
motion: linear
"""


@pytest.fixture
def slide(tmp_path: Path) -> Path:
    """A slide whose reading is 2 % larger than its command, in columns with names of their own."""
    t_s = np.arange(0.0, 20.0, 0.02)
    asked_mm = 40.0 * np.sin(0.8 * t_s) + 15.0 * np.sin(2.1 * t_s)
    noise_mm = np.random.default_rng(3).normal(0.0, 0.01, len(t_s))
    rows = np.column_stack([t_s, asked_mm, 1.02 * asked_mm + noise_mm])
    np.savetxt(
        tmp_path / "log.csv", rows, delimiter=",", header="time_s,target,seen", comments="",
        fmt="%.5f",
    )  # fmt: skip
    (tmp_path / "slide.yaml").write_text(AXIS)
    return tmp_path


COLUMNS = {"t": "time_s[s]", "command": "target[mm]", "position": "seen[mm]"}


def test_the_package_is_light() -> None:
    """The pulse process imports it too, and needs no numpy for that."""
    heavy = "import sys, deltactl; print([m for m in ('numpy', 'pydantic') if m in sys.modules])"
    done = subprocess.run([sys.executable, "-c", heavy], capture_output=True, text=True, check=True)
    assert done.stdout.strip() == "[]"


def test_everything_listed_is_there() -> None:
    for name in deltactl.__all__:
        assert callable(getattr(deltactl, name))
    assert set(deltactl.__all__) <= set(dir(deltactl))
    with pytest.raises(AttributeError, match="diagnoze"):
        deltactl.diagnoze  # noqa: B018


def test_a_table_of_another_program_is_diagnosed(slide: Path) -> None:
    pytest.importorskip("scipy", reason="the diagnosis needs the extra 'diagnosis'")
    answer = deltactl.diagnose(slide / "log.csv", slide / "slide.yaml", columns=COLUMNS)
    found = {finding.effect: finding for finding in answer.findings}
    assert "gear_ratio" in found
    (size,) = found["gear_ratio"].parameters.values()
    assert size.value == pytest.approx(1.02, abs=0.002)
    assert answer.to_json()["verdict"] == answer.verdict
    assert "1.02" in str(answer)
    answer.save_report(slide / "why.html")
    assert "1.02" in (slide / "why.html").read_text(encoding="utf-8")
    answer.save_robot(slide / "better.yaml")
    better = deltactl.load_robot(slide / "better.yaml")
    assert [entry.effect for entry in better.effects] == ["gear_ratio"]


def test_what_a_table_holds_is_shown(slide: Path) -> None:
    pytest.importorskip("scipy", reason="the diagnosis needs the extra 'diagnosis'")
    seen = deltactl.inspect(slide / "log.csv", COLUMNS)
    assert seen.kind == "servo_axis"
    recording = deltactl.read_recording(slide / "log.csv", COLUMNS)
    assert float(np.abs(recording.columns["command"]).max()) == pytest.approx(0.055, abs=0.002)


def test_a_job_is_simulated(tmp_path: Path) -> None:
    ended = deltactl.simulate("heart.yaml", record=tmp_path / "heart.mcap", seed=1)
    assert (ended.outcome, ended.recording) == ("done", str(tmp_path / "heart.mcap"))
    recording = deltactl.read_recording(tmp_path / "heart.mcap")
    assert {"steps_1", "range_z"} <= set(recording.columns)


def test_mistakes_are_named(slide: Path) -> None:
    with pytest.raises(MissingFile, match="nowhere"):
        deltactl.load_robot("nowhere.yaml")
    with pytest.raises(ConfigError, match="position"):
        deltactl.read_recording(slide / "log.csv", {"position": 3})  # type: ignore[dict-item]
