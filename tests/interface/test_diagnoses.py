"""A diagnosis in a notebook: one screen of text, a table, a drawing, a corrected robot."""

from __future__ import annotations

import json
import xml.etree.ElementTree as ET
from pathlib import Path

import numpy as np
import pytest

import deltactl as dc
from deltactl.foundation.errors import ConfigError

pd = pytest.importorskip("pandas", reason="the diagnosis needs the extra 'diagnosis'")

SLIDE = "kind: servo_axis\nname: slide\nmotion: linear\n"
COLUMNS = {"t": "time_s[s]", "command": "target[mm]", "position": "seen[mm]"}


HEARD: list[str] = []
"""What that diagnosis says on its way."""
JOB = {
    "name": "round",
    "robot": "zhao-2023.yaml",
    "path": {"shape": "circle", "centre_m": [0.0, 0.0, -0.45], "radius_m": 0.02},
    "timing": {"mode": "accelerated", "speed_mps": 0.3},
    "inverse_kinematics": {"kind": "geometry"},
}
"""A job of half a second."""


def slide_log(seed: int) -> pd.DataFrame:
    """A slide whose reading is 2 % larger than its command, in columns with names of their own."""
    t_s = np.arange(0.0, 10.0, 0.02)
    asked_mm = 40.0 * np.sin(0.8 * t_s) + 15.0 * np.sin(2.1 * t_s + seed)
    noise_mm = np.random.default_rng(seed).normal(0.0, 0.01, len(t_s))
    return pd.DataFrame({"time_s": t_s, "target": asked_mm, "seen": 1.02 * asked_mm + noise_mm})


@pytest.fixture(scope="module")
def diagnosis() -> dc.Diagnosis:
    """Of two recordings that have the same name, with a third held out."""
    first, second, third = (
        dc.Recording.from_pandas(slide_log(seed), COLUMNS) for seed in (3, 4, 5)
    )
    slide = dc.Robot.from_text(SLIDE)
    return dc.diagnose([first, second], slide, holdout=third, progress=HEARD.append)


@pytest.mark.study
def test_findings_are_a_table(diagnosis: dc.Diagnosis) -> None:
    (row,) = diagnosis.findings.to_dict("records")
    assert (row["name"], row["component"]) == ("gear_ratio", "axis")
    assert row["interval_low"] < 1.02 < row["interval_high"]
    assert row["size"] == pytest.approx(1.02, abs=0.002)
    assert row["probability"] > 0.5
    assert diagnosis.sizes["size"][0] == row["size"]
    assert (diagnosis.verdict, diagnosis.answer.fit.holdout) == ("explained", "run")
    assert "gear_ratio axis" in repr(diagnosis)


def test_a_diagnosis_says_what_it_is_at(diagnosis: dc.Diagnosis) -> None:
    assert HEARD[0] == "reading"
    assert len(set(HEARD)) > 3


def test_print_is_one_screen(diagnosis: dc.Diagnosis) -> None:
    lines = str(diagnosis).split("\n")
    assert len(lines) <= 25
    assert max(map(len, lines)) <= 80
    assert "wrong ratio between command and motion" in " ".join(str(diagnosis).split())
    assert "deltactl " not in str(diagnosis)  # what is typed in a terminal
    assert len(diagnosis.summary()) > len(str(diagnosis))
    assert "wrong ratio between command and motion" in diagnosis._repr_html_()


def test_files_and_json_are_those_of_the_command(diagnosis: dc.Diagnosis, tmp_path: Path) -> None:
    assert json.loads(json.dumps(diagnosis.to_json()))["verdict"] == "explained"
    assert len(set(diagnosis.to_json()["recordings"])) == 2
    diagnosis.save_report(tmp_path / "why.html")
    assert "1.02" in (tmp_path / "why.html").read_text(encoding="utf-8")


def test_the_plot_draws_the_mismatch_before_and_after(
    diagnosis: dc.Diagnosis, tmp_path: Path
) -> None:
    diagnosis.plot().save(tmp_path / "plot.svg")
    root = ET.parse(tmp_path / "plot.svg").getroot()
    spread = []
    for path in root.iter("{http://www.w3.org/2000/svg}path"):
        if path.get("fill") == "none":
            pairs = (path.get("d") or "").replace("L", "M").split("M")[1:]
            spread.append(float(np.std([float(pair.split()[1]) for pair in pairs])))
    _, before, after = spread
    assert after < 0.2 * before


