"""For each classic tie: the run that is proposed, and that it does settle the tie."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

import numpy as np
import pytest

from deltactl.diagnosis.experiment import Proposal, Tie, next_experiment
from deltactl.diagnosis.experiment.design import EXPERIMENT, contains
from deltactl.diagnosis.plants.delta.motions import Motion
from deltactl.diagnosis.plants.delta.plant import DeltaPlant
from deltactl.diagnosis.report.next_run import tie_line
from deltactl.models.robot import EffectEntry

if TYPE_CHECKING:
    from collections.abc import Callable

TIED = 11.0


def entry(effect: str, component: str, **parameters: float) -> EffectEntry:
    return EffectEntry(effect=effect, component=component, parameters=dict(parameters))


def each(effect: str, stem: str = "motor") -> list[tuple[str, str]]:
    return [(effect, f"{stem}{number}") for number in (1, 2, 3)]


def driven(job: dict[str, Any]) -> Motion:
    """What the robot does on a job: the closed path as often as it says."""
    lap = np.array(job["path"]["angles_deg"])
    path = np.concatenate([lap, *[lap[1:]] * (job["repeats"] - 1)])
    return Motion(job["name"], "", path, job["path"]["dwell_s"], job["timing"]["t_pwm_s"])


def proposed(plant: DeltaPlant, ties: list[Tie]) -> Proposal:
    return next_experiment(plant.recorded.model, plant.own_noise.whitener, ties)


@dataclass(frozen=True)
class Case:
    """What is hidden, both explanations of it (the true one first), and a poor recording."""

    hidden: tuple[EffectEntry, ...]
    truth: list[tuple[str, str]]
    rival: list[tuple[str, str]]
    radius_m: float = 0.1
    turns: int = 1


RESOLVED = {
    "arm lag, motor azimuth": Case(
        (entry("following_lag", "motor2", time=0.03),),
        [("following_lag", "motor2")], [("motor_azimuth", "motor2")], radius_m=0.05,
    ),
    "home offset, forearm length": Case(
        (entry("home_offset", "motor2", angle=0.01),),
        [("home_offset", "motor2")], [("forearm_length", "arm2")],
    ),
    "z sensor offset, all home offsets": Case(
        (entry("sensor_offset", "range_z", offset=0.006),),
        [("sensor_offset", "range_z")], each("home_offset"), radius_m=0.01,
    ),
    "compliance, upper-arm lengths": Case(
        (entry("joint_compliance", "joints", stiffness=400.0),),
        [("joint_compliance", "joints")], each("upper_arm_length", "arm"), radius_m=0.01,
    ),
}  # fmt: skip


@pytest.mark.study
@pytest.mark.parametrize("case", RESOLVED.values(), ids=RESOLVED)
def test_the_proposed_run_settles_the_tie(
    bench: Any, circle: Callable[..., Motion], case: Case
) -> None:
    poor = bench.record(circle(turns=case.turns, radius=case.radius_m), *case.hidden)
    plant, tie = bench.tie([poor], case.truth, case.rival)
    assert abs(tie.delta_chi2) < TIED

    proposal = proposed(plant, [tie])
    plan = proposal.experiment
    assert plan is not None
    assert plan.expected_delta_chi2 >= EXPERIMENT.settles
    assert plan.minutes <= EXPERIMENT.longest_min
    assert set(plan.tells_apart) == {" ".join(name) for name in (*case.truth, *case.rival)}

    second = bench.record(driven(plan.job), *case.hidden, seed=2)
    _, both = bench.tie([poor, second], case.truth, case.rival)
    assert both.delta_chi2 > TIED
    assert both.delta_chi2 - tie.delta_chi2 > EXPERIMENT.settles


ONE_SIDED = {
    "play, friction": Case(
        (entry("gear_backlash", "motor2", width=0.012, drag=10.0),),
        [("gear_backlash", "motor2")], [("joint_friction", "motor2")],
    ),
    "late drives, late readings": Case(
        tuple(entry("following_lag", f"motor{m}", time=0.06) for m in (1, 2, 3)),
        each("following_lag"), [("sensor_latency", "sensors")],
    ),
}  # fmt: skip


@pytest.mark.parametrize("case", ONE_SIDED.values(), ids=ONE_SIDED)
def test_what_only_one_truth_would_show_is_said_with_the_measurement_that_helps(
    bench: Any, circle: Callable[..., Motion], case: Case
) -> None:
    poor = bench.record(circle(turns=case.turns), *case.hidden)
    plant, tie = bench.tie([poor], case.truth, case.rival)
    proposal = proposed(plant, [tie])
    assert proposal.experiment is not None
    assert proposal.experiment.expected_delta_chi2 >= EXPERIMENT.settles
    line = tie_line(*proposal.open)
    assert "both will still fit: then record the" in line

    second = bench.record(driven(proposal.experiment.job), *case.hidden, seed=2)
    _, both = bench.tie([poor, second], case.truth, case.rival)
    assert both.delta_chi2 > max(TIED, tie.delta_chi2)


def test_a_group_of_equal_causes_counts_as_its_members(
    bench: Any, circle: Callable[..., Motion]
) -> None:
    """The answer offers three equal lags as one rival, and they may be late readings exactly."""
    recording = bench.record(circle(turns=1), entry("sensor_latency", "sensors", time=0.06))
    late, lags = [("sensor_latency", "sensors")], [("following_lag", "motors")]
    _, tie = bench.tie([recording], late, lags)
    assert tie.names[1] == [f"following_lag motor{m}" for m in (1, 2, 3)]
    assert contains(tie.only_second, tie.only_first)
    assert not contains(tie.only_first, tie.only_second)


def test_no_motion_is_proposed_where_none_can_help(
    bench: Any, circle: Callable[..., Motion]
) -> None:
    """A wrong payload and yielding joints are the same everywhere."""
    poor = bench.record(circle(), entry("joint_compliance", "joints", stiffness=400.0))
    truth, rival = [("joint_compliance", "joints")], [("payload", "platform")]
    plant, tie = bench.tie([poor], truth, rival)
    proposal = proposed(plant, [tie])
    assert proposal.experiment is None
    line = tie_line(*proposal.open)
    assert line.startswith("No safe run, not even one of 8 min, can tell")
    assert "weigh the platform" in line


def test_without_a_tie_nothing_is_proposed(bench: Any, circle: Callable[..., Motion]) -> None:
    plant, _ = bench.tie([bench.record(circle())], [], [])
    assert proposed(plant, []).experiment is None
