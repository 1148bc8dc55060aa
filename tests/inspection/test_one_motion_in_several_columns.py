"""Logs in which several columns hold one motion: steps beside a command, a second encoder, an error
of the reading, a speed whose unit tells how an encoder counts.
"""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from deltactl.recording.foreign.inspection import Inspection, inspect
from deltactl.recording.foreign.mapping import load_mapping

T_S = 0.01 * np.arange(2000)
RNG = np.random.default_rng(7)
ASKED = 40.0 * np.sin(0.9 * T_S) + 9.0 * np.sin(3.1 * T_S)
READ = 1.01 * ASKED + 0.02 * RNG.standard_normal(len(T_S))
SPEED = np.gradient(READ, T_S)
EFFORT = 0.4 * np.sign(SPEED) + 1e-3 * np.gradient(np.gradient(ASKED, T_S), T_S)


def seen(folder: Path, **columns: np.ndarray) -> Inspection:
    path = folder / "log.csv"
    head = ",".join(columns)
    np.savetxt(path, np.stack([*columns.values()], 1), "%.6f", ",", header=head, comments="")
    return inspect(path)


def taken(found: Inspection) -> dict[str, str]:
    return {guess.name: guess.source for guess in found.guesses.values()}


@pytest.mark.parametrize("scale", ["glass_scale_x", "laser_x", "enc_x"])
@pytest.mark.parametrize("counter", ["mcu_position_x", "x_steps"])
def test_steps_of_a_command_beside_a_scale(tmp_path: Path, scale: str, counter: str) -> None:
    columns = {"time": T_S, "toolhead_x": ASKED, counter: np.round(80.0 * ASKED), scale: READ}
    found = seen(tmp_path, **columns)
    assert found.kind == "servo_axis"
    assert taken(found)["command"] == "toolhead_x"
    assert taken(found)["position"] == scale
    assert "toolhead_x" in found.unused(counter)


def test_steps_are_the_command_where_nothing_else_is(tmp_path: Path) -> None:
    found = seen(tmp_path, time=T_S, steps=np.round(80.0 * ASKED), angle_deg=READ)
    assert found.kind == "stepper_axis"


def test_what_goes_into_a_controller_is_its_command(tmp_path: Path) -> None:
    """A constant offset puts neither column ahead of the other."""
    found = seen(tmp_path, time=T_S, input_pos=ASKED / 9, pos_estimate=READ / 9 + 1, Iq=EFFORT)
    assert taken(found)["command"] == "input_pos"
    assert taken(found)["position"] == "pos_estimate"
    assert taken(found)["effort"] == "Iq"


def test_a_second_encoder_is_named(tmp_path: Path) -> None:
    own = ASKED + 0.02 * RNG.standard_normal(len(T_S))
    found = seen(tmp_path, time=T_S, motor_angle_deg=own, arm_angle_deg=READ, torque_Nm=EFFORT)
    (said,) = (one for one in found.warnings if one.startswith("arm_angle_deg:"))
    assert "--set command=motor_angle_deg --set position=arm_angle_deg" in said


def test_an_error_is_no_reading(tmp_path: Path) -> None:
    places, error = np.arange(0.0, 361.0, 10.0), 20.0 * np.sin(np.arange(37))
    found = seen(tmp_path, nominal_deg=places, deviation_arcsec=error)
    assert found.kind is None
    assert "position=deviation" not in found.kind_why
    assert "nominal_deg plus deviation_arcsec" in found.kind_why


@pytest.mark.parametrize("counts", [1024, 2000, 2048, 4000, 8192, 10000])
def test_a_speed_tells_how_an_encoder_counts(tmp_path: Path, counts: int) -> None:
    demand, actual = (np.round(counts / 20.0 * one) for one in (ASKED, READ))
    rpm = np.round(60.0 / 20.0 * np.gradient(1.01 * ASKED, T_S))
    found = seen(tmp_path, time=T_S, demand_inc=demand, actual_inc=actual, velocity_rpm=rpm)
    sizes = [one.scale for one in found.guesses.values() if one.role in ("command", "position")]
    assert sizes == pytest.approx([2.0 * np.pi / counts] * 2, rel=1e-3)
    assert taken(found)["velocity"] == "velocity_rpm"


def test_speeds_are_no_further_joints(tmp_path: Path) -> None:
    names = [f"{one}.{of}0" for one in ("desired", "actual") for of in ("positions", "velocities")]
    values = (ASKED, np.gradient(ASKED, T_S), READ, SPEED)
    found = seen(tmp_path, time=T_S, **dict(zip(names, values, strict=True)))
    assert not any("more joints" in one for one in found.warnings)
    assert taken(found)["velocity"] == "actual.velocities0"


def test_drift_of_a_star_is_no_distance(tmp_path: Path) -> None:
    drift = 4.0 * np.sin(T_S) + 0.3 * RNG.standard_normal(len(T_S))
    mass = 2e4 + 1e3 * RNG.random(len(T_S))
    found = seen(tmp_path, Time=T_S, dx=drift, RARawDistance=drift, StarMass=mass, SNR=mass / 900)
    assert found.kind is None
    assert "StarMass" not in taken(found).values()


