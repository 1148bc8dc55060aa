"""Ties: both sides are drawn, a proposed job can be run, and settling is scored as said."""

from __future__ import annotations

import numpy as np
import pytest

pytest.importorskip("mujoco", reason="the proof's cases need the extra 'proof' (MuJoCo)")

from deltactl.foundation.errors import ConfigError, UnreachablePoint
from deltactl.proof.motions import from_job
from deltactl.proof.prove import ties
from deltactl.proof.prove.ties import TIES, draw_tie, run_tie, score_tie, tie_rows
from deltactl.proof.robot.as_built import Joints

RAD = Joints().rad_per_step
TOGETHER = {"mode": "together", "t_pwm_s": 0.002}


def job(**path):
    return {"path": path, "timing": TOGETHER}


def test_every_pair_is_drawn_from_both_sides():
    drawn = [draw_tie(3, number) for number in range(2 * len(TIES))]
    for first, second in zip(drawn[: len(TIES)], drawn[len(TIES) :], strict=True):
        assert first[1].name == second[1].name
        names = {(a.effect, a.where) for a in first[0].answers}
        rivals = {(a.effect, a.where) for a in second[0].answers}
        assert {effect for effect, _ in first[2]} == {effect for effect, _ in rivals}
        assert {effect for effect, _ in second[2]} == {effect for effect, _ in names}


def test_jobs_of_every_shape():
    centre = [0.0, 0.0, -0.45]
    circle = from_job(job(shape="circle", centre_m=centre, radius_m=0.1, turns=2))
    back = from_job(job(shape="circle", centre_m=centre, radius_m=0.1, turns=-2))
    assert circle.seconds == pytest.approx(back.seconds, rel=0.02)
    middle = len(circle.counts) // 16
    assert not np.array_equal(circle.counts[middle], back.counts[middle])
    joints = from_job(job(shape="joints", angles_deg=[[30, 30, 30], [40, 30, 20]], dwell_s=1.0))
    assert joints.counts[0] * RAD == pytest.approx(np.radians([30, 30, 30]), abs=RAD)
    assert joints.counts[-1] * RAD == pytest.approx(np.radians([40, 30, 20]), abs=RAD)
    assert joints.seconds == pytest.approx(2.0 + 0.002 * (1 + np.radians(10) / RAD), abs=0.01)
    points = from_job(job(shape="points", points_m=[[0, 0, -0.4], [0.05, 0, -0.5]], dwell_s=0.5))
    assert np.abs(np.diff(points.counts, axis=0)).max() == 1
    survey = from_job(job(shape="survey", count=5, angle_deg=[-20, 110], dwell_s=0.2, seed=4))
    assert survey.counts.min() >= 0


def test_jobs_that_cannot_be_run():
    with pytest.raises(ConfigError, match="'zigzag'"):
        from_job(job(shape="zigzag"))
    with pytest.raises(UnreachablePoint):
        from_job(job(shape="points", points_m=[[0, 0, -0.4], [2.0, 0, -0.5]]))


def answer(*findings, proposal=None):
    return {
        "findings": [
            {"effect": e, "component": c, "alternatives": [{"effect": a, "component": b}
                                                           for a, b in others]}
            for e, c, others in findings
        ],
        "next_experiment": proposal,
    }  # fmt: skip


LAG, AZIMUTH = ("following_lag", "motor1"), ("motor_azimuth", "motor1")


def tie_result(first, second=None, proposed=None, settleable=True):
    return {
        "truth": {"answers": [{"effect": LAG[0], "where": LAG[1]}]}, "alternative": [list(AZIMUTH)],
        "pair": "lag or azimuth", "settleable": settleable, "first": first, "second": second,
        "proposed": proposed,
    }  # fmt: skip


def test_a_tie_is_settled_by_the_second_answer():
    tied, clear = answer((*AZIMUTH, [LAG])), answer((*LAG, []))
    marks = score_tie(tie_result(tied, clear, proposed={}))
    assert marks.admitted
    assert marks.settled
    still_open = answer((*LAG, [AZIMUTH]))
    assert not score_tie(tie_result(tied, still_open, proposed={})).settled
    assert not score_tie(tie_result(tied, None, proposed={})).settled
    assert not score_tie(tie_result(tied)).settled


def test_naming_the_wrong_one_is_never_settled():
    wrong = answer((*AZIMUTH, []))
    marks = score_tie(tie_result(wrong))
    assert not marks.admitted
    assert not marks.settled


def test_what_no_motion_settles_must_be_left_open():
    tied, sure = answer((*AZIMUTH, [LAG])), answer((*LAG, []))
    assert score_tie(tie_result(tied, settleable=False)).settled
    assert not score_tie(tie_result(sure, settleable=False)).settled
    assert not score_tie(tie_result(tied, settleable=False)).told
    said = {**tied, "open_ties": [{"one": ["following_lag motor1"], "other": ["sensor_latency"]}]}
    assert score_tie(tie_result(said, settleable=False)).told


def test_rows_count_by_pair():
    tied, clear = answer((*AZIMUTH, [LAG])), answer((*LAG, []))
    scores = [score_tie(tie_result(tied, clear, proposed={})), score_tie(tie_result(tied))]
    rows = {row.figure: row for row in tie_rows(scores)}
    assert rows["ties: settled after the proposed run"].value == "50.0 %"
    assert rows["... where a run was proposed"].value == "100.0 %"
    assert rows["... where the first answer alone was to decide"].value == "0.0 %"
    assert rows["... lag or azimuth"].cases == 2


def test_the_proposed_job_is_run_on_the_same_robot_and_shown_with_the_first(monkeypatch):
    shown = []
    proposal = {"job": job(shape="joints", angles_deg=[[30, 30, 30], [40, 40, 40]], dwell_s=0.5)}

    def diagnose(folder, also=()):
        shown.append(sorted(path.name for path in folder.iterdir() if path.suffix == ".gz"))
        assert also == ("second.csv.gz",) or len(shown) == 1
        return answer((*LAG, []), proposal=proposal), None

    monkeypatch.setattr(ties, "diagnose_blind", diagnose)
    monkeypatch.setattr(ties, "SECONDS", 2.0)
    result = run_tie(3, 2)
    files = ["holdout.csv.gz", "recording.csv.gz"]
    assert shown == [files, [*files, "second.csv.gz"]]
    assert result["second"] is not None
    assert result["failure"] is None
