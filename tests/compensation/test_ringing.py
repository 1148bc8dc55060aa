"""A platform on a spring: what the arms are told instead, and that they can follow it."""

from __future__ import annotations

import numpy as np
import pytest

from deltactl.drivers.steps.contract import Ticks
from deltactl.firmware_py.compensation.ringing import Ringing, knot_s
from deltactl.firmware_py.job_file import load_job
from deltactl.firmware_py.job_targets import kinematics_of
from deltactl.firmware_py.named_files import CONFIG_FOLDER
from deltactl.firmware_py.planner.plan import Plan, home_counts, make_plan
from deltactl.firmware_py.planner.stream import MotionStream
from deltactl.firmware_py.robot_file import RobotFile, load_robot
from deltactl.foundation.clock import NS_PER_S
from deltactl.models.chain import Chain, Commands
from deltactl.models.robot import EffectEntry, FloatArray

ZHAO = load_robot(CONFIG_FOLDER / "zhao-2023.yaml")
STEP_RAD = ZHAO.drive.rad_per_step
GRID_S = 0.001


def ringing(frequency_hz: float, damping: float, *others: EffectEntry) -> RobotFile:
    mode = {"frequency": frequency_hz, "damping": damping}
    entry = EffectEntry(effect="resonance", component="platform", parameters=mode)
    return ZHAO.model_copy(update={"effects": (*others, entry)})


def plan_of(job: str, robot: RobotFile) -> Plan:
    path = CONFIG_FOLDER / job
    asked = load_job(path)
    return make_plan(asked, robot, kinematics_of(asked, robot, path))


def streamed(plan: Plan) -> tuple[FloatArray, FloatArray, FloatArray, FloatArray]:
    """Counts on a fine grid (n, 3) and its times; targets and when they are due."""
    start = home_counts(plan.robot)
    chunks = list(MotionStream(plan, start))
    due_s = np.concatenate([chunk.ticks.due_ns for chunk in chunks]) / NS_PER_S
    assert (np.diff(due_s) > 0.0).all()
    steps = np.concatenate([chunk.ticks.steps for chunk in chunks])
    counts = np.vstack([start, start + np.cumsum(steps, axis=0, dtype=np.int64)])
    t_s = np.arange(0.0, due_s[-1] + 0.5, GRID_S)
    told = counts[np.searchsorted(due_s, t_s, side="right")]
    there = ~np.concatenate([chunk.reached.left for chunk in chunks])
    target_s = np.concatenate([chunk.reached.t_ns for chunk in chunks])[there] / NS_PER_S
    targets_m = np.concatenate([chunk.reached.position_m for chunk in chunks])[there]
    return t_s, told, target_s, targets_m


def off_m(robot: RobotFile, plan: Plan) -> float:
    """Distance from the targets, RMS, of the robot that believes what is true."""
    t_s, told, target_s, targets_m = streamed(plan)
    truth = Chain(ZHAO).simulate(Commands.of_angles(t_s, told * STEP_RAD), robot.effects)
    there = np.stack([np.interp(target_s, t_s, column) for column in truth.position.T], axis=1)
    return float(np.sqrt(np.mean(np.sum((there - targets_m) ** 2, axis=1))))


@pytest.mark.parametrize(("frequency_hz", "most"), [(1.7, 0.03), (2.4, 0.06), (6.0, 0.15)])
def test_the_heart_with_its_corners_hardly_rings(frequency_hz: float, most: float) -> None:
    robot = ringing(frequency_hz, 0.1)
    assert off_m(robot, plan_of("demo-heart.yaml", robot)) < most * off_m(
        robot, plan_of("demo-heart.yaml", ZHAO)
    )


@pytest.mark.parametrize(
    ("effect", "play"),
    [
        ("joint_friction", {"width": 0.008, "asymmetry": 0.2, "stiffness": 2000.0}),
        ("gear_backlash", {"width": 0.008, "drag": 1e4}),
    ],
)
def test_play_is_taken_up_where_the_arm_turns_round_that_keeps_the_platform_from_ringing(
    effect: str, play: dict[str, float]
) -> None:
    sticks = EffectEntry(effect=effect, component="motor2", parameters=play)
    robot = ringing(1.7, 0.1, sticks)
    plan = plan_of("demo-heart.yaml", robot)
    assert off_m(robot, plan) < 1.3e-4
    assert tuple(streamed(plan)[1][-1]) == plan.last_counts


@pytest.mark.parametrize("motor", ["motor1", "motor2", "motor3"])
def test_arms_that_hang_in_play_do_not_make_the_platform_ring(motor: str) -> None:
    play = {"width": 0.0105, "drag": 8.0, "friction": 0.2}
    robot = ringing(1.7, 0.1, EffectEntry(effect="gear_backlash", component=motor, parameters=play))
    plan = plan_of("demo-heart.yaml", robot)
    assert off_m(robot, plan) < 1.6e-4
    assert tuple(streamed(plan)[1][-1]) == plan.last_counts


