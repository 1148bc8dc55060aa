"""The scorer of single axes against answers written by hand, and the command around it."""

from __future__ import annotations

import json

import pytest

pytest.importorskip("mujoco", reason="the command's proof needs the extra 'proof' (MuJoCo)")

from typer.testing import CliRunner

from deltactl.cli.main import app
from deltactl.foundation.errors import ConfigError, MissingFile
from deltactl.proof.prove import axis_campaign
from deltactl.proof.prove.axis_campaign import confusion, prove_axes, seeds_of
from deltactl.proof.prove.axis_score import axis_rows, right, score_axis
from deltactl.proof.prove.reliability import calibration_error
from deltactl.proof.prove.resumable import Means

PLAY = {
    "effect": "gear_backlash", "where": "axis", "values": {"width": 0.01}, "rms": 0.005,
    "chi2": 4000.0, "names": ["gear_backlash", "joint_friction"], "ties": ["home_offset"],
}  # fmt: skip
LATE = {
    "effect": "following_lag", "where": "axis", "values": {"total": 0.03}, "rms": 0.004,
    "chi2": 900.0, "names": ["following_lag"], "ties": [],
}  # fmt: skip
PULLED = {
    "effect": "unknown", "where": "axis", "values": {}, "rms": 0.004, "chi2": 900.0,
    "names": ["unknown"], "ties": [], "physics": "coupling", "depends_on": ["time"],
}  # fmt: skip


def finding(effect, probability=0.9, alternatives=(), parameters=None, depends_on=()):
    return {
        "effect": effect, "component": "motor1", "probability": probability,
        "alternatives": [
            {"effect": name, "component": "axis", "probability": p} for name, p in alternatives
        ],
        "parameters": {
            name: {"value": value, "ci95": limits, "unit": "m"}
            for name, (value, limits) in (parameters or {}).items()
        },
        "depends_on": list(depends_on),
    }  # fmt: skip


def result(answers, findings, tier="single", verdict="explained", also=(), seed=4, **more):
    answer = {
        "verdict": verdict, "probability_nothing_missing": more.pop("nothing", 0.0),
        "findings": findings, "fit": {"rms_after_m": more.pop("left", 0.001)},
        "not_testable": [], "smallest_detectable": more.pop("limits", []),
    }  # fmt: skip
    return {
        "seed": seed, "diagnosis": answer, "failure": None, "bound": more.pop("bound", None),
        "simulated_s": 0.5, "diagnosed_s": 2.0,
        "truth": {
            "case": f"axis_{seed:06d}", "tier": tier, "machine": "commanded", "answers": answers,
            "also": list(also), "noise_rms": 0.001, "noise_rms_high": 0.0012,
            "about": {"style": "random"},
        },
    }  # fmt: skip


def test_the_same_operator_counts_as_right_and_a_needless_name_does_not() -> None:
    marks = score_axis(result([PLAY], [finding("joint_friction")]))
    assert (marks.named, marks.within, marks.exact, right(marks)) == (True,) * 4
    more = score_axis(result([PLAY], [finding("joint_friction"), finding("resonance")]))
    assert (more.named, more.exact, more.needless) == (True, False, ["resonance"])
    allowed = result([PLAY], [finding("joint_friction"), finding("resonance")], also=["resonance"])
    assert score_axis(allowed).exact
    tied = score_axis(result([PLAY], [finding("home_offset")]))
    assert (tied.named, tied.within, tied.exact) == (False, True, True)
    offered = score_axis(result([LATE], [finding("resonance", 0.6, [("following_lag", 0.3)])]))
    assert (offered.within, offered.exact) == (True, False)


def test_a_culprit_has_to_come_first_and_imperfections_may_follow() -> None:
    beside = {"tier": "workshop", "also": ["gear_ratio"]}
    first = score_axis(result([PLAY], [finding("home_offset"), finding("gear_ratio")], **beside))
    later = score_axis(result([PLAY], [finding("gear_ratio"), finding("home_offset")], **beside))
    assert right(first)
    assert not right(later)


def test_two_hidden_effects_are_both_asked_for() -> None:
    one = score_axis(result([PLAY, LATE], [finding("gear_backlash")], tier="pair"))
    both = score_axis(
        result([PLAY, LATE], [finding("following_lag"), finding("gear_backlash")], tier="pair")
    )
    assert not one.named
    assert not right(one)
    assert both.exact
    assert right(both)


