"""The scorer against answers written by hand, and the table against counts done by hand."""

from __future__ import annotations

import math

import pytest

pytest.importorskip("mujoco", reason="the proof's cases need the extra 'proof' (MuJoCo)")

from deltactl.proof.prove.reliability import median_limits, wilson
from deltactl.proof.prove.score import Score, confusion, picture, rows_and_columns, score
from deltactl.proof.prove.table import markdown, table

HOME = {
    "effect": "home_offset", "where": "motor2", "value": 0.01, "unit": "rad",
    "parameters": {"angle": 0.01},
}  # fmt: skip
LOST = {
    "effect": "lost_steps", "where": "motor1", "value": 80, "unit": "microsteps", "when": 50.0,
    "parameters": {"steps": 80, "time": 50.0},
}  # fmt: skip
STRIPES = {
    "effect": "unknown", "where": "range_x", "value": 0.004, "unit": "m", "parameters": {},
    "kind": "stripes", "also_where": [], "depends_on": ["range_x"], "memory": False,
}  # fmt: skip


def finding(effect, component, parameters=None, alternatives=(), depends_on=()):
    return {
        "effect": effect, "component": component, "says": "", "share_of_mismatch": 1.0,
        "parameters": {
            name: {"value": value, "ci95": limits, "unit": "1"}
            for name, (value, limits) in (parameters or {}).items()
        },
        "where": {"axes": [], "times_s": [[50.05, 60.0]], "regime": ""},
        "evidence": {"delta_chi2": 50.0, "p": 1e-9},
        "alternatives": [
            {"effect": e, "component": c, "delta_chi2": 1.0} for e, c in alternatives
        ],
        "depends_on": list(depends_on),
    }  # fmt: skip


def result(truths, findings, group="single", verdict="explained", bound=None, motion="survey"):
    return {
        "truth": {
            "case": "case_0000", "group": group, "motion": motion, "answers": truths,
            "sigma": 0.002, "rho": 0.0,
        },
        "failure": None, "bound": bound,
        "diagnosis": {
            "verdict": verdict, "false_alarm_p": 0.2, "findings": findings,
            "fit": {
                "rms_before_m": 0.003, "rms_after_m": 0.002, "noise_floor_m": 0.002,
                "holdout_rms_before_m": 0.003, "holdout_rms_after_m": 0.002,
            },
            "unexplained": {"share_of_mismatch": 0.0, "depends_on": [], "says": ""},
        },
    }  # fmt: skip


def test_the_right_name_at_the_right_place():
    right = finding("home_offset", "motor2", {"angle": (0.0104, [0.0099, 0.0109])})
    marks = score(result([HOME], [right], bound={"angle": [0.0002]}))
    assert marks.first_right
    assert marks.exact
    assert marks.covered == [True]
    assert marks.over_bound == pytest.approx([2.0])
    assert marks.holdout_over_floor == pytest.approx(0.002 / math.hypot(0.002, 1e-3 / 12**0.5))


def test_the_right_name_at_the_wrong_place_is_wrong():
    marks = score(result([HOME], [finding("home_offset", "motor1")]))
    assert not marks.first_right
    assert not marks.offered
    assert confusion([marks]) == {("home_offset", "right effect, wrong place"): 1}


def test_an_alternative_is_offered_but_not_named():
    other = finding("forearm_length", "arm2", alternatives=[("home_offset", "motor2")])
    marks = score(result([HOME], [other]))
    assert marks.offered
    assert not marks.first_right


def test_the_truth_second_is_offered_and_not_exact():
    marks = score(
        result([HOME], [finding("gear_ratio", "motor1"), finding("home_offset", "motor2")])
    )
    assert marks.offered
    assert not marks.first_right
    assert not marks.exact


def test_two_effects_need_both_in_any_order_and_no_third():
    both = [finding("lost_steps", "motor1"), finding("home_offset", "motor2")]
    assert score(result([HOME, LOST], both, group="two")).exact
    third = [*both, finding("gear_ratio", "motor3")]
    assert not score(result([HOME, LOST], third, group="two")).exact
    assert score(result([HOME, LOST], third, group="two")).offered
    assert not score(result([HOME, LOST], both[:1], group="two")).offered


def test_silence_and_false_alarms():
    quiet = score(result([], [], group="nothing", verdict="nothing_missing"))
    assert not quiet.alarmed
    loud = score(result([], [finding("gear_ratio", "motor1")], group="nothing"))
    assert loud.alarmed
    # A verdict that something is missing is an alarm even when it names nothing.
    assert score(result([], [], group="nothing", verdict="unexplained")).alarmed


def test_event_times_come_from_the_parameter_or_from_where():
    exact = finding("lost_steps", "motor1", {"time": (50.02, [50.0, 50.04])})
    assert score(result([LOST], [exact])).event_error_s == pytest.approx([0.02])
    rough = finding("lost_steps", "motor1", {"steps": (80.0, [70.0, 90.0])})
    marks = score(result([LOST], [rough]))
    assert marks.event_error_s == pytest.approx([0.05])
    assert marks.covered == [True]


