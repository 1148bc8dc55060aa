"""Each effect of the second robot against a calculation by hand."""

from __future__ import annotations

import numpy as np
import pytest

pytest.importorskip("mujoco", reason="the proof's robot needs the extra 'proof' (MuJoCo)")

from deltactl.proof.hidden.vocabulary import SINGLES, VOCABULARY, Planned, construct, heights_m
from deltactl.proof.motions import survey
from deltactl.proof.ranging import Noise, ideal_ranges, read
from deltactl.proof.recorded import Machine
from deltactl.proof.robot.as_built import AsBuilt, Body, Joints, StepTrain, three, together
from deltactl.proof.robot.bodies import Assembly, build
from deltactl.proof.robot.run import run

RAD_PER_STEP = Joints().rad_per_step
SAG_M = 7e-5
"""What gravity bends in joints of 20 000 N m/rad, at the platform."""
HOME = np.array([1400, 1400, 1400])
FAR = np.array([300, 0, 0])
ASKEW = HOME + np.array([300, -200, 100])
G = 9.81
SILENT = Noise(0.0, 0.0, 0.0, 0.0)


def motion(*targets, dwell_s=0.2, t_pwm_s=0.001) -> StepTrain:
    goals = np.array(targets)
    return together(HOME, goals, np.full(len(goals), dwell_s), t_pwm_s)


def machine_with(effect, index=0, **parameters) -> Machine:
    machine = Machine(noise=SILENT)
    kind = VOCABULARY[effect]
    construct(machine, [Planned(kind, index, parameters)], with_events=True)
    return machine


def rest_angles(machine: Machine, *targets) -> np.ndarray:
    """Arm angles at the end of the last dwell, (3,); slow, for a fast arm glides in its play."""
    return run(machine.robot, motion(*targets, t_pwm_s=0.004)).arm_rad[-1]


def test_home_offset_turns_the_arm_down():
    angle = rest_angles(machine_with("home_offset", 1, angle=0.02), HOME)
    assert angle - HOME * RAD_PER_STEP == pytest.approx([0.0, 0.02, 0.0], abs=1.5e-4)


def test_gear_ratio_scales_the_angle():
    angle = rest_angles(machine_with("gear_ratio", 2, scale=1.02), HOME)
    assert angle[2] == pytest.approx(1.02 * HOME[2] * RAD_PER_STEP, abs=1.5e-4)


def test_transmission_error_is_a_sine_of_the_angle():
    machine = machine_with("transmission_error", 0, amplitude=0.01, period=0.6, phase=0.3)
    asked = HOME[0] * RAD_PER_STEP
    expected = asked + 0.01 * np.sin(2 * np.pi / 0.6 * asked + 0.3)
    assert rest_angles(machine, HOME)[0] == pytest.approx(expected, abs=1.5e-4)


@pytest.mark.parametrize(
    ("effect", "parameters"),
    [
        ("gear_backlash", {"width": 0.012, "friction": 2.5, "drag": 0.3}),
        ("joint_friction", {"width": 0.012}),
    ],
)
def test_play_and_wind_up_differ_between_directions_by_their_width(effect, parameters):
    machine = machine_with(effect, 0, **parameters)
    offs = []
    for start in (HOME - FAR, HOME + FAR):
        train = motion(start, HOME, dwell_s=0.1, t_pwm_s=0.004)
        truth = run(machine.robot, train)
        # Just before it stops: at the stop the arm glides on a little.
        at = np.searchsorted(truth.t_s, train.seconds - 0.15)
        asked = train.smooth(truth.t_s[[at]])[0] * RAD_PER_STEP
        offs.append(truth.arm_rad[at, 0] - asked[0])
    assert offs[1] - offs[0] == pytest.approx(parameters["width"], rel=0.02)


def test_free_play_without_friction_hangs_on_one_flank():
    machine = Machine()
    machine.robot.joints.play_rad[0] = 0.012
    angles = [
        rest_angles(machine, HOME + turn, HOME)[0] - HOME[0] * RAD_PER_STEP for turn in (-FAR, FAR)
    ]
    assert angles == pytest.approx([0.006, 0.006], abs=3e-4)


