"""However long a recording is: bounded memory, stretches spread over all of it, and it is said."""

from __future__ import annotations

import subprocess
import sys
from collections.abc import Callable
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from deltactl.diagnosis.admission import excerpt as admission
from deltactl.diagnosis.admission.arm_columns import check_steps
from deltactl.diagnosis.admission.excerpt import excerpts, thinned
from deltactl.diagnosis.admission.options import ADMISSION
from deltactl.diagnosis.api import diagnose, diagnose_recordings
from deltactl.diagnosis.plants.delta.safe_poses import MotionLimits
from deltactl.diagnosis.report.screen import sentences
from deltactl.foundation.errors import RecordingError
from deltactl.models.robot import DeltaRobot, ServoAxis
from deltactl.recording.tables.excerpt import STRETCHES, excerpt
from deltactl.recording.tables.flat import FlatRecording
from deltactl.recording.tables.flat_files import read_flat, write_flat

ZHAO = Path(__file__).parents[2] / "config" / "zhao-2023.yaml"
# The kernel's own high-water mark: getrusage hands a child the mark of the process that started it.
PEAK_MB = """
def peak_mb():
    for line in open("/proc/self/status"):
        if line.startswith("VmHWM"):
            return int(line.split()[1]) / 1024
"""
CHILD = """
import sys
from pathlib import Path
from deltactl.diagnosis.api import diagnose
answer = diagnose([Path(sys.argv[1])], Path(sys.argv[2]))
print(peak_mb())
"""
READS = """
import sys
from pathlib import Path
from deltactl.recording.tables.flat_files import read_flat
before = peak_mb()
recording = read_flat(Path(sys.argv[1]))
print(peak_mb() - before)
"""
Record = Callable[..., FlatRecording]


def peak_mb(code: str, *files: Path) -> float:
    """What a child that runs `code` prints at its end."""
    root = Path(__file__).parents[2]
    done = subprocess.run(
        [sys.executable, "-c", PEAK_MB + code, *map(str, files)],
        cwd=root, capture_output=True, text=True, check=True,
    )  # fmt: skip
    return float(done.stdout.split()[-1])


def ramp(rows: int, period_s: float = 0.02) -> FlatRecording:
    t_s = 100.0 + period_s * np.arange(rows)
    return FlatRecording(t_s, {"position": np.arange(rows, dtype=float)}, {}, "ramp")


