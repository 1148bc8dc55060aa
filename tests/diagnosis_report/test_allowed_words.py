"""What is reported of small errors that were allowed for."""

from __future__ import annotations

from typing import Any

from deltactl.diagnosis.answer.records import AllowedFor, ParameterResult
from deltactl.diagnosis.report.limits import allowed_line


def _home(motor: int, angle_rad: float) -> AllowedFor:
    ends = [angle_rad - 1e-4, angle_rad + 1e-4]
    return AllowedFor(
        effect="home_offset", component=f"motor{motor}", usual=0.004,
        parameters={"angle": ParameterResult(value=angle_rad, ci95=ends, unit="rad")},
        times_usual=abs(angle_rad) / 0.004,
    )  # fmt: skip


def test_each_has_its_size_and_what_is_usual(make: Any) -> None:
    homes = [_home(2, 0.0076), _home(1, 0.00054)]
    line = allowed_line(make("explained", loosely_built=True, allowed_for=homes))
    for motor, size in ((1, "+0.031"), (2, "+0.44")):
        usual = f"({size} degrees, usually up to 0.23 degrees)"
        assert f"a wrong home angle of motor {motor} {usual}" in line


def test_nothing_is_reported_of_what_does_not_show(make: Any) -> None:
    assert "Those that show" not in allowed_line(make("explained", loosely_built=True))
    assert allowed_line(make("explained")) == ""
