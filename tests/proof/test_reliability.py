"""Reliability of stated probabilities, against counts done by hand."""

from __future__ import annotations

import numpy as np
import pytest

pytest.importorskip("mujoco", reason="the proof's cases need the extra 'proof' (MuJoCo)")

from deltactl.proof.prove.reliability import bins, calibration_error, diagram, sure_claims
from deltactl.proof.prove.score import score
from tests.proof.test_proof_score import HOME, finding, result


def test_claims_that_hold_have_no_error():
    claims = [(0.75, True)] * 3 + [(0.75, False)] + [(1.0, True)] * 5 + [(0.0, False)]
    assert calibration_error(claims) == pytest.approx(0.0)
    assert [one.claims for one in bins(claims)] == [1, 4, 5]


def test_claims_that_are_too_sure_have_one():
    claims = [(0.9, True)] * 5 + [(0.9, False)] * 5
    assert calibration_error(claims) == pytest.approx(0.4)
    assert sure_claims([(0.95, True), (0.94, False), (0.99, False)]) == [True, False]


def test_drawn_claims_are_calibrated_within_chance():
    rng = np.random.default_rng(3)
    stated = rng.uniform(0.0, 1.0, 20_000)
    claims = list(
        zip(stated.tolist(), (rng.uniform(0.0, 1.0, 20_000) < stated).tolist(), strict=True)
    )
    assert calibration_error(claims) < 0.01


def test_every_probability_of_an_answer_is_a_claim():
    wrong = finding("sensor_offset", "range_x", alternatives=[("home_offset", "motor2")])
    wrong["probability"], wrong["alternatives"][0]["probability"] = 0.6, 0.4
    answer = result([HOME], [wrong])
    answer["diagnosis"]["probability_nothing_missing"] = 0.01
    assert score(answer).claims == [(0.01, False), (0.6, False), (0.4, True)]


def test_a_group_of_alternatives_is_one_claim():
    late = finding("sensor_latency", "sensors")
    late["probability"] = 0.9
    late["alternatives"] = [
        {"effect": "following_lag", "component": f"motor{n}", "delta_chi2": 0.0, "together": True,
         "probability": 0.1}
        for n in (1, 2, 3)
    ]  # fmt: skip
    assert [p for p, _ in score(result([HOME], [late])).claims] == [0.9, 0.1]


def test_the_diagram_has_a_point_for_each_bin():
    drawing = diagram([(0.1, False), (0.9, True), (0.95, True)], "two bins & a title")
    assert drawing.count("<circle") == 2
    assert "&amp;" in drawing