@pytest.mark.study
def test_the_corrected_robot_has_nothing_missing(diagnosis: dc.Diagnosis, tmp_path: Path) -> None:
    corrected = diagnosis.corrected_robot()
    assert [entry.effect for entry in corrected.model.effects] == ["gear_ratio"]
    again = dc.diagnose(dc.Recording.from_pandas(slide_log(6), COLUMNS), corrected)
    assert (again.verdict, len(again.findings)) == ("nothing_missing", 0)
    assert list(again.findings.columns) == list(diagnosis.findings.columns)
    corrected.save(tmp_path / "better.yaml")
    with pytest.warns(DeprecationWarning, match=r"corrected_robot\(\)\.save\(path\)"):
        diagnosis.save_robot(tmp_path / "older.yaml")
    assert (tmp_path / "older.yaml").read_text() == (tmp_path / "better.yaml").read_text()
    slide_log(7).to_csv(tmp_path / "log.csv", index=False)
    from_files = dc.diagnose(tmp_path / "log.csv", tmp_path / "better.yaml", columns=COLUMNS)
    assert from_files.verdict == "nothing_missing"
    assert from_files.corrected_robot().model == corrected.model


def test_findings_of_which_none_is_certain_correct_nothing_and_that_is_said(
    diagnosis: dc.Diagnosis,
) -> None:
    unsure = [one.model_copy(update={"probability": 0.3}) for one in diagnosis.answer.findings]
    answer = diagnosis.answer.model_copy(update={"findings": unsure})
    doubtful = dc.Diagnosis(answer, diagnosis.robot)
    with pytest.warns(UserWarning, match="all_of_them=True"):
        same = doubtful.corrected_robot()
    assert same.model == diagnosis.robot.model


def test_a_robot_in_braces_is_corrected_too(diagnosis: dc.Diagnosis) -> None:
    robot = dc.Robot.from_text("{kind: servo_axis, name: slide, motion: linear, effects: []}")
    corrected = dc.Diagnosis(diagnosis.answer, robot).corrected_robot()
    assert corrected.model == diagnosis.corrected_robot().model


@pytest.mark.study
def test_a_simulated_robot_has_the_faults_it_is_given(tmp_path: Path) -> None:
    fault = {"effect": "home_offset", "component": "motor3", "parameters": {"angle": 0.015}}
    recording = dc.simulate(JOB, faults=[fault], seed=1)
    assert recording.ended is not None
    assert recording.ended.outcome == "done"
    with pytest.warns(DeprecationWarning, match=r"ended\.outcome"):
        assert recording.outcome == "done"
    with pytest.raises(AttributeError, match="outcom"):
        recording.outcom  # noqa: B018
    same = dc.simulate(JOB, seed=1, record=tmp_path / "plain.mcap")
    assert Path(same.source) == tmp_path / "plain.mcap"
    np.testing.assert_array_equal(recording["steps_3"], same["steps_3"])
    apart = [
        np.nanmedian(np.abs(recording[f"range_{axis}"] - same[f"range_{axis}"])) for axis in "xyz"
    ]
    assert max(apart) > 1e-3


def test_a_job_in_memory_runs_on_a_robot_that_has_no_file() -> None:
    robot = dc.Robot.from_text(dc.Robot.load("zhao-2023.yaml").text, "mine.yaml")
    recording = dc.simulate(JOB, robot)
    assert (recording.source, len(recording) > 10) == ("round", True)
    assert not Path("mine.yaml").exists()


@pytest.mark.parametrize(
    ("fault", "says"),
    [
        ({"effect": "home_ofset", "component": "motor3"}, "home_ofset"),
        ({"efect": "home_offset"}, "did you mean 'effect'"),
        ("home_offset", "is no entry such as"),
    ],
)
def test_a_wrong_fault_is_refused(fault: object, says: str) -> None:
    with pytest.raises(ConfigError, match=says):
        dc.simulate(JOB, faults=[fault])  # type: ignore[list-item]