@pytest.mark.parametrize(("said", "right"), [(False, True), (True, False), (None, None)])
def test_the_memory_of_an_unknown_counts_where_something_is_said_of_it(said, right):
    found = {**finding("unknown", "range_x", depends_on=["range_x"]), "has_memory": said}
    marks = score(result([STRIPES], [found], "unknown"))
    assert marks.right_memory is right
    assert marks.holdout_improved
    piled = score(result([STRIPES], [found, finding("home_offset", "motor1")], "unknown"))
    both = {row.figure: row for row in table([marks, piled])}
    assert both["... and no named effect beside it"].value == "50.0 %"
    rows = {row.figure: row for row in table([marks])}
    assert rows["... right about memory, where it says"].cases == (said is not None)


def test_unknown_physics():
    flagged = score(
        result([STRIPES], [finding("unknown", "range_x", depends_on=["range_x"])], "unknown")
    )
    assert flagged.flagged
    assert flagged.right_driver
    assert flagged.right_place
    assert not flagged.misnamed
    elsewhere = score(
        result([STRIPES], [finding("unknown", "motor1", depends_on=["theta_1"])], "unknown")
    )
    assert elsewhere.flagged
    assert not elsewhere.right_driver
    assert not elsewhere.right_place
    assert score(result([STRIPES], [finding("sensor_scale", "range_x")], "unknown")).misnamed
    open_ = finding("sensor_scale", "range_x", alternatives=[("unknown", "range_x")])
    assert not score(result([STRIPES], [open_], "unknown")).misnamed
    silent = score(result([STRIPES], [], "unknown", "nothing_missing"))
    assert not silent.misnamed
    assert not silent.flagged


def test_an_interval_that_misses_and_a_vector():
    tilt = {
        "effect": "frame_tilt", "where": "frame", "value": [0.01, 0.0, 0.0], "unit": "rad",
        "parameters": {"rotation": [0.01, 0.0, 0.0]},
    }  # fmt: skip
    said = finding(
        "frame_tilt", "frame",
        {"rotation": ([0.011, 0.0, 0.0], [[0.0105, 0.0115], [-0.001, 0.001], [-0.001, 0.001]])},
    )  # fmt: skip
    marks = score(result([tilt], [said], bound={"rotation": [0.001, 0.001, 0.001]}))
    assert marks.covered == [False, True, True]
    assert marks.over_bound == pytest.approx([1.0, 0.0, 0.0])


def test_a_crash_is_a_wrong_answer():
    broken = result([], [], group="nothing")
    broken |= {"diagnosis": None, "failure": "ValueError: no"}
    assert score(broken).alarmed
    assert confusion([score(broken)]) == {("nothing", "failed"): 1}


def test_wilson_limits():
    # Newcombe 1998, Stat. Med. 17, 857, Table I: 81/263, 15/148, 0/20 and 1/29.
    for (hits, cases), limits in {
        (81, 263): (0.2553, 0.3662), (15, 148): (0.0624, 0.1605),
        (0, 20): (0.0, 0.1611), (1, 29): (0.0061, 0.1718),
    }.items():  # fmt: skip
        assert wilson(hits, cases) == pytest.approx(limits, abs=6e-5)
    assert wilson(0, 0) == (0.0, 1.0)


def test_median_limits_hold_the_median():
    low, high = median_limits([float(x) for x in range(101)])
    assert low < 50.0 < high
    assert high - low < 40.0
    assert math.isnan(median_limits([])[0])


def test_the_table_counts_as_by_hand():
    right = finding("home_offset", "motor2", {"angle": (0.0104, [0.0099, 0.0109])})
    wrong = finding("gear_ratio", "motor1")
    scores = [
        score(result([HOME], [right])), score(result([HOME], [right])),
        score(result([HOME], [wrong])), score(result([HOME], [right], motion="circle")),
        score(result([], [], group="nothing", verdict="nothing_missing")),
    ]  # fmt: skip
    rows = {row.figure: row for row in table(scores)}
    assert rows["single, moderate: named first"].value == "75.0 %"
    assert rows["single, moderate: named first"].met is False
    assert rows["false alarms, nothing missing"].value == "0.0 %"
    assert rows["false alarms, nothing missing"].met is True
    assert rows["unknown physics: flagged unknown"].met is None
    text = markdown(list(rows.values()))
    assert "| single, moderate: named first | at least 98 % | 75.0 % | 30.1 to 95.4 % | 4 |" in text


def test_the_picture_has_a_box_for_every_cell():
    scores = [
        Score("a", "single", "survey", [("home_offset", "motor1")], [("home_offset", "motor1")]),
        Score("b", "single", "survey", [("gear_ratio", "motor1")], [("home_offset", "motor1")]),
        Score("c", "unknown", "survey", [("unknown", "range_x")], [], kind="stripes"),
        Score("d", "two", "survey", [("x", "y"), ("z", "y")], []),
    ]
    cells = confusion(scores)
    assert sum(cells.values()) == 3
    rows, columns = rows_and_columns(cells)
    assert rows == ["gear_ratio", "home_offset", "unknown: stripes"]
    drawing = picture(cells, "3 < 4 cases")
    assert drawing.count("<rect") == 1 + len(rows) * len(columns)
    assert "3 &lt; 4 cases" in drawing
