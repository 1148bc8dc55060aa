"""Play and growth: the believed chain does what was meant when it is told what is worked out."""

from __future__ import annotations

import numpy as np
import pytest

from deltactl.firmware_py.compensation.remembering import Course, Remembering
from deltactl.firmware_py.job_file import JobFile, load_job
from deltactl.firmware_py.job_targets import kinematics_of
from deltactl.firmware_py.named_files import CONFIG_FOLDER
from deltactl.firmware_py.planner.plan import Plan, home_counts, make_plan
from deltactl.firmware_py.planner.stream import MotionStream
from deltactl.firmware_py.robot_file import RobotFile, load_robot
from deltactl.firmware_py.simulation.world import SimulatedRobot
from deltactl.foundation.clock import NS_PER_S
from deltactl.models.chain import Chain, Commands
from deltactl.models.robot import EffectEntry, FloatArray

ZHAO = load_robot(CONFIG_FOLDER / "zhao-2023.yaml")
TOGETHER = {"mode": "together", "t_pwm_s": 0.002}
ACCELERATED = {"mode": "accelerated", "speed_mps": 0.06}
CIRCLE = {"shape": "circle", "centre_m": (0.0, 0.0, -0.45), "radius_m": 0.06, "spacing_m": 0.0005}
STEP_RAD = ZHAO.drive.rad_per_step


def with_effects(*effects: tuple[str, str, dict[str, float]]) -> RobotFile:
    entries = [EffectEntry(effect=e, component=c, parameters=p) for e, c, p in effects]
    return ZHAO.model_copy(update={"effects": tuple(entries)})


def plan_for(robot: RobotFile, timing: dict[str, object], repeats: int = 1) -> Plan:
    job = JobFile.model_validate(
        {
            "name": "circle",
            "robot": "zhao-2023.yaml",
            "path": CIRCLE,
            "timing": timing,
            "inverse_kinematics": {"kind": "geometry"},
            "repeats": repeats,
        }
    )
    return make_plan(job, robot, kinematics_of(job, robot, None))


def run(robot: RobotFile, plan: Plan) -> tuple[FloatArray, FloatArray, FloatArray]:
    """Times [s] on a fine grid, counts there, and errors at the targets [m], (k,)."""
    start = home_counts(robot)
    due, steps, reached_ns, targets = [], [], [], []
    for chunk in MotionStream(plan, start):
        due.append(chunk.ticks.due_ns)
        steps.append(chunk.ticks.steps)
        mine = (chunk.reached.number >= 0) & ~chunk.reached.left
        reached_ns.append(chunk.reached.t_ns[mine])
        targets.append(chunk.reached.position_m[mine])
    due_s = np.concatenate(due) / NS_PER_S
    assert (np.diff(due_s) > 0.0).all()
    counts = np.array(start) + np.cumsum(np.concatenate(steps), axis=0, dtype=np.int64)
    times_s = np.arange(0.0, due_s[-1] + 0.5, 0.001)
    row = np.searchsorted(due_s, times_s, side="right") - 1
    told = np.where(row[:, None] >= 0, counts[np.maximum(row, 0)], start)
    truth = Chain(ZHAO).simulate(Commands.of_angles(times_s, told * STEP_RAD), robot.effects)
    at_s = np.concatenate(reached_ns) / NS_PER_S
    there = np.stack([np.interp(at_s, times_s, column) for column in truth.position.T], axis=1)
    return times_s, told, np.linalg.norm(there - np.concatenate(targets), axis=1)


CASES = [
    ("joint_friction", "motor1", {"width": 0.008, "asymmetry": 0.2}),
    ("gear_backlash", "motor2", {"width": 0.008, "drag": 1e4}),
    ("gear_backlash", "motor2", {"width": 0.008, "drag": 8.0, "friction": 0.2}),
    ("thermal_expansion", "arms", {"strain": 0.008, "time_constant": 20.0}),
    ("following_lag", "motor3", {"time": 0.1, "dead_time": 0.04}),
    ("viscous_friction", "motor1", {"coefficient": 60.0, "stiffness": 1000.0}),
    ("resonance", "platform", {"frequency": 2.5, "damping": 0.08}),
]


@pytest.mark.parametrize(
    ("effect", "timing"),
    [
        *((case, TOGETHER) for case in CASES),
        *((case, ACCELERATED) for case in (CASES[0], CASES[-1])),
        *(pytest.param(case, ACCELERATED, marks=pytest.mark.study) for case in CASES[1:-1]),
    ],
)
def test_what_remembers_is_compensated(
    effect: tuple[str, str, dict[str, float]], timing: dict[str, object]
) -> None:
    robot = with_effects(effect)
    nothing_known = plan_for(ZHAO, timing)
    _, _, before = run(robot.model_copy(update={"effects": robot.effects}), nothing_known)
    _, _, after = run(robot, plan_for(robot, timing))
    rms = [float(np.sqrt(np.mean(error**2))) for error in (before, after)]
    # An arm that falls through its play falls no faster than its drag lets it.
    left = 0.45 if effect[2].get("drag", 1e4) < 1e3 else 0.35
    assert rms[1] < max(left * rms[0], 1.2e-4), rms