def test_a_healthy_axis_may_have_no_finding_and_no_other_verdict() -> None:
    assert right(score_axis(result([], [], tier="null", verdict="nothing_missing")))
    assert score_axis(result([], [], tier="null", verdict="unexplained")).alarmed
    assert score_axis(result([], [finding("gear_ratio")], tier="none")).alarmed


def test_a_tie_is_reported_by_its_other_side_or_by_a_low_probability() -> None:
    def reported(*findings, verdict="explained"):
        return score_axis(result([PLAY], list(findings), "ambiguous", verdict)).tie_reported

    assert not reported(finding("home_offset", 0.99))
    assert reported(finding("home_offset", 0.99, [("gear_backlash", 0.01)]))
    assert reported(finding("home_offset", 0.55))
    assert not reported(verdict="nothing_missing")
    assert reported(verdict="unexplained")


def test_being_sure_of_what_cannot_be_known_is_a_contradiction() -> None:
    sure = score_axis(result([PLAY], [finding("home_offset", 0.99)], "ambiguous"))
    assert sure.contradictions == ["sure of home_offset"]
    open_ = result([PLAY], [finding("home_offset", 0.99)], "ambiguous")
    open_["diagnosis"]["not_testable"] = [{"effect": "gear_backlash"}]
    assert score_axis(open_).contradictions == []


def test_nothing_missing_beside_five_times_the_noise_is_a_contradiction() -> None:
    answer = result([PLAY], [], verdict="nothing_missing")
    assert score_axis(answer).contradictions == ["nothing missing beside gear_backlash"]
    limits = [{"effect": "gear_backlash", "parameter": "width", "value": 0.02}]
    assert (
        score_axis(result([PLAY], [], verdict="nothing_missing", limits=limits)).contradictions
        == []
    )
    limits[0]["value"] = 0.004
    assert score_axis(result([PLAY], [], verdict="nothing_missing", limits=limits)).contradictions
    much = score_axis(result([PLAY], [finding("gear_backlash")], left=0.003))
    assert much.contradictions == ["explained with 2.5 times the noise left"]


def test_an_unknown_is_flagged_by_name_or_by_a_verdict_that_leaves_it_open() -> None:
    named = score_axis(result([PULLED], [finding("unknown", depends_on=["time"])], "unknown"))
    assert named.flagged
    assert named.right_driver
    assert right(named)
    half = score_axis(result([PULLED], [finding("gear_ratio")], "unknown", "partly_explained"))
    assert half.flagged
    assert not half.misnamed
    wrong = score_axis(result([PULLED], [finding("gear_ratio")], "unknown"))
    assert wrong.misnamed
    assert not right(wrong)
    assert wrong.truth == ["unknown: coupling"]


def test_sizes_are_held_to_their_intervals_and_the_total_of_a_delay_is_a_sum() -> None:
    parts = {"time": (0.01, [0.005, 0.015]), "dead_time": (0.018, [0.012, 0.02])}
    assert score_axis(result([LATE], [finding("following_lag", parameters=parts)])).covered == [
        True
    ]
    parts["time"] = (0.001, [0.0, 0.002])
    assert score_axis(result([LATE], [finding("following_lag", parameters=parts)])).covered == [
        False
    ]
    size = {"width": (0.0104, [0.0101, 0.0107])}
    bound = {"gear_backlash": {"width": 0.0002}}
    marks = score_axis(result([PLAY], [finding("gear_backlash", parameters=size)], bound=bound))
    assert marks.covered == [False]
    assert marks.over_bound == [pytest.approx(2.0)]


def test_a_finding_and_its_alternative_that_are_both_right_are_one_claim() -> None:
    found = finding("gear_backlash", 0.6, [("joint_friction", 0.35), ("resonance", 0.05)])
    claims = score_axis(result([PLAY], [found])).claims
    assert claims[0] == (0.0, False)
    assert claims[1:] == [(pytest.approx(0.95), True), (0.05, False)]
    assert calibration_error(claims) == pytest.approx(0.1 / 3.0)
    wrong = score_axis(result([LATE], [found])).claims[1:]
    assert sorted(wrong) == [(0.05, False), (0.35, False), (0.6, False)]


