"""What goes with the size of a finding: what the others, and the motion, have to do with it."""

from __future__ import annotations

from typing import Any

import numpy as np

from deltactl.diagnosis.answer.corrected_robot import sure
from deltactl.diagnosis.answer.records import (
    Alternative,
    Channel,
    Evidence,
    Finding,
    ParameterResult,
    Picture,
    PriorSensitivity,
    Where,
)
from deltactl.diagnosis.report.finding import notes
from deltactl.diagnosis.report.page import finding_cards
from deltactl.diagnosis.report.remedies import remedies
from tests.diagnosis_report.conftest import card_text


def found(effect: str, follows: str = "", unit: str = "rad", **sizes: float) -> Finding:
    parameters = {
        name: ParameterResult(value=value, ci95=[value, value], unit=unit)
        for name, value in sizes.items()
    }
    return Finding(
        effect=effect,
        component="axis",
        parameters=parameters,
        where=Where(axes=[], times_s=[]),
        evidence=Evidence(delta_chi2=100.0, p=1e-9),
        share_of_mismatch=0.9,
        depends_on=[follows] if follows else [],
        probability=0.99,
    )


def test_a_loop_that_rings_may_be_all_that_is_late(make: Any) -> None:
    """2 zeta / omega of 20.3 Hz and 0.336 are 5.3 ms."""
    late = found("following_lag", unit="s", time=0.0, dead_time=0.0064)
    rings = found("resonance", unit="1", frequency=20.3, damping=0.336)
    answer = make("explained", findings=[late, rings])
    (note,) = notes(late, answer)
    assert "is late by 5.3 ms by itself" in note
    assert "Raise the gains in the control of the axis" in " ".join(remedies(answer))
    slow = found("following_lag", unit="s", time=0.0, dead_time=0.064)
    answer = make("explained", findings=[slow, rings])
    assert notes(slow, answer) == []
    assert "higher gains shorten no dead time" in " ".join(remedies(answer))


def test_a_force_beside_one_that_follows_the_speed_is_none_to_be_set(make: Any) -> None:
    constant = found("effort_offset", unit="N", offset=-3.2)
    with_speed = found("unknown", "velocity", "N", size_rms=1.9)
    answer = make("partly_explained", findings=[constant, with_speed])
    assert "with what follows the speed (finding 2) the force" in " ".join(notes(constant, answer))
    assert not sure(constant, answer)
    assert "find out first what of the effort follows the speed" in remedies(answer)[0].lower()
    alone = make("explained", findings=[constant])
    assert notes(constant, alone) == []
    assert sure(constant, alone)


def test_both_waves_of_a_periodic_error_are_told_together(make: Any) -> None:
    """sin x + 0.5 sin 2x spans 2.598, by calculus."""
    one = found("transmission_error", amplitude=0.02, amplitude_2=0.01, phase=0.0, phase_2=0.0)
    one.parameters["period"] = ParameterResult(value=0.2, ci95=[0.2, 0.2], unit="rad")
    (note,) = notes(one, make("explained", findings=[one]))
    assert note.endswith(f"both together span {np.rad2deg(0.02 * 2.598):.2f} degrees.")


def test_time_and_speed_are_not_told_apart_by_a_motion_that_gets_faster(make: Any) -> None:
    drift = found("unknown", "time", size_rms=0.01)
    t_s = np.linspace(0.0, 10.0, 500)
    for speed, same in ((np.cos(3.0 * t_s), True), (t_s * np.cos(t_s**2), False)):
        channel = Channel(
            name="position", unit="rad", observed=t_s, before=t_s, after=t_s, noise=1.0
        )
        picture = Picture(t_s=t_s, channels=[channel], covariates={"velocity": speed, "time": t_s})
        answer = make("partly_explained", findings=[drift]).model_copy(update={"picture": picture})
        assert ("The motion itself changes" in " ".join(notes(drift, answer))) != same
        assert ("repeat one and the same motion" in remedies(answer)[0].lower()) != same


def test_what_hangs_on_a_prior_is_said_in_the_report_as_well(make: Any) -> None:
    one = found("joint_compliance", unit="N m/rad", stiffness=13.0)
    hangs = PriorSensitivity(
        effect="joint_compliance", component="axis", probability=0.99, narrower=0.999, wider=0.18
    )
    answer = make("explained", findings=[one], prior_sensitivity=[hangs])
    assert "Take it for a guess" in card_text(one, answer)
    assert "Take it for a guess" in finding_cards(answer, (0.0, 1.0))[0]


def test_an_unknown_that_is_one_wave_of_two_periods_says_so(make: Any) -> None:
    """A worm that turned less than twice cannot be named, and is not no known effect either."""
    t_s = np.linspace(0.0, 500.0, 300)
    place = 1e-4 * t_s
    unknown = found("unknown", "time", size_rms=1e-5)
    for waves, told in ((1.9, True), (0.4, False)):
        wave = 1e-5 * np.sin(2.0 * np.pi * waves * t_s / 500.0 + 0.3)
        channel = Channel(
            name="position",
            unit="rad",
            observed=place + wave,
            before=place,
            after=place,
            noise=1e-6,
        )
        picture = Picture(t_s=t_s, channels=[channel], covariates={"position": place, "time": t_s})
        answer = make("unexplained", findings=[unknown]).model_copy(update={"picture": picture})
        said = card_text(unknown, answer)
        assert ("of which this recording holds 1.9" in said) == told
        assert ("nothing that this recording can name is the cause" in said) == told
        assert ("over at least three periods" in " ".join(remedies(answer))) == told


def test_a_zero_far_from_where_it_moved_is_told_there(make: Any) -> None:
    """0.0029 of 180 degrees is 0.52 degrees: at its zero alone it seems ten times as far off."""
    zero = found("home_offset", angle=np.radians(-0.597))
    ratio = found("gear_ratio", unit="1", scale=1.0029)
    t_s = np.linspace(0.0, 30.0, 300)
    for middle, told in ((180.0, True), (0.0, False)):
        place = np.radians(middle + 9.0 * np.sin(t_s))
        channel = Channel(
            name="position", unit="rad", observed=place, before=place, after=place, noise=0.01
        )
        picture = Picture(t_s=t_s, channels=[channel], covariates={"position": place})
        answer = make("explained", findings=[ratio, zero]).model_copy(update={"picture": picture})
        assert ("it is 0.074 degrees below" in " ".join(notes(zero, answer))) == told


def test_a_drift_among_the_rivals_is_to_be_ruled_out_as_well(make: Any) -> None:
    others = [
        Alternative(effect=effect, component="axis", delta_chi2=0.0, probability=0.33)
        for effect in ("unknown", "joint_compliance")
    ]
    ratio = found("gear_ratio", unit="1", scale=1.0007)
    ratio = ratio.model_copy(update={"probability": 0.33, "alternatives": others})
    first, second, *_ = remedies(make("explained", findings=[ratio], next_experiment=None))
    assert "causes of finding 1" in first
    assert second.startswith("If finding 1 is confirmed")