def test_every_lap_of_hanging_arms_is_as_good_as_the_first() -> None:
    play = {"width": 0.0105, "drag": 8.0, "friction": 0.2}
    hangs = EffectEntry(effect="gear_backlash", component="motor2", parameters=play)
    path, robot = CONFIG_FOLDER / "demo-heart.yaml", ringing(3.0, 0.1, hangs)
    job = load_job(path).model_copy(update={"repeats": 3})
    plan = make_plan(job, robot, kinematics_of(job, robot, path))
    assert off_m(robot, plan) < 1.5e-4
    assert tuple(streamed(plan)[1][-1]) == plan.last_counts


def test_drives_are_told_no_more_than_they_can_follow_and_all_of_the_way() -> None:
    late = EffectEntry(effect="following_lag", component="motor3", parameters={"time": 0.05})
    robot = ringing(1.7, 0.1, late)
    plan = plan_of("demo-heart.yaml", robot)
    _, told, _, targets_m = streamed(plan)
    assert tuple(told[-1]) == plan.last_counts
    assert len(targets_m) == len(plan.first.lap)
    wide = np.ones(20) / 20.0  # over whole steps
    angle_rad = np.stack([np.convolve(column, wide, "valid") for column in told.T]) * STEP_RAD
    speed = (angle_rad[:, 20:] - angle_rad[:, :-20]) / (20 * GRID_S)
    change = (speed[:, 20:] - speed[:, :-20]) / (20 * GRID_S)
    assert np.abs(speed).max() < robot.limits.joint_speed_radps
    whole_steps = STEP_RAD / (20 * GRID_S) ** 2
    assert np.abs(change).max() < robot.limits.joint_acceleration_radps2 + whole_steps


def test_a_survey_is_made_as_it_is_given() -> None:
    late = EffectEntry(effect="following_lag", component="motor3", parameters={"time": 0.05})
    as_given, ringing_too = (
        MotionStream(plan_of("survey.yaml", robot), home_counts(robot))
        for robot in (ZHAO, ringing(2.0, 0.1, late))
    )
    duration_ns = [one.end_ns - one.path_start_ns for one in (as_given, ringing_too)]
    assert duration_ns[0] == duration_ns[1]
    assert ringing_too.path_start_ns == ringing_too.approach.duration_ns


def test_what_drives_cannot_follow_is_not_tried() -> None:
    t_s = np.arange(0.0, 4.0, 0.05)
    angle_rad = np.stack([0.6 + 0.4 * np.abs((t_s % 2.0) - 1.0)] * 3, axis=1)
    place_m = np.stack([np.zeros_like(t_s), np.zeros_like(t_s), -0.4 - 0.1 * angle_rad[:, 0]], 1)
    knots = [knot_s(ringing(hz, 0.1), t_s, angle_rad, place_m) for hz in (0.4, 2.0, 8.0)]
    assert knots[0] == 0.0
    assert knots[1] > knots[2] > 0.0


def test_the_pieces_in_which_a_motion_comes_do_not_matter() -> None:
    robot, start = ringing(3.0, 0.05), home_counts(ZHAO)
    rng = np.random.default_rng(1)
    due_ns = np.cumsum(rng.integers(1_000_000, 6_000_000, 400))
    ticks = Ticks(due_ns, rng.integers(-1, 2, (400, 3)).astype(np.int8))
    end_ns = int(due_ns[-1])
    whole = Ringing(robot, 0.05, start).counts(ticks, end_ns)
    pieces, in_pieces, first = [], Ringing(robot, 0.05, start), 0
    for until_ns in (300_000_000, 310_000_000, 900_000_000, end_ns):
        last = int(np.searchsorted(due_ns, until_ns, side="right"))
        piece = Ticks(ticks.due_ns[first:last], ticks.steps[first:last])
        pieces.append(in_pieces.counts(piece, until_ns))
        first = last
    np.testing.assert_allclose(np.concatenate(pieces), whole, atol=1e-5)


def test_an_arm_with_play_is_where_it_is_and_not_where_its_motor_is() -> None:
    play = {"width": 0.01, "drag": 1e4}
    loose = EffectEntry(effect="gear_backlash", component="motor1", parameters=play)
    inside = round(0.8 * play["width"] / STEP_RAD)
    # The motor turns back within the play: nothing moves, so there is nothing to ring.
    steps = np.zeros((500 + inside, 3), dtype=np.int8)
    steps[:200, 0], steps[-inside:, 0] = 1, -1
    due_ns = (np.arange(len(steps)) + 500) * 2_000_000
    bent = []
    for robot in (ringing(3.0, 0.1, loose), ringing(3.0, 0.1)):
        told = Ringing(robot, 0.03, home_counts(ZHAO)).counts(Ticks(due_ns, steps), due_ns[-1])
        turning = slice(1900, 2060)
        bent.append(np.abs(np.diff(told[turning, 0], 2)).max())
    # What is left is the motor's own corner, smoothed.
    assert bent[0] < 0.2 * bent[1]