def test_an_arm_that_turns_round_at_once_is_pushed_the_way_it_goes_on() -> None:
    width_rad = 0.008
    robot = with_effects(("joint_friction", "motor1", {"width": width_rad}))
    path = CONFIG_FOLDER / "demo-heart.yaml"  # arm 1 rises by a third of a step, then falls
    job = load_job(path)
    _, _, error_m = run(robot, make_plan(job, robot, kinematics_of(job, robot, path)))
    elbow_m = width_rad * float(robot.geometry.upper_arm_m)
    assert error_m[:20].max() < 0.5 * elbow_m


def test_an_arm_that_falls_about_as_fast_as_it_is_to_move_does_not_rattle() -> None:
    play = {"width": 0.0076, "drag": 12.4}
    robot = with_effects(("gear_backlash", "motor1", play))
    path = CONFIG_FOLDER / "demo-heart.yaml"
    job = load_job(path)
    untreated, plan = (make_plan(job, one, kinematics_of(job, one, path)) for one in (ZHAO, robot))
    ahead = plan.first.lap.angles_rad[:, 0] - untreated.first.lap.angles_rad[:, 0]
    flank = np.sign(ahead[np.abs(ahead) > 0.4 * play["width"]])
    assert 1 <= np.count_nonzero(np.diff(flank)) <= 4
    _, _, error_m = run(robot, plan)
    assert float(np.sqrt(np.mean(error_m**2))) < 1.5e-4


@pytest.mark.parametrize(
    ("motor", "drag", "most_m"),
    [
        ("motor1", 8.0, 3.0e-4),
        ("motor1", 10.0, 6.0e-4),
        ("motor2", 8.0, 1.0e-3),
        ("motor2", 12.0, 1.0e-3),
        ("motor3", 8.0, 3.0e-4),
    ],
)
def test_a_gear_crosses_its_play_while_the_arm_falls_as_fast_as_it_is_to_move(
    motor: str, drag: float, most_m: float
) -> None:
    """Also at a corner, where the path is as fast as motors step, and from the first step on."""
    play = {"width": 0.0105, "drag": drag, "friction": 0.2}
    robot = with_effects(("gear_backlash", motor, play))
    path = CONFIG_FOLDER / "demo-heart.yaml"
    job = load_job(path)
    _, _, error_m = run(robot, make_plan(job, robot, kinematics_of(job, robot, path)))
    assert float(np.sqrt(np.mean(error_m**2))) < 0.9e-4
    assert error_m.max() < most_m


def test_how_far_a_stopped_arm_swings_on_does_not_make_a_moving_one_rattle() -> None:
    friction = {"width": 0.0088}
    told = [
        plan_for(with_effects(("joint_friction", "motor1", known)), TOGETHER).first.lap.counts
        for known in (friction, {**friction, "overshoot": 0.009})
    ]
    np.testing.assert_array_equal(*told)


def test_a_simulated_arm_on_a_soft_shaft_does_not_swing_at_every_step() -> None:
    friction = ("joint_friction", "motor1", {"width": 0.0088, "overshoot": 0.009})
    robot = with_effects(friction)
    step_ns, steps = 6_000_000, 100
    world = SimulatedRobot(robot, lambda t_ns: (t_ns // step_ns, 0, 0), lambda: 0)
    before, after = (world.truth(count * step_ns).angles_rad[0] for count in (0, steps))
    assert after - before == pytest.approx(steps * STEP_RAD - 0.0044, abs=2.0 * STEP_RAD)


@pytest.mark.parametrize(
    "play",
    [
        ("joint_friction", "motor1", {"width": 0.01}),
        ("gear_backlash", "motor1", {"width": 0.01, "drag": 20.0}),
    ],
)
def test_limits_of_speed_are_kept_while_play_is_taken_up(
    play: tuple[str, str, dict[str, float]],
) -> None:
    robot = with_effects(play)
    plan = plan_for(robot, ACCELERATED)
    times_s, told, _ = run(robot, plan)
    apart = 0.02
    row = round(apart / float(times_s[1] - times_s[0]))
    fastest = np.abs(told[row:] - told[:-row]).max() * STEP_RAD / apart
    assert fastest <= robot.limits.joint_speed_radps
    assert plan.first.schedule.peak_rate_hz.max() <= robot.limits.step_rate_hz


def test_every_lap_begins_where_the_one_before_ended() -> None:
    robot = with_effects(("joint_friction", "motor1", {"width": 0.008}))
    plan = plan_for(robot, TOGETHER, repeats=3)
    assert plan.again is not None
    np.testing.assert_array_equal(plan.again.lap.counts[0], plan.first.lap.counts[-1])
    np.testing.assert_array_equal(plan.again.lap.counts[-1], plan.again.lap.counts[0])
    _, told, error = run(robot, plan)
    assert tuple(told[-1]) == plan.last_counts
    assert float(np.sqrt(np.mean(error**2))) < 2e-4


def test_nothing_known_is_nothing_done() -> None:
    assert not Remembering(ZHAO).active
    plan = plan_for(ZHAO, TOGETHER)
    assert plan.first.lap.mapped is None
    assert plan.preload_rad is None
    angles = np.full((5, 3), 0.5)
    kept = Remembering(ZHAO).angles_rad(Course(np.arange(5.0), angles))
    np.testing.assert_array_equal(kept, angles)
