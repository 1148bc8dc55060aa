"""A delta as URDF and as MJCF: what other programs read from them is the robot of the file."""

from __future__ import annotations

import math
import xml.etree.ElementTree as ET
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from deltactl.firmware_py.exporting.links import joints_of, places
from deltactl.firmware_py.exporting.mjcf import HOME, mjcf_text
from deltactl.firmware_py.exporting.ros2 import turn
from deltactl.firmware_py.exporting.urdf import urdf_text
from deltactl.firmware_py.named_files import CONFIG_FOLDER
from deltactl.firmware_py.robot_file import RobotFile, load_robot
from deltactl.models.calibrated_inverse import CalibratedInverse
from deltactl.models.robot import EffectEntry, FloatArray

UNEVEN: dict[str, Any] = {
    "base_radius_m": (0.32, 0.325, 0.33),
    "platform_radius_m": (0.05, 0.055, 0.045),
    "upper_arm_m": (0.25, 0.252, 0.248),
    "forearm_m": (0.5, 0.503, 0.497),
    "azimuth_deg": (0.5, 119.0, 241.0),
    "home_offset_deg": (1.0, -2.0, 0.5),
}
CLOSE_M = 1e-6
STAGES = 12
"""The way to a pose goes in so many: at once the loops might close with the platform on top."""


def robots() -> list[RobotFile]:
    """As shipped, a robot without masses whose arms all differ, and one that was corrected."""
    plain = load_robot(CONFIG_FOLDER / "zhao-2023.yaml")
    uneven = plain.model_copy(
        update={"geometry": plain.geometry.model_copy(update=UNEVEN), "masses": None}
    )
    found = (
        EffectEntry(effect="home_offset", component="motor2", parameters={"angle": 0.02}),
        EffectEntry(effect="forearm_length", component="arm3", parameters={"length_error": 0.004}),
    )
    return [plain, uneven, plain.model_copy(update={"effects": found})]


ROBOTS = pytest.mark.parametrize("robot", robots(), ids=["plain", "uneven", "corrected"])


def poses(robot: RobotFile, count: int = 20) -> tuple[FloatArray, FloatArray]:
    """Commanded angles [rad] and the platform's places [m], (n, 3) each."""
    kinematics = CalibratedInverse(robot)
    position_m = np.random.default_rng(5).uniform(
        [-0.12, -0.12, -0.55], [0.12, 0.12, -0.4], (count, 3)
    )
    commanded_rad = kinematics.angles_rad_at_once(position_m)
    assert np.isfinite(commanded_rad).all()
    return commanded_rad, kinematics.position_m(commanded_rad)


def true_rad(robot: RobotFile, commanded_rad: FloatArray) -> FloatArray:
    """What the arms stand at, shape (3,), when they are commanded to angles."""
    kinematics = CalibratedInverse(robot)
    achieved_rad = kinematics.achieved_rad(commanded_rad[None, :])[0]
    return np.asarray(achieved_rad + kinematics.linkage.home_offset_rad)


@ROBOTS
def test_mujoco_brings_the_platform_where_our_kinematics_does(robot: RobotFile) -> None:
    mujoco = pytest.importorskip("mujoco", reason="the extra 'proof'")
    model = mujoco.MjModel.from_xml_string(mjcf_text(robot))
    data = mujoco.MjData(model)
    motors = [model.joint(f"motor_{n}").qposadr[0] for n in (1, 2, 3)]
    free = np.setdiff1d(np.arange(model.nq), motors)
    for commanded_rad, position_m in zip(*poses(robot), strict=True):
        mujoco.mj_resetDataKeyframe(model, data, model.key(HOME).id)
        for turned_rad in np.linspace(data.qpos[motors], true_rad(robot, commanded_rad), STAGES):
            data.qpos[motors] = turned_rad
            left_m = closed(mujoco, model, data, free)
        assert left_m < 1e-9
        np.testing.assert_allclose(data.body("platform").xpos, position_m, atol=CLOSE_M)


def closed(mujoco: Any, model: Any, data: Any, free: Any) -> float:
    """Move the joints that no motor turns until MuJoCo's own constraints hold; what is left [m]."""
    for _ in range(30):
        mujoco.mj_forward(model, data)
        if np.abs(data.efc_pos).max() < 1e-11:
            break
        jacobian = np.array(data.efc_J).reshape(data.nefc, model.nv)
        data.qpos[free] -= np.linalg.lstsq(jacobian[:, free], data.efc_pos, rcond=None)[0]
    mujoco.mj_forward(model, data)
    return float(np.abs(data.efc_pos).max())


def test_mujoco_begins_and_stays_with_closed_loops() -> None:
    mujoco = pytest.importorskip("mujoco", reason="the extra 'proof'")
    robot = robots()[0]
    model = mujoco.MjModel.from_xml_string(mjcf_text(robot))
    data = mujoco.MjData(model)
    mujoco.mj_resetDataKeyframe(model, data, model.key(HOME).id)
    mujoco.mj_forward(model, data)
    assert np.abs(data.efc_pos).max() < 1e-9
    assert (model.neq, model.nu) == (3, 3)
    start_m = data.body("platform").xpos.copy()
    mujoco.mj_step(model, data, 500)
    assert np.linalg.norm(data.body("platform").xpos - start_m) < 0.01  # the drives hold it
    low_rad, high_rad = np.deg2rad(robot.limits.arm_deg)
    np.testing.assert_allclose(model.joint("motor_1").range, [low_rad, high_rad])
    assert robot.masses is not None
    np.testing.assert_allclose(model.body("platform").mass, robot.masses.platform_kg)


