"""Lines through findings, and what robots share."""

from __future__ import annotations

import numpy as np
import pytest

from deltactl.fleet.together import DAY_S, courses, groups, trends


def rows_of(robot: str, values: np.ndarray, sigma: float, effect: str = "gear_ratio") -> list[dict]:
    size = {"effect": effect, "component": "motor1", "parameter": "scale", "unit": "1"}
    return [
        {
            "recording": f"{robot}-{day}",
            "robot": robot,
            "time_s": day * 5 * DAY_S,
            "verdict": "explained",
            "findings": [
                size | {"value": value, "low": value - 1.96 * sigma, "high": value + 1.96 * sigma}
            ],
        }
        for day, value in enumerate(values.tolist())
    ]


@pytest.mark.study
def test_false_trends_are_rare_also_where_the_scatter_is_larger_than_the_intervals() -> None:
    """200 fleets of ten robots that stand still: the promise is one in a hundred."""
    rng = np.random.default_rng(5)
    alarms = 0
    for _ in range(200):
        rows = [
            row
            for robot in range(10)
            for row in rows_of(f"r{robot}", 1.0 + 3e-3 * rng.standard_normal(20), sigma=1e-3)
        ]
        alarms += bool(trends(courses(rows), {}))
    assert alarms <= 7


def test_the_interval_of_a_rate_holds_the_truth() -> None:
    rng = np.random.default_rng(6)
    inside = 0
    for _ in range(200):
        values = 1.0 + 1e-3 * np.arange(20) + 2e-3 * rng.standard_normal(20)
        (trend,) = trends(courses(rows_of("r", values, sigma=2e-3)), {})
        inside += trend.low_per_day <= 2e-4 <= trend.high_per_day
    assert inside >= 180


def test_a_batch_is_one_group_and_a_lone_robot_none() -> None:
    rng = np.random.default_rng(7)
    sizes = {"a": 1.004, "b": 1.0041, "c": 1.0039, "alone": 2.0}
    rows = [
        row
        for robot, size in sizes.items()
        for row in rows_of(robot, size + 1e-4 * rng.standard_normal(8), sigma=1e-4)
    ]
    (group,) = groups(courses(rows))
    assert group.robots == ("a", "b", "c")


def test_a_figure_beside_the_size_makes_no_batch() -> None:
    """Friction that grows on three robots, each time with a stiffness of about the same size."""
    rng = np.random.default_rng(8)
    rows = []
    for robot in "abc":
        for row in rows_of(robot, 1.0 + 1e-3 * np.arange(20), sigma=1e-4):
            (width,) = row["findings"]
            beside = width | {"parameter": "stiffness", "value": 2e4 + rng.standard_normal()}
            rows.append(row | {"findings": [width, beside]})
    found = courses(rows)
    moving = trends(found, {})
    assert len(moving) == 3
    assert groups(found, moving) == []
