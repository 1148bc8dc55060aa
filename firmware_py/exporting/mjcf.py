"""A delta as MJCF for MuJoCo, exact: `connect` constraints close the loops.

The platform slides along x, y and z, as the forearms' pairs of rods let it move and nothing else.
Each forearm is one rod in the middle of its pair, on two crossed hinges at the elbow, and its lower
end is connected to the platform. Names are those of the URDF.
"""

from __future__ import annotations

import xml.etree.ElementTree as ET

import numpy as np

from deltactl.firmware_py.exporting.links import (
    MOTOR,
    PLATFORM,
    SWING,
    TILT,
    Arm,
    arms_of,
    limits_rad,
    middle_rad,
    places,
    pose,
)
from deltactl.firmware_py.robot_file import RobotFile
from deltactl.models.robot import Masses

THICK_M, THIN_M, PLATE_M = 0.012, 0.006, 0.005
"""Radii of arms and rods, and half the thickness of the platform; no robot file says them."""
ASSUMED = Masses(upper_arm_kg=0.3, forearm_kg=0.1, platform_kg=0.2)
"""Masses where the robot file has none: MuJoCo needs some. Kinematics does not depend on them."""
LIGHTEST_KG = 1e-4
STIFF_RADPS = 300.0
"""Natural frequency of each drive, critically damped. The robot file does not say how stiff they
are: gains that fit a large robot would throw a small one apart within a few steps."""
STEP_S = 0.001
HOME = "assembled"
"""The keyframe in which the loops are closed; a simulation begins there."""


def mjcf_text(robot: RobotFile) -> str:
    """The MJCF document: actuators and joints `motor_1` to `motor_3` are true angles [rad]."""
    root = ET.Element("mujoco", model=robot.name)
    note = f" Written by deltactl export. Start from the keyframe '{HOME}': its loops are closed. "
    root.append(ET.Comment(note))
    ET.SubElement(root, "compiler", angle="radian", autolimits="true")
    ET.SubElement(root, "option", timestep=f"{STEP_S:g}", integrator="implicitfast")
    still = ET.SubElement(ET.SubElement(root, "default"), "geom", contype="0", conaffinity="0")
    still.set("rgba", "0.4 0.5 0.6 1")
    world, masses = ET.SubElement(root, "worldbody"), robot.masses or ASSUMED
    ET.SubElement(world, "light", pos="0 0 1.5", dir="0 0 -1")
    ties, drives = ET.Element("equality"), ET.Element("actuator")
    arms = arms_of(robot)
    for number, arm in enumerate(arms, 1):
        inertia_kgm2 = _carried_kg(masses) * arm.upper_arm_m**2
        _arm(world, number, arm, robot, masses)
        ET.SubElement(ties, "connect", site1=f"forearm_{number}_end", site2=f"platform_{number}")
        ET.SubElement(
            drives,
            "position",
            name=f"{MOTOR}_{number}",
            joint=f"{MOTOR}_{number}",
            kp=f"{2.0 * inertia_kgm2 * STIFF_RADPS**2:.9g}",
            kv=f"{4.0 * inertia_kgm2 * STIFF_RADPS:.9g}",
            inheritrange="1",
        )
    _platform(world, arms, masses)
    root.extend([ties, drives])
    _keyframe(root, robot)
    ET.indent(root, " ")
    return ET.tostring(root, encoding="unicode") + "\n"


