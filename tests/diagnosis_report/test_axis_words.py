"""What is reported of a single axis beside its findings: sums of delays, noise by place."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest

from deltactl.diagnosis.answer.records import (
    Evidence,
    Finding,
    Fit,
    ParameterResult,
    Unexplained,
    Where,
)
from deltactl.diagnosis.report.headline import headline
from deltactl.diagnosis.report.in_words import in_words
from deltactl.diagnosis.report.remedies import remedies
from deltactl.diagnosis.report.screen import sentences, table_rows
from deltactl.models.effects.lone_axis import command_effects, effort_effects
from deltactl.models.effects.units_in_use import said
from deltactl.models.robot import EffectEntry, ServoAxis
from tests.diagnosis_report.conftest import card_text

DEG = np.pi / 180.0


def angle_of(value: float) -> ParameterResult:
    return ParameterResult(value=value, ci95=[0.99 * value, 1.01 * value], unit="rad")


def periodic() -> Finding:
    return Finding(
        effect="transmission_error",
        component="axis",
        parameters={
            "amplitude": ParameterResult(value=1e-5, ci95=[0.9e-5, 1.1e-5], unit="rad"),
            "period": ParameterResult(value=1.6 * DEG, ci95=[1.58 * DEG, 1.62 * DEG], unit="rad"),
        },
        where=Where(axes=[], times_s=[]),
        evidence=Evidence(delta_chi2=100.0, p=1e-9),
        share_of_mismatch=0.9,
    )


@pytest.mark.parametrize(
    ("second", "size", "period"), [(7e-3, "0.4011", "180.0"), (1e-6, "0.05730", "360.0")]
)
def test_of_two_harmonics_the_larger_is_shown(
    make: Any, second: float, size: str, period: str
) -> None:
    """Of 0.0007 degrees a turn and 0.4 twice a turn the screen showed the first alone."""
    found = {"amplitude": 1e-3, "period": 2.0 * np.pi, "amplitude_2": second, "phase_2": 0.0}
    one = periodic().model_copy(
        update={"parameters": {name: angle_of(value) for name, value in found.items()}}
    )
    answer = in_words(make("explained", findings=[one]), command_effects("rotary"))
    rows = [row[3] for row in table_rows(1, answer.findings[0])]
    assert rows == [f"{size} degrees", f"{period} degrees"]
    says = f"{answer.findings[0].says} {' '.join(remedies(answer))}"
    assert says.count(size[:5]) > 1
    assert f"every {float(period):.0f} degrees" in says


@pytest.mark.parametrize(
    ("value", "unit", "text"),
    [
        (1.87e-5, "rad", "0.00107 degrees"),
        (1.23e-6, "rad", "0.0000705 degrees"),
        (2.0, "rad", "115 degrees"),
        (-0.124, "m", "-124 mm"),
        (0.06252, "s", "62.5 ms"),
    ],
)
def test_sizes_are_given_in_usual_units_without_exponents(
    value: float, unit: str, text: str
) -> None:
    assert said(value, unit) == text


def test_the_scatter_at_one_place_is_given_where_it_is_not_what_is_left(make: Any) -> None:
    figures = {
        "rms_before_m": 0.093,
        "rms_after_m": 0.072,
        "noise_floor_m": 0.068,
        "holdout_rms_before_m": 0.093,
        "holdout_rms_after_m": 0.074,
    }

    def lines(within: float | None) -> str:
        fit = Fit(**figures, scatter_within_m=within)
        rest = Unexplained(share_of_mismatch=0.0)
        return in_words(make("explained", fit=fit, unexplained=rest)).unexplained.says

    assert "readings at one place scatter by 16 mm" in lines(0.0163)
    assert "place" not in lines(0.06)
    assert "place" not in lines(None)


def test_a_harmonic_of_what_the_robot_file_knows_is_called_that(make: Any) -> None:
    def says(known_deg: float) -> str:
        known = EffectEntry(
            effect="transmission_error",
            component="axis",
            parameters={"amplitude": 1e-4, "period": known_deg * DEG},
        )
        answer = make("explained", findings=[periodic()])
        return str(in_words(answer, command_effects("rotary"), known=[known]).findings[0].says)

    assert "an error with a period of 3.21 degrees, of which this is harmonic 2" in says(3.21)
    assert "harmonic 1" in says(1.61)
    assert "harmonic" not in says(4.0)


def lag(dead: tuple[float, float, float], time: tuple[float, float, float]) -> Finding:
    sizes = {
        name: ParameterResult(value=value, ci95=[low, high], unit="s")
        for name, (value, low, high) in (("time", time), ("dead_time", dead))
    }
    changes = {"effect": "following_lag", "parameters": sizes}
    return periodic().model_copy(update=changes)


def test_of_a_delay_whose_parts_are_not_known_the_sum_is_given(make: Any) -> None:
    def text(finding: Finding) -> str:
        answer = in_words(make("explained", findings=[finding]), command_effects("rotary"))
        (finding,) = answer.findings
        return " ".join([card_text(finding, answer), *remedies(answer)])

    open_one = text(lag((0.0019, 0.0, 0.129), (0.065, 0.0, 0.184)))
    assert "drive that follows late axis 66.9 ms" in open_one
    assert "time constant" not in open_one, "parts that are not known have no size"
    assert "it is late by 66.9 ms in all." in open_one
    assert "Raise the gains in the control of the axis" in open_one
    known = text(lag((0.25, 0.24, 0.26), (0.09, 0.08, 0.1)))
    assert "Command the axis earlier, or look for what delays it" in known
    assert "higher gains shorten no dead time" in known
    assert "The axis follows its command late, by 66.9 ms in all" in open_one
    assert "by 63.3 ms in all" in text(lag((0.0515, 0.026, 0.078), (0.0118, 0.0, 0.037)))
    # Two time constants of half the size, and a shorter dead time, would fit nearly as well.
    assert "by 116 ms in all" in text(lag((0.0622, 0.0575, 0.0682), (0.0542, 0.0476, 0.0597)))
    sure = text(lag((0.0542, 0.0476, 0.0597), (0.0222, 0.0175, 0.0282)))
    assert "in all" not in sure
    assert "with a time constant of 22.2 ms after a dead time of 54.2 ms" in sure


def following(*followed: str) -> Finding:
    return Finding(
        effect="unknown",
        component="axis",
        parameters={"size_rms": ParameterResult(value=2.2e-3, ci95=[2e-3, 2.4e-3], unit="rad")},
        where=Where(axes=["position"], times_s=[]),
        evidence=Evidence(delta_chi2=185.0, p=4e-14),
        share_of_mismatch=0.008,
        depends_on=list(followed),
    )


def friction() -> Finding:
    return Finding(
        effect="joint_friction",
        component="axis",
        parameters={"width": ParameterResult(value=0.023, ci95=[0.021, 0.025], unit="rad")},
        where=Where(axes=["position"], times_s=[]),
        evidence=Evidence(delta_chi2=407.0, p=6e-24),
        share_of_mismatch=0.018,
    )


@pytest.mark.parametrize("beside", [True, False])
def test_a_direction_beside_friction_is_a_gap_that_changes_along_the_travel(
    make: Any, beside: bool
) -> None:
    found = [friction(), following("direction")][0 if beside else 1 :]
    fit = Fit(
        rms_before_m=0.02,
        rms_after_m=2e-3,
        noise_floor_m=2e-3,
        unit="rad",
        holdout_rms_before_m=0.0216,
        holdout_rms_after_m=0.0021,
    )
    answer = make("partly_explained", findings=found, fit=fit, next_experiment=None)
    told = in_words(answer, command_effects("rotary"))
    assert ("not the same all along its travel" in told.findings[-1].says) == beside
    advice = remedies(told)[-1]
    assert ("to and fro by a little at several places" in advice) == beside
    assert ("(by about 0.13 degrees)" in advice) == beside
    # Against a corrected file the friction is no finding any more, and the words stay.
    file = EffectEntry(effect="joint_friction", component="axis", parameters={"width": 0.02})
    later = in_words(answer, command_effects("rotary"), known=[file])
    assert "not the same all along its travel" in later.findings[-1].says
    axis = ServoAxis(kind="servo_axis", name="a", motion="rotary", effects=(file,))
    assert "to and fro by a little at several places" in remedies(later, axis)[-1]


def test_what_comes_with_motion_is_said_once_and_not_as_noise(make: Any) -> None:
    fit = Fit(
        rms_before_m=0.0216, rms_after_m=0.0021, noise_floor_m=0.0021, unit="rad",
        holdout_rms_before_m=0.0216, holdout_rms_after_m=0.0021,
        scatter_within_m=0.00044, left_correlation=0.84, left_apart_s=0.04, left_lasts_s=0.32,
    )  # fmt: skip
    rest = Unexplained(share_of_mismatch=0.0, p=1.0)
    answer = make("partly_explained", findings=[friction()], fit=fit, unexplained=rest)
    text = "\n".join(sentences(in_words(answer)))
    assert text.count("readings at one place scatter") == 1
    assert "of noise" not in text
    assert "need not be noise" not in text


def test_an_effort_that_comes_early_is_given_by_its_dead_time(make: Any) -> None:
    """It has no time constant; the sentence of a command's delay asked for one, and failed."""
    kinds = effort_effects("rotary")
    says = kinds["following_lag"].sentence("axis", {"dead_time": 0.03})
    assert "30.0 ms" in says
    size = ParameterResult(value=0.03, ci95=[0.02, 0.04], unit="s")
    late = Finding(
        effect="following_lag",
        component="axis",
        parameters={"dead_time": size},
        where=Where(axes=[], times_s=[]),
        evidence=Evidence(delta_chi2=100.0, p=1e-9),
        share_of_mismatch=0.9,
    )
    answer = make("explained", findings=[late])
    assert "explained by a delay between effort and motion of the axis" in headline(answer)
    (do,) = remedies(answer)[:1]
    assert do.startswith("Look for what delays the motion of the axis, or its readings, behind")
    assert do.endswith("it comes after the effort by a dead time of 30.0 ms.")


def test_friction_that_a_load_makes_larger_says_how_much_is_there_without_one(
    make: Any,
) -> None:
    def shown(unloaded: float) -> str:
        parameters = {
            "width": ParameterResult(value=0.09, ci95=[0.08, 0.1], unit="rad"),
            "unloaded": ParameterResult(value=unloaded, ci95=[0.0, 1.0], unit="1"),
        }
        finding = following().model_copy(
            update={"effect": "joint_friction", "parameters": parameters}
        )
        return card_text(finding, make())

    assert "share that is there without a load 30" in shown(0.3)
