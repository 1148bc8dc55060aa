"""A delta as URDF: a tree, closed by mimic joints on arm 1 and cut at two forearms (`links`)."""

from __future__ import annotations

import math
import xml.etree.ElementTree as ET

from deltactl.firmware_py.exporting.links import (
    BASE,
    MOTOR,
    PLATFORM,
    Arm,
    Joint,
    arms_of,
    joints_of,
    limits_rad,
)
from deltactl.firmware_py.robot_file import RobotFile

THICK_M, THIN_M, PLATE_M = 0.012, 0.006, 0.01
"""Radii of the drawn arms and rods, and thickness of the plates; no robot file says them."""
LIGHT_KG = 1e-5
"""A link that only joins two hinges has this mass: simulators refuse a moving link without mass."""
EFFORT_NM = 100.0
"""URDF needs a limit of torque; no robot file says one."""
PASSIVE_RAD = math.pi
DISC = "disc"
COLOURS = {"plate": "0.35 0.38 0.42 1", "arm": "0.11 0.44 0.75 1", "rod": "0.6 0.63 0.67 1"}
NOTE = (
    " Written by deltactl export. A tree cannot have the loops of a delta: the platform hangs on"
    " arm 1, where mimic joints keep it level; forearms 2 and 3 end at the platform only where"
    " elbow_swing and elbow_tilt of all arms have the places that deltactl gives them in"
    " /joint_states. For closed loops use the MJCF export. "
)


def urdf_text(robot: RobotFile) -> str:
    """The URDF document: joints `motor_1` to `motor_3` turn the upper arms, positive downwards."""
    root = ET.Element("robot", name=_name(robot.name))
    root.append(ET.Comment(NOTE))
    for name, rgba in COLOURS.items():
        ET.SubElement(ET.SubElement(root, "material", name=name), "color", rgba=rgba)
    arms, joints = arms_of(robot), joints_of(robot)
    links = [BASE, *(joint.child for joint in joints)]
    for link in links:
        _link(root, link, arms, robot)
    for joint in joints:
        _joint(root, joint, robot)
    ET.indent(root, " ")
    return ET.tostring(root, encoding="unicode", xml_declaration=True) + "\n"


def _name(name: str) -> str:
    return "".join(letter if letter.isalnum() or letter in "-_" else "_" for letter in name)


def _link(root: ET.Element, name: str, arms: list[Arm], robot: RobotFile) -> None:
    link = ET.SubElement(root, "link", name=name)
    kind, _, number = name.rpartition("_")
    masses = robot.masses
    if name == BASE:
        _drawn(link, "plate", max(arm.base_radius_m for arm in arms), PLATE_M, "0 0 0", "0 0 0")
    elif name == PLATFORM:
        radius_m = max(max(arm.platform_radius_m for arm in arms), THICK_M)
        _drawn(link, "plate", radius_m, PLATE_M, "0 0 0", "0 0 0")
        if masses is not None:
            _mass(link, masses.platform_kg, radius_m, "0 0 0", DISC)
    elif kind == "upper_arm":
        long_m = arms[int(number) - 1].upper_arm_m
        middle = f"{long_m / 2:.9g} 0 0"
        _drawn(link, "arm", THICK_M, long_m, middle, f"0 {math.pi / 2:.9g} 0")
        if masses is not None:
            _mass(link, masses.upper_arm_kg, long_m, middle, "x")
    elif kind == "forearm":
        long_m = arms[int(number) - 1].forearm_m
        middle = f"0 0 {-long_m / 2:.9g}"
        _drawn(link, "rod", THIN_M, long_m, middle, "0 0 0")
        if masses is not None:
            _mass(link, masses.forearm_kg, long_m, middle, "z")
    elif masses is not None:
        _mass(link, LIGHT_KG, THIN_M, "0 0 0", DISC)


def _drawn(
    link: ET.Element, material: str, radius_m: float, long_m: float, xyz: str, rpy: str
) -> None:
    """A cylinder, seen only: what touches what is not known."""
    visual = ET.SubElement(link, "visual")
    ET.SubElement(visual, "origin", xyz=xyz, rpy=rpy)
    shape = ET.SubElement(visual, "geometry")
    ET.SubElement(shape, "cylinder", radius=f"{radius_m:.9g}", length=f"{long_m:.9g}")
    ET.SubElement(visual, "material", name=material)


def _mass(link: ET.Element, mass_kg: float, size_m: float, xyz: str, along: str) -> None:
    """A thin rod along x or z, or a plate about z; at least as heavy as a mere joint."""
    mass_kg = max(mass_kg, LIGHT_KG)
    disc = along == DISC
    flat_kgm2, lengthwise = mass_kg * size_m**2 / 4.0, mass_kg * THIN_M**2 / 2.0
    across = mass_kg * size_m**2 / 12.0
    if disc:
        across, lengthwise = flat_kgm2 + mass_kg * PLATE_M**2 / 12.0, 2.0 * flat_kgm2
    moments = dict.fromkeys(("ixx", "iyy", "izz"), across)
    moments["ixx" if along == "x" else "izz"] = lengthwise
    inertial = ET.SubElement(link, "inertial")
    ET.SubElement(inertial, "origin", xyz=xyz, rpy="0 0 0")
    ET.SubElement(inertial, "mass", value=f"{mass_kg:.9g}")
    every = moments | dict.fromkeys(("ixy", "ixz", "iyz"), 0.0)
    ET.SubElement(inertial, "inertia", {name: f"{value:.9g}" for name, value in every.items()})


def _joint(root: ET.Element, joint: Joint, robot: RobotFile) -> None:
    kind = "fixed" if joint.about is None else "revolute"
    made = ET.SubElement(root, "joint", name=joint.name, type=kind)
    ET.SubElement(made, "parent", link=joint.parent)
    ET.SubElement(made, "child", link=joint.child)
    xyz = " ".join(f"{value:.9g}" for value in joint.origin_m)
    ET.SubElement(made, "origin", xyz=xyz, rpy=f"0 0 {joint.yaw_rad:.9g}")
    if joint.about is None:
        return
    ET.SubElement(made, "axis", xyz="1 0 0" if joint.about == 0 else "0 1 0")
    low_rad, high_rad = -PASSIVE_RAD, PASSIVE_RAD
    if joint.name.startswith(f"{MOTOR}_"):
        low_rad, high_rad = limits_rad(robot, int(joint.name[-1]) - 1)
    ET.SubElement(
        made,
        "limit",
        lower=f"{low_rad:.9g}",
        upper=f"{high_rad:.9g}",
        effort=f"{EFFORT_NM:g}",
        velocity=f"{robot.limits.joint_speed_radps:.9g}",
    )
    if joint.mimics:
        ET.SubElement(made, "mimic", joint=joint.mimics, multiplier="-1", offset="0")