def _arm(world: ET.Element, number: int, arm: Arm, robot: RobotFile, masses: Masses) -> None:
    low_rad, high_rad = limits_rad(robot, number - 1)
    away = np.array([np.cos(arm.azimuth_rad), np.sin(arm.azimuth_rad), 0.0]) * arm.base_radius_m
    half = arm.azimuth_rad / 2.0
    turned = f"{np.cos(half):.12g} 0 0 {np.sin(half):.12g}"
    upper = ET.SubElement(world, "body", name=f"upper_arm_{number}", pos=_words(away), quat=turned)
    rotor = f"{_carried_kg(masses) * arm.upper_arm_m**2:.9g}"
    ends = f"{low_rad:.12g} {high_rad:.12g}"
    _hinge(upper, f"{MOTOR}_{number}", "0 1 0", range=ends, armature=rotor)
    ends = f"0 0 0 {arm.upper_arm_m:.12g} 0 0"
    _rod(upper, ends, THICK_M, masses.upper_arm_kg)
    # Hinges that act one after the other: the first turns the arm's angle back, so that the swing
    # Here the swing is measured from the upper arm, in the URDF from the vertical.
    at = f"{arm.upper_arm_m:.12g} 0 0"
    elbow = ET.SubElement(upper, "body", name=f"forearm_{number}", pos=at)
    _hinge(elbow, f"{SWING}_{number}", "0 1 0")
    _hinge(elbow, f"{TILT}_{number}", "1 0 0")
    _rod(elbow, f"0 0 0 0 0 {-arm.forearm_m:.12g}", THIN_M, masses.forearm_kg)
    ET.SubElement(elbow, "site", name=f"forearm_{number}_end", pos=f"0 0 {-arm.forearm_m:.12g}")


def _carried_kg(masses: Masses) -> float:
    """What one motor feels at its elbow; its rotor is taken to feel as much again."""
    carried_kg = masses.upper_arm_kg / 3.0 + masses.forearm_kg + masses.platform_kg / 3.0
    return max(carried_kg, LIGHTEST_KG)


def _hinge(body: ET.Element, name: str, axis: str, **more: str) -> None:
    ET.SubElement(body, "joint", {"name": name, "type": "hinge", "axis": axis} | more)


def _rod(body: ET.Element, ends: str, radius_m: float, mass_kg: float) -> None:
    mass = f"{max(mass_kg, LIGHTEST_KG):.9g}"
    ET.SubElement(body, "geom", type="capsule", fromto=ends, size=f"{radius_m:g}", mass=mass)


def _platform(world: ET.Element, arms: list[Arm], masses: Masses) -> None:
    body = ET.SubElement(world, "body", name=PLATFORM)
    for axis, along in zip("xyz", ("1 0 0", "0 1 0", "0 0 1"), strict=True):
        ET.SubElement(body, "joint", name=f"{PLATFORM}_{axis}", type="slide", axis=along)
    size_m = max(max(arm.platform_radius_m for arm in arms), THICK_M)
    ET.SubElement(
        body,
        "geom",
        type="cylinder",
        size=f"{size_m:.9g} {PLATE_M:g}",
        mass=f"{max(masses.platform_kg, LIGHTEST_KG):.9g}",
    )
    for number, arm in enumerate(arms, 1):
        away = np.array([np.cos(arm.azimuth_rad), np.sin(arm.azimuth_rad), 0.0])
        place = _words(away * arm.platform_radius_m)
        ET.SubElement(body, "site", name=f"platform_{number}", pos=place)


def _keyframe(root: ET.Element, robot: RobotFile) -> None:
    """A pose in which the loops are closed, in the order of the joints."""
    commanded_rad = middle_rad(robot)[None, :]
    found = {name: float(values[0]) for name, values in places(robot, commanded_rad).items()}
    position_m = pose(robot, commanded_rad)[1][0]
    motors = [found[f"{MOTOR}_{n}"] for n in (1, 2, 3)]
    arms = [
        (motor, found[f"{SWING}_{n}"] - motor, found[f"{TILT}_{n}"])
        for n, motor in enumerate(motors, 1)
    ]
    place = [*(value for arm in arms for value in arm), *position_m.tolist()]
    keys = ET.SubElement(root, "keyframe")
    ET.SubElement(keys, "key", name=HOME, qpos=_words(place), ctrl=_words(motors))


def _words(values: object) -> str:
    return " ".join(f"{value:.12g}" for value in np.ravel(np.asarray(values, dtype=np.float64)))