def test_three_servos_are_looked_at_one_by_one(tmp_path: Path) -> None:
    asked = [ASKED, 20.0 * np.sin(1.3 * T_S), 15.0 * np.cos(0.7 * T_S)]
    columns = {"time": T_S}
    for n, one in enumerate(asked, 1):
        columns[f"servo{n}_goal_position_deg"] = one
        loose = 0.5 * np.sign(np.gradient(one)) * (n == 2)
        columns[f"servo{n}_present_position_deg"] = one - loose + 0.01 * RNG.standard_normal(2000)
    found = seen(tmp_path, **columns)
    (said,) = (one for one in found.warnings if "--set" in one)
    option = said.rpartition("--set ")[2]
    assert option == "position=servo2_present_position_deg"
    one = inspect(found.path, load_mapping(None, [option]))
    assert one.kind == "servo_axis"
    assert taken(one)["command"] == "servo2_goal_position_deg"


@pytest.mark.parametrize(
    ("goal", "present"), [("leader_{}", "follower_{}"), ("{}_goal", "{}_present")]
)
def test_of_an_arm_the_joint_that_departs_is_shown(tmp_path: Path, goal: str, present: str) -> None:
    names = ["shoulder_pan", "shoulder_lift", "elbow_flex", "wrist_roll"]
    asked = {name: 30.0 * np.sin((0.5 + 0.3 * n) * T_S) for n, name in enumerate(names)}
    noise = 0.05 * RNG.standard_normal((len(names), len(T_S)))
    columns = {"t": T_S} | {goal.format(name): one for name, one in asked.items()}
    for row, name in zip(noise, names, strict=True):
        columns[present.format(name)] = asked[name] + row + 1.5 * (name == "elbow_flex")
    found = seen(tmp_path, **columns)
    assert taken(found)["command"] == goal.format("elbow_flex")
    assert taken(found)["position"] == present.format("elbow_flex")


def test_short_names_of_a_controller(tmp_path: Path) -> None:
    speed = np.gradient(ASKED, T_S)
    found = seen(tmp_path, t=T_S, pos=READ, vel=SPEED, tq=EFFORT, ctrl_pos=ASKED, ctrl_vel=speed)
    right = {"command": "ctrl_pos", "position": "pos", "velocity": "vel", "effort": "tq"}
    assert right.items() <= taken(found).items()


def test_joints_called_before_the_dot_are_joints(tmp_path: Path) -> None:
    """Three of them are numbered, and no motors of a delta."""
    joints = ["shoulder_joint", "elbow_joint", "wrist_1_joint", "wrist_2_joint", "wrist_3_joint"]
    asked = {one: 0.4 * np.sin((0.5 + 0.2 * n) * T_S) for n, one in enumerate(joints)}
    noise = 1e-4 * RNG.standard_normal((len(joints), len(T_S)))
    columns = {"time": T_S} | {f"{one}.desired": values for one, values in asked.items()}
    for row, one in zip(noise, joints, strict=True):
        columns[f"{one}.actual"] = asked[one] + row + 0.03 * (one == "wrist_2_joint")
    found = seen(tmp_path, **columns)
    assert found.kind == "servo_axis"
    assert taken(found)["position"] == "wrist_2_joint.actual"


def test_a_speed_tells_whole_times_in_ms(tmp_path: Path) -> None:
    ms = np.arange(len(T_S), dtype=float)
    columns = {
        "duration": ms,
        "q": READ / 57,
        "q_d": ASKED / 57,
        "dq": np.gradient(READ / 57, 1e-3),
    }
    found = seen(tmp_path, **columns)
    assert found.guesses["duration"].unit == "ms"
    assert taken(found)["velocity"] == "dq"


def test_counts_of_an_encoder_beside_a_setpoint_with_decimals(tmp_path: Path) -> None:
    found = seen(tmp_path, t=T_S, pos_setpoint=200.5 * ASKED, shadow_count=np.round(200.5 * READ))
    assert taken(found)["position"] == "shadow_count"
    assert found.asked is None
    assert any("encoder counts" in one for one in found.warnings)


def test_a_unit_says_more_than_a_letter(tmp_path: Path) -> None:
    """q is an angle in the books, and the axis of a motor's current in its logs."""
    columns = {"q_A": 3.0 * EFFORT, "d_A": RNG.standard_normal(len(T_S)), "position": READ / 90}
    found = seen(tmp_path, time=T_S, **columns)
    assert taken(found)["position"] == "position"
    assert taken(found)["effort"] == "q_A"


def test_the_load_that_a_servo_reports_is_its_own(tmp_path: Path) -> None:
    voltage = 7.4 + 0.05 * RNG.standard_normal(len(T_S))
    columns = {
        "target": ASKED,
        "position": READ,
        "load": np.round(100 * EFFORT),
        "voltage": voltage,
    }
    found = seen(tmp_path, ms=1e3 * T_S, **columns)
    assert taken(found)["effort"] == "load"
    assert "load" not in taken(found)


def test_a_load_that_does_not_go_with_the_motion_pulls_from_outside(tmp_path: Path) -> None:
    pull = np.round(40.0 * (np.sin(0.21 * T_S) > 0.3) * (np.abs(SPEED) < 5.0))
    found = seen(tmp_path, t=T_S, command=ASKED / 60, position=READ / 60, load=pull)
    assert taken(found)["load"] == "load"
