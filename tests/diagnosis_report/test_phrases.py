"""Numbers in the units of people, odds, and the names of effects and places."""

from __future__ import annotations

import math
from typing import Any

import pytest

from deltactl.diagnosis.answer.records import (
    ParameterResult,
)
from deltactl.diagnosis.report.names import by_noise, effect, followed, listed, spelled
from deltactl.diagnosis.report.sizes import number, quantity, sizes
from deltactl.models.effects import VOCABULARY, card_of
from deltactl.models.effects.lone_axis import command_effects, effort_effects, sensor_effects

VERDICTS = ("nothing_missing", "explained", "partly_explained", "unexplained")
NAN = math.nan


def test_moments_are_given_to_the_hundredth(parts: Any) -> None:
    moment = ParameterResult(value=73.81, ci95=[73.81, 73.8300], unit="s")
    (size,) = sizes("lost_steps", "time", moment)
    assert size.text == "73.81 s (95 % interval 73.81 to 73.83)"


@pytest.mark.parametrize(
    ("value", "unit", "parameter", "text"),
    [
        (0.0052, "s", "time", "5.2 ms"),
        (81.0, "s", "time_constant", "81 s"),
        (0.0175, "rad", "angle", "+1.0 degrees"),
        (-0.0021, "m", "length_error", "-2.1 mm"),
        (1.0035, "1", "scale", "+0.35 %"),
        (0.12, "kg", "mass", "+120 g"),
        (-0.0089, "1", "strain", "-8.9 mm per m"),
        (math.inf, "N m/rad", "stiffness", "any size"),
        (math.nan, "m", "offset", "not known"),
    ],
)
def test_units_of_people(value: float, unit: str, parameter: str, text: str) -> None:
    assert quantity(value, unit, parameter) == text


def test_intervals_keep_two_digits_of_their_half_width() -> None:
    ends = [[0.0, 0.002], [-0.003, -0.001], [-0.001, 0.001]]
    result = ParameterResult(value=[0.001, -0.002, 0.0], ci95=ends, unit="rad")
    texts = [size.text for size in sizes("frame_tilt", "rotation", result)]
    assert texts[0] == "+0.057 degrees (95 % interval 0.000 to +0.115)"
    assert len(texts) == 3
    open_end = ParameterResult(value=5000.0, ci95=[3000.0, 1e300], unit="N m/rad")
    (size,) = sizes("joint_compliance", "stiffness", open_end)
    assert size.text == "5000 N m/rad (95 % interval above 3000)"


def test_rounding_never_leaves_a_minus_before_nothing() -> None:
    assert number(-0.0004, 2) == "0.00"
    assert number(-1234.6, 0) == "-1235"
    assert number(4.94e-9, 0) == "0"
    assert number(4.94e-9, 9) == "4.94e-09"


def test_a_p_value_is_rounded_and_bounded() -> None:
    for p, text in ((0.31, "p = 0.3"), (0.0123, "p = 0.01"), (1e-9, "p < 1e-6")):
        assert by_noise(p) == text


def test_every_effect_of_every_chain_has_words() -> None:
    chains = [VOCABULARY, command_effects("rotary"), effort_effects("linear"), sensor_effects()]
    names = {name for chain in chains for name in chain}
    for name in names:
        assert card_of(name).words.noun
        assert "_" not in effect(name, "motor1")


def test_words_for_places_and_drivers() -> None:
    assert effect("sensor_scale", "range_x") == "a wrong scale of the x sensor"
    assert effect("new_effect", "motor9") == "new effect at motor 9"
    assert followed("theta_2 [rad]") == "the angle of arm 2"
    assert spelled("lost_steps motor1") == "steps lost by motor 1"
    assert spelled("new_effect motor1") == "new_effect motor1", "no card knows it"
    assert listed(["a", "b", "c"], "or") == "a, b or c"
    assert listed([]) == ""