def joint_load_nm(angle_rad: float, body: Body) -> float:
    """Gravity's torque on each joint at a pose with all arms alike, from the energy's slope."""
    radius = body.base_radius_m[0] - body.platform_radius_m[0]
    upper, fore = body.upper_arm_m[0], body.forearm_m[0]

    def energy(q):
        knee_z, out = -upper * np.sin(q), radius + upper * np.cos(q)
        platform_z = knee_z - np.sqrt(fore**2 - out**2)
        rods = 3 * body.forearm_kg * 0.5 * (knee_z + platform_z)
        arms = 3 * body.upper_arm_kg * 0.5 * knee_z
        return G * ((body.platform_kg + body.payload_kg) * platform_z + rods + arms)

    return float(-(energy(angle_rad + 1e-5) - energy(angle_rad - 1e-5)) / 2e-5 / 3.0)


@pytest.mark.parametrize("payload_kg", [0.0, 1.0])
def test_compliance_yields_by_torque_over_stiffness(payload_kg):
    machine = machine_with("joint_compliance", 0, stiffness=300.0)
    machine.robot.body.payload_kg = payload_kg
    machine.robot.joints.friction_nm = three(0.0)
    sag = rest_angles(machine, HOME) - HOME * RAD_PER_STEP
    load = joint_load_nm(float(HOME[0] * RAD_PER_STEP + sag[0]), machine.robot.body)
    assert sag == pytest.approx(three(load / 300.0), rel=0.02)


def test_following_lag_and_viscous_friction_lag_alike():
    train = motion(HOME + 3 * FAR)
    nominal = run(AsBuilt(), train)
    at = np.searchsorted(nominal.t_s, 0.8)
    speed = RAD_PER_STEP / 0.001
    lagging = machine_with("following_lag", 0, time=0.08, dead_time=0.04)
    late = run(lagging.robot, train)
    assert nominal.arm_rad[at, 0] - late.arm_rad[at, 0] == pytest.approx(0.12 * speed, rel=0.01)
    sticky = run(machine_with("viscous_friction", 0, coefficient=100.0).robot, train)
    assert nominal.arm_rad[at, 0] - sticky.arm_rad[at, 0] == pytest.approx(
        100.0 / 2000.0 * speed, rel=0.05
    )


def test_lost_steps_leave_the_arm_short():
    angles = rest_angles(machine_with("lost_steps", 0, steps=80, time=0.05), HOME)
    assert angles[0] - HOME[0] * RAD_PER_STEP == pytest.approx(-80 * RAD_PER_STEP, abs=1.5e-4)


@pytest.mark.parametrize(
    ("effect", "index", "parameters"),
    [
        ("upper_arm_length", 0, {"length_error": 0.003}),
        ("forearm_length", 1, {"length_error": -0.004}),
        ("base_radius", 0, {"length_error": 0.004}),
        ("motor_azimuth", 2, {"angle": 0.02}),
    ],
)
def test_lengths_and_directions_move_the_platform_as_rigid_bodies_do(effect, index, parameters):
    machine = machine_with(effect, index, **parameters)
    truth = run(machine.robot, motion(ASKEW))
    wrong = Assembly(build(machine.robot.body, Joints(), 0.001))
    right = Assembly(build(Body(), Joints(), 0.001))
    angles = ASKEW * RAD_PER_STEP
    moved = wrong.platform_m(angles)
    assert truth.position_m[-1] == pytest.approx(moved, abs=SAG_M)
    assert np.linalg.norm(moved - right.platform_m(angles)) > 4e-4


def test_upper_arms_grow():
    machine = machine_with("thermal_expansion", 0, strain=0.01, time_constant=0.5)
    truth = run(machine.robot, motion(HOME, dwell_s=1.5))
    grown = Body(upper_arm_m=three(0.25 * (1.0 - 0.01 * np.expm1(-1.4 / 0.5))))
    expected = Assembly(build(grown, Joints(), 0.001)).platform_m(HOME * RAD_PER_STEP)
    assert truth.position_m[-1] == pytest.approx(expected, abs=1e-4)


def test_above_the_table_a_robot_moves_as_without_one():
    """What gives way where it presses must not give way in free motion."""
    train = motion(HOME + 3 * FAR, HOME - 2 * FAR, HOME, dwell_s=0.05)
    plain = run(Machine(noise=SILENT).robot, train)
    above = run(machine_with("contact", 0, height=-1.5).robot, train)
    apart_m = np.linalg.norm(above.position_m - plain.position_m, axis=1)
    assert np.median(apart_m) < 3e-5
    assert apart_m.max() < 2e-4  # for a moment, where it starts and stops