@pytest.mark.parametrize("name", ["zhao-2023", "uzunovic-2013", "gripper-delta"])
def test_the_drives_of_mujoco_hold_a_large_robot_and_a_small_one(name: str) -> None:
    """The arms of one are six times as long as those of the other."""
    mujoco = pytest.importorskip("mujoco", reason="the extra 'proof'")
    robot = load_robot(CONFIG_FOLDER / f"{name}.yaml")
    model = mujoco.MjModel.from_xml_string(mjcf_text(robot))
    data = mujoco.MjData(model)
    mujoco.mj_resetDataKeyframe(model, data, model.key(HOME).id)
    start_rad = data.ctrl.copy()
    asked_rad = start_rad + np.deg2rad([3.0, 3.0, -50.0])
    for share in np.linspace(0.0, 1.0, 1500):
        data.ctrl[:] = start_rad + share * (asked_rad - start_rad)
        mujoco.mj_step(model, data)
    mujoco.mj_step(model, data, 200)
    turned_rad = [data.joint(f"motor_{n}").qpos[0] for n in (1, 2, 3)]
    np.testing.assert_allclose(turned_rad, asked_rad, atol=0.005)
    there_m = CalibratedInverse(robot).position_m(asked_rad[None, :])[0]
    np.testing.assert_allclose(data.body("platform").xpos, there_m, atol=0.002)


def test_mujoco_reads_the_urdf_of_a_robot_with_masses() -> None:
    mujoco = pytest.importorskip("mujoco", reason="the extra 'proof'")
    model = mujoco.MjModel.from_xml_string(urdf_text(robots()[0]))
    assert all(model.joint(f"motor_{n}").type[0] == mujoco.mjtJoint.mjJNT_HINGE for n in (1, 2, 3))


@ROBOTS
def test_the_urdf_is_a_tree_with_the_lengths_and_limits_of_the_file(robot: RobotFile) -> None:
    root = ET.fromstring(urdf_text(robot))
    links = [link.get("name") for link in root.findall("link")]
    joints = {joint.get("name"): joint for joint in root.findall("joint")}
    parents = {
        child_of(one, "child", "link"): child_of(one, "parent", "link") for one in joints.values()
    }
    assert len(set(links)) == len(links) == len(joints) + 1
    assert set(links) - set(parents) == {"base_link"}
    linkage = CalibratedInverse(robot).linkage
    for n in (1, 2, 3):
        assert length(joints[f"elbow_level_{n}"]) == pytest.approx(linkage.upper_arm_m[n - 1])
        low, high = (
            float(child_of(joints[f"motor_{n}"], "limit", end)) for end in ("lower", "upper")
        )
        ends = [true_rad(robot, np.full(3, end))[n - 1] for end in np.deg2rad(robot.limits.arm_deg)]
        np.testing.assert_allclose([low, high], ends, atol=1e-8)
        assert child_of(joints[f"motor_{n}"], "axis", "xyz") == "0 1 0"
    assert length(joints["wrist_tilt_1"]) == pytest.approx(linkage.forearm_m[0])
    radius_m = length(joints["shoulder_1"]) - length(joints["platform_mount"])
    assert radius_m == pytest.approx(linkage.radius_m[0])
    assert ("mass" in urdf_text(robot)) == (robot.masses is not None)


def child_of(joint: ET.Element, name: str, attribute: str) -> str:
    """An attribute of an element of a joint."""
    found = joint.find(name)
    assert found is not None
    return found.attrib[attribute]


def length(joint: ET.Element) -> float:
    """How far a joint is from its parent's [m]."""
    return math.hypot(*map(float, child_of(joint, "origin", "xyz").split()))


@ROBOTS
def test_the_tree_ends_where_the_platform_is(robot: RobotFile) -> None:
    commanded_rad, position_m = poses(robot)
    found, linkage = places(robot, commanded_rad), CalibratedInverse(robot).linkage
    for row, place_m in enumerate(position_m):
        seen: dict[str, Any] = {"base_link": np.eye(4)}
        for joint in joints_of(robot):
            here = np.eye(4)
            here[:3, 3] = joint.origin_m
            here[:3, :3] = matrix(turn(joint, found.get(joint.name, np.zeros(99))[row]))
            seen[joint.child] = seen[joint.parent] @ here
        np.testing.assert_allclose(seen["platform"][:3, 3], place_m, atol=1e-9)
        np.testing.assert_allclose(seen["platform"][:3, :3], np.eye(3), atol=1e-9)
        for n, length_m in enumerate(linkage.forearm_m, 1):
            end = seen[f"forearm_{n}"] @ [0.0, 0.0, -length_m, 1.0]
            base_m = robot.geometry.base_radius_m
            radius_m = (base_m if isinstance(base_m, float) else base_m[n - 1]) - linkage.radius_m[
                n - 1
            ]
            azimuth = linkage.azimuth_rad[n - 1]
            wrist = place_m + radius_m * np.array([np.cos(azimuth), np.sin(azimuth), 0.0])
            np.testing.assert_allclose(end[:3], wrist, atol=1e-9)


def matrix(quaternion: tuple[float, float, float, float]) -> FloatArray:
    """A rotation of x, y, z, w as a matrix, shape (3, 3)."""
    x, y, z, w = quaternion
    return np.array(
        [
            [1 - 2 * (y * y + z * z), 2 * (x * y - z * w), 2 * (x * z + y * w)],
            [2 * (x * y + z * w), 1 - 2 * (x * x + z * z), 2 * (y * z - x * w)],
            [2 * (x * z - y * w), 2 * (y * z + x * w), 1 - 2 * (x * x + y * y)],
        ]
    )


def test_the_files_name_no_folder_of_this_computer() -> None:
    for text in (urdf_text(robots()[0]), mjcf_text(robots()[0])):
        assert str(Path.cwd()) not in text
