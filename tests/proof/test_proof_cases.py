"""Cases: the same seed gives the same case, all groups and kinds come, and nothing leaks."""

from __future__ import annotations

import json
import sys

import numpy as np
import pytest

pytest.importorskip("mujoco", reason="the proof's robot needs the extra 'proof' (MuJoCo)")

from deltactl.foundation.errors import ConfigError
from deltactl.proof import generate
from deltactl.proof.cases import ROUND, assemble, draw, write_blind
from deltactl.proof.hidden.oddities import ODDITIES
from deltactl.proof.hidden.vocabulary import SINGLES
from deltactl.proof.ranging import ideal_ranges
from deltactl.proof.recorded import Machine
from deltactl.proof.robot.run import run
from deltactl.recording.tables.flat_files import read_flat
from tests.rigs.clean_ranges import clean_ranges


def test_the_same_seed_draws_the_same_case():
    one, other = draw(11, 4), draw(11, 4)
    assert one.truth() == other.truth()
    assert np.array_equal(one.train.counts, other.train.counts)
    assert draw(12, 4).truth() != one.truth()


def test_two_rounds_hold_every_group_and_each_its_number_of_effects():
    count = {"nothing": 0, "two": 2, "three": 3}
    for number in range(len(ROUND)):
        case = draw(5, number)
        assert case.group == ROUND[number]
        answers = case.truth()["answers"]
        assert len(answers) == count.get(case.group, 1)
        assert (case.group == "unknown") == any(a["effect"] == "unknown" for a in answers)
        assert len({a["effect"] for a in answers}) == len(answers)


@pytest.mark.study
def test_kinds_take_turns():
    singles = [number for number in range(120) if ROUND[number % len(ROUND)] == "single"]
    drawn = [draw(5, number).answers[0].effect for number in singles]
    assert len(set(drawn[: len(SINGLES)])) == min(len(SINGLES), len(drawn))


def test_a_third_is_a_third():
    def size(strength):
        rng = np.random.default_rng(3)
        return assemble(0, "x", ["sensor_offset"], rng, "survey", 3.0, strength).answers[0]

    whole, third = size(1.0), size(1.0 / 3.0)
    assert third.parameters["offset"] == pytest.approx(whole.parameters["offset"] / 3.0)


@pytest.mark.parametrize("effect", ["lost_steps", "stale_reading"])
def test_events_happen_once_and_not_in_the_holdout(effect):
    case = assemble(0, "single", [effect], np.random.default_rng(2), "survey", 8.0)
    answer = case.truth()["answers"][0]
    assert 2.0 < answer["when"] < 6.0
    lost, kept = (m.robot.joints.lost_steps.any() for m in (case.machine, case.holdout_machine))
    held, free = (bool(m.sensors.held) for m in (case.machine, case.holdout_machine))
    assert lost or held
    assert not kept
    assert not free


@pytest.mark.parametrize("name", sorted(ODDITIES))
def test_every_oddity_shows_and_says_where_and_what_it_follows(name):
    case = assemble(0, "unknown", [name], np.random.default_rng(6), "survey", 6.0)
    off = clean_ranges(case.machine, case.train) - clean_ranges(Machine(), case.train)
    # Build noise is below 0.1 mm; an oddity that stays below it would test nothing.
    assert np.abs(off).max() > 4e-4
    answer = case.truth()["answers"][0]
    assert answer["effect"] == "unknown"
    assert answer["depends_on"]
    assert answer["where"][:5] in ("motor", "range", "platf")


def test_one_culprit_stands_out_of_the_tolerances():
    rng = np.random.default_rng(9)
    case = assemble(0, "tolerance", ["home_offset"], rng, "survey", 4.0)
    plain = assemble(0, "tolerance", [], np.random.default_rng(9), "survey", 4.0)
    robots = (case.machine.robot, plain.machine.robot, Machine().robot)
    truths = [run(robot, case.train) for robot in robots]
    t_s = truths[0].t_s[20:-20]
    culprit, small, none = (
        ideal_ranges(sensors, truth, t_s)
        for sensors, truth in zip(
            (case.machine.sensors, plain.machine.sensors, Machine().sensors), truths, strict=True
        )
    )
    assert np.abs(small - none).max() > 3e-4
    assert np.std(culprit - none) > 1.5 * np.std(small - none)


def test_what_the_diagnosis_sees_holds_no_answer(tmp_path):
    case = assemble(0, "single", ["home_offset"], np.random.default_rng(1), "survey", 4.0)
    write_blind(case, tmp_path / "blind", 1)
    names = sorted(path.name for path in (tmp_path / "blind").iterdir())
    assert names == ["holdout.csv.gz", "recording.csv.gz", "robot.yaml"]
    recording = read_flat(tmp_path / "blind" / "recording.csv.gz")
    assert not recording.extra
    assert set(recording.columns) == {
        *(f"steps_{m}" for m in (1, 2, 3)), *(f"range_{a}" for a in "xyz"),
        *(f"status_{a}" for a in "xyz"), "t_pwm",
    }  # fmt: skip
    assert recording.period_s() == pytest.approx(0.02, abs=1e-6)


def test_generate_writes_a_case(tmp_path, monkeypatch, capsys):
    arguments = ["--kind", "home_offset,stripes", "--seed", "3", "--seconds", "3"]
    monkeypatch.setattr(sys, "argv", ["generate", *arguments, "--out", str(tmp_path)])
    generate.main()
    answers = json.loads((tmp_path / "answers.json").read_text())["answers"]
    assert [answer["effect"] for answer in answers] == ["home_offset", "unknown"]
    assert "home_offset, unknown" in capsys.readouterr().out


def test_generate_names_what_it_knows():
    with pytest.raises(ConfigError, match="'rust' is not one of nothing, gear_backlash"):
        generate._kinds("rust")