@pytest.mark.parametrize("seed", range(3))
def test_the_heights_of_a_survey_are_all_below_the_motors(seed):
    """However far apart two looks are, no look finds the robot put together the other way up."""
    heights = heights_m(survey(np.random.default_rng(seed), 240.0, 0.001))
    assert heights.max() < 0.0
    assert heights.min() == pytest.approx(-0.6, abs=0.02)


def test_a_table_stops_the_platform():
    train = motion(HOME + 800)
    low = heights_m(train).min()
    truth = run(machine_with("contact", 0, height=low + 0.02).robot, train)
    assert truth.position_m[:, 2].min() == pytest.approx(low + 0.02, abs=2e-4)


def test_ringing_has_its_frequency():
    train = motion(HOME + 200, dwell_s=3.0)
    truth = run(machine_with("resonance", 0, frequency=3.0, damping=0.05).robot, train)
    after = truth.position_m[truth.t_s > 0.3, 2]
    spectrum = np.abs(np.fft.rfft((after - after.mean()) * np.hanning(len(after)), 8192))
    assert np.fft.rfftfreq(8192, 0.005)[np.argmax(spectrum)] == pytest.approx(3.0, abs=0.1)


SENSOR_EFFECTS = {
    "sensor_offset": ({"offset": 0.01}, lambda r, t: 0.01 + 0 * t),
    "sensor_scale": ({"scale": 1.02}, lambda r, t: 0.02 * r),
    "sensor_crosstalk": ({"curvature": 0.03}, lambda r, t: 0.03 * r**2),
    "sensor_drift": (
        {"offset": 0.01, "time_constant": 0.5}, lambda r, t: 0.01 * (1.0 - np.exp(-t / 0.5)),
    ),
}  # fmt: skip


@pytest.mark.parametrize("effect", sorted(SENSOR_EFFECTS))
def test_sensor_errors(effect):
    parameters, error = SENSOR_EFFECTS[effect]
    machine = machine_with(effect, 1, **parameters)
    truth = run(machine.robot, motion(HOME + 200))
    t_s = np.arange(0.04, truth.t_s[-1] - 0.04, 0.02)
    right = ideal_ranges(Machine().sensors, truth, t_s)
    wrong = ideal_ranges(machine.sensors, truth, t_s)
    off = wrong - right
    assert off[:, [0, 2]] == pytest.approx(0.0, abs=1e-12)
    assert off[:, 1] == pytest.approx(error(right[:, 1], t_s), abs=2e-5)


def test_late_tilted_and_stuck_readings():
    truth = run(AsBuilt(), motion(HOME + 600))
    t_s = np.arange(0.1, truth.t_s[-1] - 0.04, 0.02)
    right = ideal_ranges(Machine().sensors, truth, t_s)
    late = ideal_ranges(machine_with("sensor_latency", 0, time=0.04).sensors, truth, t_s)
    assert late[2:] == pytest.approx(right[:-2], abs=1e-9)
    turned = machine_with("frame_tilt", 0, rotation=[0.0, 0.0, 0.01]).sensors
    # Turned about z by a little: x loses y times the angle.
    height = right[:, 2] - 0.9
    assert ideal_ranges(turned, truth, t_s)[:, 2] - 0.9 == pytest.approx(height, abs=1e-9)
    tipped = machine_with("frame_tilt", 0, rotation=[0.01, 0.0, 0.0]).sensors
    assert (ideal_ranges(tipped, truth, t_s) - right)[:, 1] == pytest.approx(
        -0.01 * height, abs=5e-5
    )
    stuck = machine_with("stale_reading", 2, time=0.3, duration=0.2).sensors
    ranges, status = read(stuck, SILENT, truth, t_s, np.random.default_rng(0))
    during = (t_s >= 0.3) & (t_s < 0.5)
    assert len(set(ranges[during, 2])) == 1
    assert len(set(ranges[~during, 2])) > 3
    assert not status.any()


def test_every_effect_of_the_vocabulary_can_be_drawn():
    rng = np.random.default_rng(0)
    for name in SINGLES:
        kind = VOCABULARY[name]
        assert kind.main in kind.draw(rng, 1.0) or kind.main in kind.units