def test_figures_are_shares_of_their_tier() -> None:
    scores = [
        score_axis(result([PLAY], [finding("gear_backlash")])),
        score_axis(result([PLAY], [finding("resonance")])),
        score_axis(result([], [], tier="none", verdict="nothing_missing")),
        score_axis(result([PULLED], [finding("gear_ratio")], "unknown")),
    ]
    rows = {row.figure: row for row in axis_rows(scores)}
    assert rows["single: exactly that"].value == "50.0 %"
    assert rows["single: exactly that"].met is False
    assert rows["false alarms, nothing missing"].met is True
    assert rows["unknown physics: flagged and not misnamed"].value == "0.0 %"
    assert rows["right, commanded"].value == "50.0 %"
    cells = confusion(scores)
    assert cells["gear_backlash", "gear_backlash"] == 1
    assert cells["unknown: coupling", "gear_ratio"] == 1


def test_halves_of_a_range_are_its_even_and_its_odd_seeds() -> None:
    assert seeds_of(10, 4, "all") == [10, 11, 12, 13]
    assert seeds_of(10, 3, "odd") == [11, 13, 15]
    assert seeds_of(11, 3, "even") == [12, 14, 16]


@pytest.fixture
def ran(monkeypatch):
    """Instead of minutes of diagnosis: an answer that finds everything."""
    numbers = []

    def run(seed, number):
        numbers.append(number)
        return result([PLAY], [finding("gear_backlash")], seed=number)

    monkeypatch.setattr(axis_campaign, "run_axis", run)
    return numbers


def test_even_and_odd_seeds_stand_side_by_side_with_a_practice_folder(tmp_path, ran, monkeypatch):
    answers = [result([], [], tier="null")["truth"]]
    (tmp_path / "practice").mkdir()
    (tmp_path / "practice" / "answers.json").write_text(json.dumps(answers))
    monkeypatch.setattr(
        axis_campaign, "diagnose_blind", lambda folder: (None, f"none in {folder.name}")
    )
    proof = prove_axes(3, 6, "all", tmp_path / "out", tmp_path / "practice", Means(0))
    assert ran == [6, 7, 8]
    assert list(proof.columns) == ["even seeds", "odd seeds", "practice axes"]
    text = proof.table_file.read_text()
    assert "3 single axes, seeds 6 to 8" in text
    assert "| figure | goal | even seeds | odd seeds | practice axes |" in text
    assert [(s.failure, s.tier) for s in proof.practice] == [("none in axis_000004", "none")]
    prove_axes(4, 6, "all", tmp_path / "out", tmp_path / "practice", Means(0))
    assert ran == [6, 7, 8, 9]
    with pytest.raises(ConfigError, match="seed 6"):
        prove_axes(3, 7, "all", tmp_path / "out", None, Means(0))
    with pytest.raises(MissingFile, match=r"answers\.json"):
        prove_axes(3, 6, "all", tmp_path / "out", tmp_path / "out", Means(0))


def test_the_command_prints_the_table(tmp_path, ran) -> None:
    asked = ["demo", "prove", "--machine", "axis", "--half", "odd", "--cases", "2", "--seed", "8",
             "--workers", "0", "--out", str(tmp_path)]  # fmt: skip
    printed = CliRunner().invoke(app, asked, env={"COLUMNS": "120"})
    assert printed.exit_code == 0, printed.output
    assert ran == [9, 11]
    assert "2 single axes, odd seeds 9 to 11" in " ".join(printed.output.split())
    assert (tmp_path / "reliability.svg").read_text().startswith("<svg")


@pytest.mark.parametrize(
    "asked",
    [
        ["--half", "odd"], ["--practice", "x"], ["--machine", "axis", "--more", "3"],
        ["--machine", "axis", "--repair"], ["--machine", "axis", "--cases", "0"],
        ["--machine", "axis", "--practice", "nowhere"],
    ],
)  # fmt: skip
def test_what_does_not_go_together_is_refused(tmp_path, ran, asked) -> None:
    printed = CliRunner().invoke(app, ["demo", "prove", "--out", str(tmp_path / "out"), *asked])
    assert isinstance(printed.exception, ConfigError | MissingFile)
    assert ran == []


def test_a_drawn_case_is_diagnosed_blind_and_scored(monkeypatch) -> None:
    seen = {}

    def diagnose_blind(folder):
        seen["files"] = sorted(path.name for path in folder.iterdir())
        return None, "looked at"

    monkeypatch.setattr(axis_campaign, "diagnose_blind", diagnose_blind)
    kept = json.loads(json.dumps(axis_campaign.run_axis(0, 40)))
    assert seen["files"] == ["holdout.csv.gz", "recording.csv.gz", "robot.yaml"]
    assert score_axis(kept).failure == "looked at"
