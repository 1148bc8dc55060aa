"""What is asked about a machine, which answers can be taken, and what is said of them."""

from __future__ import annotations

import pytest

from deltactl.cli.recordings.init import _ask as asked_by_hand
from deltactl.firmware_py.describing.question import Question
from deltactl.firmware_py.describing.questions import QUESTIONS, WIRING, gather, numbers, remarks
from deltactl.foundation.errors import ConfigError
from tests.describing.conftest import DELTA, WIRED


def test_what_was_taken_unasked_and_full_steps_are_said() -> None:
    said = {key: text for key, text in DELTA.items() if key != "microsteps_per_rev"}
    answers = gather(QUESTIONS["delta"], said, None)
    assert "--microsteps-per-rev 1600" in remarks(QUESTIONS["delta"], said, answers)[0]
    assert remarks(QUESTIONS["delta"], DELTA, DELTA) == []
    full = DELTA | {"microsteps_per_rev": "200"}
    assert "200 pulses for one turn are full steps" in remarks(QUESTIONS["delta"], full, full)[0]
    for pulses, instead in (("128", "25600"), ("100", "20000"), ("256", "51200")):
        few = DELTA | {"microsteps_per_rev": pulses}
        assert remarks(QUESTIONS["delta"], few, few)[0].endswith(f"write {instead}")
    assert remarks(QUESTIONS["range_sensor"], {"name": "tof"}, {"name": "tof"}) == []


@pytest.mark.parametrize("key", [one.key for one in WIRING])
def test_hardware_is_told_nothing_that_nobody_said(key: str) -> None:
    """Not one of pins, limits and homing has a default."""
    said = {name: value for name, value in WIRED.items() if name != key}
    with pytest.raises(ConfigError, match=f"--{key.replace('_', '-')} is missing"):
        gather(WIRING, said, None)


def test_only_the_weight_that_may_be_is_asked_for() -> None:
    """Of a joint also where only commands are recorded: a weight makes it yield."""
    for motion, recorded, expected in (
        ("rotary", "both", ["hanging_nm"]),
        ("linear", "effort", ["slope_n"]),
        ("rotary", "command", ["hanging_nm"]),
        ("linear", "command", []),
    ):
        asked: list[str] = []

        def answer(question: Question, asked: list[str] = asked) -> str:
            asked.append(question.key)
            return question.default or "1"

        gather(QUESTIONS["servo_axis"], {"motion": motion, "recorded": recorded}, answer)
        weights = [key for key in asked if key in ("hanging_nm", "hanging_deg", "slope_n")]
        assert weights == expected


def test_questions_are_asked_where_somebody_sits() -> None:
    asked: list[str] = []

    def ask(question) -> str:
        asked.append(question.key)
        return question.default or "1"

    gather(QUESTIONS["delta"] + WIRING, {"name": "x"}, ask)
    assert "name" not in asked
    assert {"forearm_mm", "step_pins"} <= set(asked)
    with pytest.raises(ConfigError) as error:
        gather(WIRING, {}, None)
    assert len(error.value.args) == len([one for one in WIRING if one.default is None])


def test_an_answer_that_cannot_be_taken_is_asked_for_again(monkeypatch) -> None:
    typed = iter(["rotary", "95.1"])
    monkeypatch.setattr("deltactl.cli.recordings.init.typer.prompt", lambda *_, **__: next(typed))
    (inertia,) = (one for one in QUESTIONS["servo_axis"] if one.key == "inertia")
    assert asked_by_hand(inertia) == "95.1"
    kinds = {one.key: one for one in (*QUESTIONS["servo_axis"], *WIRING)}
    assert kinds["motion"].wrong("turning") == "'turning': must be rotary or linear"
    assert not kinds["estop_pin"].wrong("none")
    assert not kinds["step_pins"].wrong("17, 27, 22")
    for one in (*QUESTIONS["delta"], *QUESTIONS["servo_axis"]):
        assert one.default is None or not one.wrong(one.default)


