"""The URDF or MJCF of a chain with what was found written into it, for the user's own simulator.

Friction, damping, rotor inertia, a load, geometry and the zeros of joints are properties of the
model. What is not (a gain, an offset, a late effort, what yields; rotor inertia in a URDF, which
has no place for it) stays in the robot file.
"""

from __future__ import annotations

import math
import os
import warnings
import xml.etree.ElementTree as ET
from collections.abc import Callable, Mapping
from dataclasses import dataclass, field
from pathlib import Path

import numpy as np
from scipy.spatial.transform import Rotation

from deltactl.foundation.errors import ConfigError
from deltactl.foundation.strict_yaml import Document
from deltactl.models.effects.chain_joints import JOINT_EFFECTS, LOAD
from deltactl.models.effects.chain_poses import POSE_EFFECTS
from deltactl.models.effects.link_geometry import OFF
from deltactl.models.effects_section import with_effects, with_model
from deltactl.models.rigid_chain import RigidChain, document_of
from deltactl.models.robot import ChainRobot, EffectEntry, FloatArray
from deltactl.models.robot_files import with_effects_in

STEEL_KG_M3 = 7850.0
"""A load of which only mass and centre are known turns as a ball of steel does."""
LOAD_LINK = "load_found_by_deltactl"
DIGITS = ".9g"
ZERO, GEOMETRY = POSE_EFFECTS["home"].name, POSE_EFFECTS["geometry"].name
TURNED_BY = ("quat", "euler", "axisangle", "xyaxes", "zaxis")
"""Attributes of an MJCF's body that say how it is turned."""


@dataclass(frozen=True, slots=True)
class CorrectedModel:
    """A model and the robot file that goes with it, as texts.

    written, kept: effects in the model, and those that stay in the robot file.
    """

    model: str
    robot: str
    written: tuple[EffectEntry, ...]
    kept: tuple[EffectEntry, ...]


@dataclass
class _Model:
    """The document that is being changed, and what its compiled form has already."""

    root: ET.Element
    chain: RigidChain
    loads: int = 0
    off: dict[str, FloatArray] = field(default_factory=dict)
    """Joint -> shift [m] and turn [rad] of the fixed transform before it, and by how much its zero
    is off [rad or m], (7,).
    """

    @property
    def urdf(self) -> bool:
        """Whether it is a URDF."""
        return self.root.tag == "robot"

    def joint(self, name: str) -> ET.Element:
        """The element of a joint. `RigidChain` has seen that it is there."""
        return next(one for one in self.root.iter("joint") if one.get("name") == name)


def corrected_model(robot_file: Path, out: Path) -> CorrectedModel:
    """The model of a chain with the effects of its robot file, to be written to `out`.

    Raises
    ------
    ConfigError
        `out` has another format than the model, or meshes of the model would not be found there.
    MissingExtra
        MuJoCo is not installed.
    """
    document = Document.read(robot_file)
    robot = with_effects_in(document)
    if not isinstance(robot, ChainRobot):
        raise ConfigError(f"{robot_file}: is a {robot.kind}; only a chain has a model of its own")
    source = Path(robot.model)
    root = document_of(source)
    _check_place(source, root, out)
    model = _Model(root, RigidChain(source, robot.joints, robot.gravity))
    written = tuple(one for one in robot.effects if _write(model, one))
    for joint, off in model.off.items():
        (_place_in_urdf if model.urdf else _place_in_mjcf)(model, joint, off)
    kept = tuple(one for one in robot.effects if one not in written)
    text = with_effects(with_model(document.text, out.name), kept)
    return CorrectedModel(_text(root), text, written, kept)


def _check_place(source: Path, root: ET.Element, out: Path) -> None:
    urdf = root.tag == "robot"
    if urdf != (out.suffix.lower() == ".urdf"):
        wanted = ".urdf" if urdf else ".xml"
        raise ConfigError(f"{out}: the model {source.name} is no such file; name it *{wanted}")
    beside = [
        name
        for mesh in root.iter("mesh")
        if (name := mesh.get("filename") or mesh.get("file") or "")
        and "://" not in name
        and not os.path.isabs(name)
    ]
    if beside and out.resolve().parent != source.resolve().parent:
        raise ConfigError(
            f"{out}: meshes as '{beside[0]}' are looked for beside the model; write it into"
            f" {source.parent}"
        )


def _write(model: _Model, entry: EffectEntry) -> bool:
    """Put an effect into the model; False where a model has no place for it."""
    sizes = {name: float(v) for name, v in entry.parameters.items() if isinstance(v, int | float)}
    if entry.effect == LOAD:
        return entry.component == model.chain.tip and _carry(model, sizes)
    if entry.effect in (ZERO, GEOMETRY):
        return entry.component in model.chain.joints and _displace(model, entry, sizes)
    key = next((key for key, one in JOINT_EFFECTS.items() if one.name == entry.effect), "")
    writer = WRITERS.get(key)
    size = sizes.get(JOINT_EFFECTS[key].parameter) if key else None
    if writer is None or size is None or entry.component not in model.chain.joints:
        return False
    return writer(model, entry.component, size)


def _displace(model: _Model, entry: EffectEntry, sizes: Mapping[str, float]) -> bool:
    """Note where a joint is instead; False where its frame in the model is that of two joints."""
    if not model.urdf and model.chain.frame_of(entry.component) is None:
        return False
    names = (*OFF, "angle") if entry.effect == GEOMETRY else (*[""] * len(OFF), "angle")
    added = np.array([sizes.get(name, 0.0) for name in names])
    if entry.effect == GEOMETRY:
        added[-1] = 0.0
    model.off[entry.component] = model.off.get(entry.component, np.zeros(7)) + added
    return True


