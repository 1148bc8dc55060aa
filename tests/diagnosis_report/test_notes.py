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
    Where,
)
from deltactl.diagnosis.report.pairs import beside
from deltactl.diagnosis.report.remedies import remedies


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
    (note,) = beside(late, answer)
    assert "is late by 5.3 ms by itself" in note
    assert "Raise the gains in the control of the axis" in " ".join(remedies(answer))
    slow = found("following_lag", unit="s", time=0.0, dead_time=0.064)
    answer = make("explained", findings=[slow, rings])
    assert beside(slow, answer) == []
    assert "higher gains shorten no dead time" in " ".join(remedies(answer))


def test_a_force_beside_one_that_follows_the_speed_is_none_to_be_set(make: Any) -> None:
    constant = found("effort_offset", unit="N", offset=-3.2)
    with_speed = found("unknown", "velocity", "N", size_rms=1.9)
    answer = make("partly_explained", findings=[constant, with_speed])
    assert "with what follows the speed (finding 2) the force" in " ".join(beside(constant, answer))
    assert not sure(constant, answer)
    assert "find out first what of the effort follows the speed" in remedies(answer)[0].lower()
    alone = make("explained", findings=[constant])
    assert beside(constant, alone) == []
    assert sure(constant, alone)


def test_a_zero_far_from_where_it_moved_is_given_there(make: Any) -> None:
    """0.0029 of 180 degrees is 0.52 degrees: at its zero alone it seems ten times as far off."""
    zero = found("home_offset", angle=np.radians(-0.597))
    ratio = found("gear_ratio", unit="1", scale=1.0029)
    t_s = np.linspace(0.0, 30.0, 300)
    for middle, given in ((180.0, True), (0.0, False)):
        place = np.radians(middle + 9.0 * np.sin(t_s))
        channel = Channel(
            name="position", unit="rad", observed=place, before=place, after=place, noise=0.01
        )
        picture = Picture(t_s=t_s, channels=[channel], covariates={"position": place})
        answer = make("explained", findings=[ratio, zero]).model_copy(update={"picture": picture})
        assert ("it is 0.074 degrees below" in " ".join(beside(zero, answer))) == given


def test_a_drift_among_the_alternatives_is_to_be_ruled_out_as_well(make: Any) -> None:
    others = [
        Alternative(effect=effect, component="axis", delta_chi2=0.0, probability=0.33)
        for effect in ("unknown", "joint_compliance")
    ]
    ratio = found("gear_ratio", unit="1", scale=1.0007)
    ratio = ratio.model_copy(update={"probability": 0.33, "alternatives": others})
    first, second, *_ = remedies(make("explained", findings=[ratio], next_experiment=None))
    assert "cause of finding 1" in first
    assert second.startswith("If finding 1 is confirmed")
