"""What is said of small errors that were allowed for."""

from __future__ import annotations

from typing import Any

from deltactl.diagnosis.answer.records import AllowedFor, Evidence, Finding, ParameterResult, Where
from deltactl.diagnosis.report.limits import allowed_line


def _home(motor: int, angle_rad: float) -> AllowedFor:
    ends = [angle_rad - 1e-4, angle_rad + 1e-4]
    return AllowedFor(
        effect="home_offset", component=f"motor{motor}", usual=0.004,
        parameters={"angle": ParameterResult(value=angle_rad, ci95=ends, unit="rad")},
        times_usual=abs(angle_rad) / 0.004,
    )  # fmt: skip


def test_sizes_are_told_motor_by_motor_and_large_ones_again(make: Any) -> None:
    homes = [_home(2, 0.0076), _home(1, 0.00054)]
    said = allowed_line(make("explained", loosely_built=True, allowed_for=homes))
    assert "wrong home angles of motors 1 and 2 (+0.031 and +0.44 degrees)." in said
    large = "a wrong home angle of motor 2 (+0.44 degrees, usually up to 0.23 degrees)."
    assert said.endswith(f"to be checked by hand: {large}")


def test_nothing_is_said_of_what_does_not_show(make: Any) -> None:
    assert "more than noise" not in allowed_line(make("explained", loosely_built=True))
    assert allowed_line(make("explained")) == ""


def test_beside_a_delay_of_the_same_motor_they_may_be_its_form(make: Any) -> None:
    late = Finding(
        effect="following_lag",
        component="motor2",
        parameters={"time": ParameterResult(value=0.1, ci95=[0.09, 0.11], unit="s")},
        where=Where(axes=[], times_s=[]),
        evidence=Evidence(delta_chi2=100.0, p=1e-9),
        share_of_mismatch=0.9,
    )
    for motor, said in ((2, True), (1, False)):
        answer = make(
            "explained", findings=[late], loosely_built=True, allowed_for=[_home(motor, 0.0076)]
        )
        assert ("look first at where the arms rest" in allowed_line(answer)) == said
