"""What sister machines have counts, the machine's own recordings do not."""

from __future__ import annotations

from typing import Any

import pytest

from deltactl.fleet.together import Sisters, sharpened
from deltactl.models.effects import VOCABULARY

ARM, PLAY = ("upper_arm_length", "arm1", "length_error"), ("gear_backlash", "motor1", "width")


def row(robot: str, number: int, *found: dict[str, Any]) -> dict[str, Any]:
    return {"recording": f"{robot}-{number}", "robot": robot, "time_s": float(number),
            "verdict": "explained", "findings": list(found)}  # fmt: skip


def size(
    effect: str, component: str, parameter: str, probability: float, **more: Any
) -> dict[str, Any]:
    return {"effect": effect, "component": component, "parameter": parameter, "value": 1e-3,
            "low": 5e-4, "high": 2e-3, "unit": "m", "probability": probability, **more}  # fmt: skip


def fleet(of_arm: int, machines: int = 10) -> list[dict[str, Any]]:
    """Machines of which the first so many have a wrong arm in all five recordings."""
    return [
        row(f"r{k}", n, *([size(*ARM, 0.9)] if k < of_arm else []))
        for k in range(machines)
        for n in range(5)
    ]


def asked(rows: list[dict[str, Any]], one: dict[str, Any]) -> dict[str, Any]:
    """What becomes of one finding of another machine."""
    [last] = [r for r in sharpened([*rows, row("new", 0, one)]) if r["robot"] == "new"]
    [found] = last["findings"]
    return found


def test_a_batch_makes_the_next_of_its_kind_more_probable() -> None:
    found = asked(fleet(of_arm=6), size(*ARM, 0.5))
    odds = VOCABULARY["upper_arm_length"].odds
    share = (6 + 4 * odds / (1 + odds)) / 14
    factor = share / (1 - share) / odds
    assert found["probability"] == pytest.approx(factor / (1 + factor))
    assert (found["alone"], found["sisters"]) == (0.5, "lasts on 6 of 10 sisters")


def test_what_no_sister_has_becomes_less_probable() -> None:
    found = asked(fleet(of_arm=0), size(*ARM, 0.5))
    assert found["probability"] < 0.5
    assert asked([], size(*ARM, 0.5))["probability"] == pytest.approx(0.5, abs=1e-3)


def test_sisters_decide_between_two_that_one_recording_cannot_tell_apart() -> None:
    rival = {"effect": "upper_arm_length", "component": "arm1", "probability": 0.4}
    found = asked(fleet(of_arm=8), size(*PLAY, 0.55, alternatives=[rival]))
    assert found["rather"] == "upper_arm_length at arm1"
    assert found["probability"] < 0.1
    alone = asked(fleet(of_arm=0), size(*PLAY, 0.55, alternatives=[rival]))
    assert alone["rather"] is None


def test_a_machine_is_not_its_own_sister() -> None:
    rows = fleet(of_arm=1)
    known = Sisters.of(rows)
    assert known.having("r0", ("upper_arm_length", "arm")) == (0, 9)
    assert known.having("r1", ("upper_arm_length", "arm")) == (1, 9)
    own = [one for r in sharpened(rows) for one in r["findings"]]
    assert all(one["probability"] < one["alone"] for one in own)
    assert "error" in sharpened([{"recording": "x", "error": "bad"}])[0]
