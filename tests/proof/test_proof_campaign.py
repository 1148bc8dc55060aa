"""A whole proof: it goes on where it ended, and runs the same function on a scheduler's workers."""

from __future__ import annotations

import json

import pytest

pytest.importorskip("mujoco", reason="the proof's robot needs the extra 'proof' (MuJoCo)")

from typer.testing import CliRunner

from deltactl.cli.main import app
from deltactl.foundation.errors import ConfigError, RecordingError, ServiceError
from deltactl.proof.prove import campaign, one_case
from deltactl.proof.prove.resumable import Means


def small_result(seed: int, number: int) -> dict[str, object]:
    return {
        "seed": seed, "failure": "not diagnosed", "diagnosis": None, "bound": None,
        "simulated_s": 1.0, "diagnosed_s": 2.0,
        "truth": {
            "case": f"case_{number:04d}", "group": "nothing", "motion": "survey", "answers": [],
        },
    }  # fmt: skip


@pytest.fixture
def ran(monkeypatch):
    numbers = []

    def run(seed, number):
        numbers.append(number)
        return small_result(seed, number)

    monkeypatch.setattr(campaign, "run_case", run)
    return numbers


def test_a_proof_goes_on_where_it_ended(tmp_path, ran):
    campaign.prove(2, 3, tmp_path, means=Means(0))
    seen = []
    means = Means(0, progress=lambda done, total, text: seen.append((done, total)))
    outcome = campaign.prove(4, 3, tmp_path, means=means)
    assert ran == [0, 1, 2, 3]
    assert seen == [(2, 4), (3, 4), (4, 4)]
    assert len(outcome.scores) == 4
    assert "| diagnosis failed with an error |" in outcome.table_file.read_text()
    assert outcome.matrix_file.read_text().startswith("<svg")


def test_an_unfinished_case_is_run_again(tmp_path, ran):
    (tmp_path / "case_0000").mkdir()
    (tmp_path / "case_0000" / "result.part").write_text("{")
    campaign.prove(1, 3, tmp_path, means=Means(0))
    assert ran == [0]
    assert json.loads((tmp_path / "case_0000" / "result.json").read_text())["seed"] == 3


def test_another_seed_needs_another_folder(tmp_path, ran):
    campaign.prove(1, 3, tmp_path, means=Means(0))
    with pytest.raises(ConfigError, match="seed 3"):
        campaign.prove(1, 4, tmp_path, means=Means(0))


def test_a_proof_that_is_cut_off_scores_what_comes_before_the_first_missing_case(tmp_path, ran):
    outcome = campaign.prove(4, 3, tmp_path, means=Means(0, minutes=0.0))
    assert ran == [0]
    assert outcome.title == "the first 1 of 4 cases and 0 ties of seed 3"
    (tmp_path / "case_0002").mkdir()
    late = {**small_result(3, 2), "failure": "ran before case 1"}
    (tmp_path / "case_0002" / "result.json").write_text(json.dumps(late))
    assert len(campaign.prove(4, 3, tmp_path, means=Means(0, minutes=0.0)).scores) == 3


def test_ties_take_turns_with_cases(tmp_path, ran, monkeypatch):
    def tie(seed, number):
        ran.append(f"tie {number}")
        return {
            "truth": {"answers": []}, "alternative": [], "settleable": True, "pair": "a or b",
            "proposed": None, "first": None, "second": None,
        }  # fmt: skip

    monkeypatch.setattr(campaign, "run_tie", tie)
    campaign.prove(4, 3, tmp_path, ties=2, means=Means(0))
    assert ran == [0, "tie 0", 1, 2, "tie 1", 3]