def test_a_decimal_comma_is_one_and_a_doubtful_answer_is_asked_for_again() -> None:
    asked = {one.key: one for one in (*QUESTIONS["delta"], *WIRING)}
    assert not asked["upper_arm_mm"].wrong("314,2")
    assert numbers({"upper_arm_mm": "314,2"}, "upper_arm_mm") == (314.2,)
    assert numbers({"gear_ratio": "5:2"}, "gear_ratio") == (2.5,)
    assert numbers({"arm_deg": "-20, 110"}, "arm_deg", 2) == (-20.0, 110.0)
    for key, answer, wrong in (
        ("upper_arm_mm", "1,200", "'1,200': is it 1200 or 1.200? Write it without a comma"),
        ("upper_arm_mm", "150 320", "'150 320': must be a number"),
        ("upper_arm_mm", "-150", "'-150': must not be below 1"),
        ("upper_arm_mm", "0.15", "'0.15': must not be below 1 mm; is it in metres? Then write 150"),
        ("gear_ratio", "5:0", "'5:0': must be a number"),
        (
            "upper_arm_mm",
            "150 mm",
            "'150 mm': must be a number, without a unit (Upper arm: from the motor axis to the"
            " elbow, mm)",
        ),
        (
            "gear_ratio",
            "0.25",
            "'0.25': did you mean 4? The motor turns 4 times for one turn of the arm",
        ),
        (
            "microsteps_per_rev",
            "16",
            "'16': 16 microsteps a full step? For a motor with 200 steps a turn write"
            " --microsteps-per-rev 3200. For a motor with fewer, write both: a 28BYJ-48 has 32, in"
            " half steps --microsteps-per-rev 32x2 --gear-ratio 63.68",
        ),
        ("step_pins", "17 27", "'17 27': must be 3 numbers, with spaces between"),
        ("arm_deg", "-20 to 110", "'-20 to 110': must be 2 numbers"),
    ):
        assert asked[key].wrong(answer) == wrong


def test_all_options_that_cannot_be_taken_are_told_with_those_that_are_missing() -> None:
    with pytest.raises(ConfigError) as error:
        gather(
            QUESTIONS["delta"], {"name": "x", "base_radius_mm": "INCH", "forearm_mm": "-1"}, None
        )
    first, second, *missing = error.value.args
    assert first == "--base-radius-mm 'INCH': must be a number"
    assert second == "--forearm-mm '-1': must not be below 1"
    assert all("is missing" in one for one in missing)


def test_what_would_be_guessed_is_said_with_what_is_missing() -> None:
    """A stepper axis without its pulses per turn was asked for its gear only, and had 1600."""
    with pytest.raises(ConfigError) as raised:
        gather(QUESTIONS["stepper_axis"], {"name": "drum"}, None)
    assert "--gear-ratio is missing" in str(raised.value)
    assert "--microsteps-per-rev is missing (without it 1600 would be assumed)" in str(raised.value)
    assert gather(QUESTIONS["stepper_axis"], {"name": "drum", "gear_ratio": "3"}, None)


@pytest.mark.parametrize(
    ("recorded", "asked"),
    [
        ("command", {"zero", "hanging_nm"}),
        ("effort", {"inertia", "effort_gain", "hanging_nm", "constant_nm"}),
        ("both", {"zero", "inertia", "effort_gain", "hanging_nm", "constant_nm"}),
    ],
)
def test_nothing_is_asked_about_what_is_not_recorded(recorded: str, asked: set[str]) -> None:
    heard: list[str] = []

    def ask(question: Question) -> str:
        heard.append(question.key)
        return recorded if question.key == "recorded" else question.default or "x"

    answers = gather(QUESTIONS["servo_axis"], {}, ask)
    assert set(heard) - {"name", "motion", "recorded"} == asked
    assert (answers["zero"], answers["inertia"]) == ("absolute", "0")


@pytest.mark.parametrize(
    ("typed", "value"),
    [
        ("1.17*9.81*0.15", 1.17 * 9.81 * 0.15), ("1/3", 1 / 3), (" 2 * 3 / 4 ", 1.5),
        ("-1e-3", -1e-3), ("1,17*9,81", 1.17 * 9.81), ("2*-3", -6.0),
    ],
)  # fmt: skip
def test_products_and_quotients_are_numbers(typed: str, value: float) -> None:
    assert numbers({"hanging_nm": typed}, "hanging_nm") == pytest.approx((value,))


@pytest.mark.parametrize("typed", ["1/0", "2**3", "1*", "/3", "nan", "inf", "1e400", "1_0", "a*2"])
def test_what_comes_to_no_number_is_refused(typed: str) -> None:
    with pytest.raises(ConfigError, match="must be a number"):
        numbers({"hanging_nm": typed}, "hanging_nm")