@pytest.mark.study
def test_a_gap_of_three_days_costs_no_memory(record: Record, tmp_path: Path) -> None:
    whole = record(seconds=24.0)
    t_s = whole.t_s.copy()
    t_s[len(t_s) // 2 :] += 3 * 86400.0
    path = tmp_path / "gap.csv"
    write_flat(FlatRecording(t_s, whole.columns, {}, "gap"), path)
    assert peak_mb(CHILD, path, ZHAO) < 400.0  # 165 as measured; such a gap once took 1.8 GB


@pytest.mark.study
def test_a_table_is_read_block_by_block(tmp_path: Path) -> None:
    rows = 300_000
    line = ",".join(["0.123456"] * 9)
    path = tmp_path / "long.csv"
    names = ["t", *(f"range_{a}" for a in "xyz"), *(f"pos_{a}" for a in "xyz"),
             *(f"theta_{n}" for n in (1, 2, 3))]  # fmt: skip
    with path.open("w") as file:
        file.write(",".join(names) + "\n")
        file.writelines(f"{0.02 * row:.2f},{line}\n" for row in range(rows))
    table_mb = rows * len(names) * 8 / 2**20
    assert peak_mb(READS, path) < 3.0 * table_mb + 40.0


@settings(max_examples=25, deadline=None)
@given(st.integers(1, 20_000), st.integers(600, 6000))
def test_an_excerpt_is_stretches_of_it(rows: int, most: int) -> None:
    whole = ramp(rows)
    kept = excerpt(whole, most)
    assert len(kept) <= most
    if rows <= most:
        assert kept is whole
        return
    assert kept.taken_from == rows
    assert len(kept) > 0.9 * most - STRETCHES
    np.testing.assert_array_equal(kept.t_s, whole.t_s[kept.columns["position"].astype(int)])
    # In every tenth of the recording there is something of it.
    tenths = np.unique((kept.columns["position"] * STRETCHES / rows).astype(int))
    assert len(tenths) == STRETCHES


def test_stretches_are_those_in_which_something_moves() -> None:
    t_s = 0.02 * np.arange(20_000)
    moving = (t_s > 31.0) & (t_s < 38.0)
    position = np.where(moving, t_s, 0.0)
    kept = excerpt(FlatRecording(t_s, {"position": position}, {}, "x"), 4000)
    assert np.isin(t_s[moving], kept.t_s).all()


def test_each_stretch_starts_afresh() -> None:
    kept = excerpt(ramp(50_000), 5000)
    assert len(kept.stretches()) == STRETCHES
    assert thinned([ramp(10), kept])[0].model_dump() == {
        "recording": 2, "rows_used": 5000, "rows": 50_000, "stretches": 10,
        "span_s": pytest.approx(kept.t_s[-1] - kept.t_s[0]),
    }  # fmt: skip


def test_the_longest_of_several_are_cut_to_one_length() -> None:
    kept = excerpts([ramp(1000), ramp(9000), ramp(5000)], 9000)
    assert [len(one) for one in kept] == [1000, 4000, 4000]
    assert excerpts(kept, 9000) == kept
    with pytest.raises(RecordingError, match=r"40 recordings .* give fewer"):
        excerpts([ramp(1000)] * 40, 9000)


def test_many_short_runs_that_fit_are_all_taken_whole() -> None:
    runs = [ramp(100)] * 90
    assert excerpts(runs, 9000) == runs


@pytest.mark.study
def test_the_answer_says_what_was_left_out(
    delta: DeltaRobot, record: Record, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(admission, "ADMISSION", replace(ADMISSION, delta_rows=900))
    path = tmp_path / "long.csv"
    write_flat(record(seconds=24.0), path)
    answer = diagnose([path], ZHAO)
    (left,) = answer.to_json()["thinned"]
    assert (left["recording"], left["rows"]) == (1, len(read_flat(path)))
    assert left["rows_used"] <= 900
    assert any("rows were used, in 10 stretches" in line for line in sentences(answer))


def test_a_log_of_hours_shows_how_late_an_axis_is() -> None:
    """Every so many rows would be half a second apart, and show no 40 ms."""
    late_s, rows = 0.04, 300_000
    rng = np.random.default_rng(7)
    t_s = 0.02 * np.arange(rows)
    places = rng.uniform(-1.0, 1.0, rows // 100 + 3)
    starts = np.cumsum(rng.uniform(1.0, 3.0, len(places)))

    def command(at_s: np.ndarray) -> np.ndarray:
        ends = np.stack([starts, starts + 0.8], axis=1)
        return np.interp(at_s, ends.ravel(), np.repeat(places, 2)[np.r_[0, : 2 * len(places) - 1]])

    position = command(t_s - late_s) + 0.001 * rng.standard_normal(rows)
    recording = FlatRecording(t_s, {"command": command(t_s), "position": position}, {}, "hours")
    answer = diagnose_recordings(
        ServoAxis(kind="servo_axis", name="late", motion="rotary"), [recording]
    )
    (found,) = answer.findings
    assert found.effect == "following_lag"
    whole = found.parameters["total"]
    assert whole.ci95[0] < late_s < whole.ci95[1]
    assert answer.fit.rms_after_m < 1.1 * 0.001
    assert answer.thinned[0].rows == rows


@pytest.mark.parametrize(
    ("at", "count", "words"),
    [
        (5, 0.5, r"steps_2 is .*5 at 0\.1\d* s: a count of microsteps is a whole number"),
        (7, 1e7, r"steps_2 is 1e\+07 .* the arm would be at"),
        (7, -1e7, "steps_2 is .* the arm would be at"),
    ],
)
def test_counts_that_no_controller_sends_are_refused(
    delta: DeltaRobot, record: Record, at: int, count: float, words: str
) -> None:
    whole = record(seconds=10.0)
    columns = {name: values.copy() for name, values in whole.columns.items()}
    columns["steps_2"][at] = columns["steps_2"][at] + 0.5 if count == 0.5 else count
    with pytest.raises(RecordingError, match=words):
        diagnose_recordings(delta, [FlatRecording(whole.t_s, columns, {}, "bad")])


@pytest.mark.parametrize("motor", [1, 2, 3])
@pytest.mark.parametrize("count", [0.5, 1e7, -1e7])
def test_every_motor_is_checked(delta: DeltaRobot, motor: int, count: float) -> None:
    """A column nobody looked at would send a wild size into the answer."""
    columns = {f"steps_{each}": np.zeros(4) for each in (1, 2, 3)}
    check_steps(delta, FlatRecording(np.arange(4.0), columns, {}, "sound"))
    columns[f"steps_{motor}"][2] = count
    with pytest.raises(RecordingError, match=f"steps_{motor} is .* at 2 s"):
        check_steps(delta, FlatRecording(np.arange(4.0), columns, {}, "bad"))


def test_limits_of_the_robot_file_count(delta: DeltaRobot, record: Record) -> None:
    narrow = MotionLimits(arm_deg=(-20.0, 30.0))
    with pytest.raises(RecordingError, match=r"steps_\d is .* limits are -20 to 30 deg"):
        diagnose_recordings(delta, [record(seconds=10.0)], motion_limits=narrow)