def test_the_command_prints_the_table(tmp_path, ran):
    arguments = ["--cases", "1", "--seed", "3", "--workers", "0", "--out", str(tmp_path)]
    printed = CliRunner().invoke(app, ["demo", "prove", *arguments], env={"COLUMNS": "200"})
    assert printed.exit_code == 0, printed.output
    assert "1 cases and 0 ties of seed 3" in " ".join(printed.output.split())
    assert "false alarms, nothing missing" in (tmp_path / "table.md").read_text()
    assert f"table: {tmp_path / 'table.md'}\n" in printed.output
    assert f"confusion matrix: {tmp_path / 'matrix.svg'}\n" in printed.output


def test_a_diagnosis_that_fails_is_a_result(tmp_path, monkeypatch):
    def broken(*_, **__):
        raise RecordingError("too short")

    monkeypatch.setattr("deltactl.diagnosis.api.diagnose", broken)
    assert one_case.diagnose_blind(tmp_path) == (None, "too short")

    def crashing(*_, **__):
        raise ZeroDivisionError("oops")

    monkeypatch.setattr("deltactl.diagnosis.api.diagnose", crashing)
    assert one_case.diagnose_blind(tmp_path) == (None, "ZeroDivisionError: oops")


def test_the_diagnosis_is_shown_three_files_and_nothing_else(tmp_path, monkeypatch):
    shown = {}

    def note(recordings, robot, holdout):
        shown.update(recordings=recordings, robot=robot, holdout=holdout)
        raise RecordingError("seen enough")

    monkeypatch.setattr("deltactl.diagnosis.api.diagnose", note)
    (tmp_path / "holdout.csv.gz").touch()
    one_case.diagnose_blind(tmp_path)
    assert shown == {
        "recordings": [tmp_path / "recording.csv.gz"],
        "robot": tmp_path / "robot.yaml",
        "holdout": [tmp_path / "holdout.csv.gz"],
    }


def test_cases_run_on_a_schedulers_workers(tmp_path, monkeypatch):
    distributed = pytest.importorskip("distributed", reason="needs the extra 'proof' (Dask)")
    monkeypatch.setattr(campaign, "run_case", small_result)
    with distributed.LocalCluster(
        n_workers=1, threads_per_worker=2, processes=False, dashboard_address=":0"
    ) as cluster:
        outcome = campaign.prove(3, 5, tmp_path, means=Means(scheduler=cluster.scheduler_address))
    assert [marks.case for marks in outcome.scores] == ["case_0000", "case_0001", "case_0002"]


def one_is_lost(seed: int, number: int) -> dict[str, object]:
    if number == 1:
        raise MemoryError("worker died")
    return small_result(seed, number)


def test_a_lost_case_does_not_cost_the_others(tmp_path, monkeypatch):
    distributed = pytest.importorskip("distributed", reason="needs the extra 'proof' (Dask)")
    monkeypatch.setattr(campaign, "run_case", one_is_lost)
    with (
        distributed.LocalCluster(
            n_workers=1, threads_per_worker=1, processes=False, dashboard_address=":0"
        ) as cluster,
        pytest.raises(ServiceError, match=r"1 did not finish .* worker died.*same command again"),
    ):
        campaign.prove(3, 5, tmp_path, means=Means(scheduler=cluster.scheduler_address))
    assert (tmp_path / "case_0000" / "result.json").exists()
    assert (tmp_path / "case_0002" / "result.json").exists()


def test_without_dask_it_says_so_and_runs_here(tmp_path, ran, monkeypatch):
    monkeypatch.setitem(__import__("sys").modules, "distributed", None)
    said = []
    campaign.prove(1, 3, tmp_path, means=Means(say=said.append))
    assert ran == [0]
    assert "Dask is not installed" in said[0]
    with pytest.raises(ConfigError, match=r"--scheduler tcp://nobody:1: Dask is not installed"):
        campaign.prove(2, 3, tmp_path, means=Means(scheduler="tcp://nobody:1"))


def test_no_cases_is_refused(tmp_path):
    with pytest.raises(ConfigError, match="at least one"):
        campaign.prove(0, 1, tmp_path)