def _place_in_urdf(model: _Model, joint: str, off: FloatArray) -> None:
    element = model.joint(joint)
    origin = element.find("origin")
    if origin is None:
        origin = ET.SubElement(element, "origin")
    axis = _numbers(element.find("axis"), "xyz", "1 0 0")
    shift = _numbers(origin, "xyz", "0 0 0") + off[:3]
    turn = Rotation.from_rotvec(off[3:6]) * Rotation.from_euler(
        "xyz", _numbers(origin, "rpy", "0 0 0")
    )
    if element.get("type") == "prismatic":
        shift = shift + turn.apply(axis * off[6])
    else:
        turn = turn * Rotation.from_rotvec(axis * off[6])
    origin.set("xyz", _text_of(shift))
    with warnings.catch_warnings():  # at a right angle roll and yaw are one turn: either will do
        warnings.simplefilter("ignore", UserWarning)
        origin.set("rpy", _text_of(turn.as_euler("xyz")))


def _place_in_mjcf(model: _Model, joint: str, off: FloatArray) -> None:
    """A body turns about the anchor of its joint."""
    frame = model.chain.frame_of(joint)
    assert frame is not None
    place, before, anchor, axis = frame
    number = model.chain.joints.index(joint)
    turn = Rotation.from_rotvec(off[3:6]) * Rotation.from_matrix(before)
    slide = np.zeros(3)
    if model.chain.slides[number]:
        slide = turn.apply(axis * off[6])
    else:
        turn = turn * Rotation.from_rotvec(axis * off[6])
    place = place + off[:3] + slide + before @ anchor - turn.apply(anchor)
    own = model.joint(joint)
    body = next(one for one in model.root.iter("body") if own in list(one))
    for other in TURNED_BY:
        body.attrib.pop(other, None)
    x, y, z, w = turn.as_quat()
    body.set("pos", _text_of(place))
    body.set("quat", _text_of(np.array([w, x, y, z])))


def _numbers(element: ET.Element | None, name: str, default: str) -> FloatArray:
    text = default if element is None else element.get(name, default)
    return np.array([float(number) for number in text.split()])


def _text_of(numbers: FloatArray) -> str:
    return " ".join(format(float(number) + 0.0, DIGITS) for number in numbers)


def _rub(model: _Model, joint: str, torque: float) -> bool:
    has = float(model.chain.friction[model.chain.joints.index(joint)])
    _set(model, joint, "friction", "frictionloss", has + torque)
    return True


def _brake(model: _Model, joint: str, coefficient: float) -> bool:
    has = float(model.chain.damping[model.chain.joints.index(joint)])
    _set(model, joint, "damping", "damping", has + coefficient)
    return True


def _spin(model: _Model, joint: str, inertia: float) -> bool:
    if not model.urdf:
        model.joint(joint).set("armature", format(inertia, DIGITS))
    return not model.urdf


WRITERS: Mapping[str, Callable[[_Model, str, float], bool]] = {
    "dry": _rub,
    "viscous": _brake,
    "rotor": _spin,
}


def _set(model: _Model, joint: str, in_urdf: str, in_mjcf: str, value: float) -> None:
    element = model.joint(joint)
    if model.urdf:
        dynamics = element.find("dynamics")
        if dynamics is None:
            dynamics = ET.SubElement(element, "dynamics")
        dynamics.set(in_urdf, format(value, DIGITS))
    else:
        element.set(in_mjcf, format(value, DIGITS))


def _carry(model: _Model, sizes: Mapping[str, float]) -> bool:
    """Fix a load to the last link; a lack of mass is for the user to take off."""
    mass = sizes.get("mass", 0.0)
    if mass <= 0.0:
        return False
    at = " ".join(format(sizes.get(f"centre_{axis}", 0.0), DIGITS) for axis in "xyz")
    radius_m = (3.0 * mass / (4.0 * math.pi * STEEL_KG_M3)) ** (1.0 / 3.0)
    turns = format(0.4 * mass * radius_m**2, DIGITS)
    model.loads += 1
    name = LOAD_LINK if model.loads == 1 else f"{LOAD_LINK}_{model.loads}"
    add = _carry_in_urdf if model.urdf else _carry_in_mjcf
    add(model, name, format(mass, DIGITS), at, turns)
    return True


def _carry_in_urdf(model: _Model, name: str, mass: str, at: str, turns: str) -> None:
    joint = ET.SubElement(model.root, "joint", name=f"{name}_joint", type="fixed")
    ET.SubElement(joint, "parent", link=model.chain.tip)
    ET.SubElement(joint, "child", link=name)
    ET.SubElement(joint, "origin", xyz=at, rpy="0 0 0")
    inertial = ET.SubElement(ET.SubElement(model.root, "link", name=name), "inertial")
    ET.SubElement(inertial, "mass", value=mass)
    ET.SubElement(inertial, "inertia", ixx=turns, iyy=turns, izz=turns, ixy="0", ixz="0", iyz="0")


def _carry_in_mjcf(model: _Model, name: str, mass: str, at: str, turns: str) -> None:
    tip = next(one for one in model.root.iter("body") if one.get("name") == model.chain.tip)
    body = ET.SubElement(tip, "body", name=name, pos=at)
    ET.SubElement(body, "inertial", mass=mass, pos="0 0 0", diaginertia=f"{turns} {turns} {turns}")


def _text(root: ET.Element) -> str:
    ET.indent(root)
    return f"{ET.tostring(root, encoding='unicode')}\n"
