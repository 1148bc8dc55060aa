"""A robot that a URDF or MJCF describes: the efforts at its joints that a motion needs.

MuJoCo reads both formats and does the inverse dynamics. Shapes are looked at by nobody here, so
meshes may be missing.
"""

from __future__ import annotations

import difflib
import xml.etree.ElementTree as ET
from collections.abc import Sequence
from pathlib import Path
from typing import Any

import numpy as np

from deltactl.foundation.errors import ConfigError, MissingFile
from deltactl.foundation.extras import needs
from deltactl.models.robot import FloatArray

EXTRA = "chain"
FROM_AFAR_M = 0.1
"""Distance from the flange at which loads are tried; the load's columns are exact at any."""
BODY = "mass", "first_x", "first_y", "first_z", "xx", "yy", "zz", "xy", "xz", "yz"
"""Moments of a load about the frame of the link that carries it [kg, kg m, kg m2]."""
MOVING = ("revolute", "continuous", "prismatic")


class RigidChain:
    """Inverse dynamics of some joints of a model; the others stay where the model has them."""

    def __init__(self, path: Path, joints: Sequence[str], gravity: bool = True):
        """Raises MissingFile, ConfigError with the file and the remedy, or MissingExtra."""
        with needs(EXTRA, "a robot of `kind: chain`"):
            import mujoco
        self._mujoco, self.path, self._gravity = mujoco, path, gravity
        self._text = _without_shapes(path)
        self._model = self._compiled()
        self.joints = tuple(joints)
        addresses = [self._address(name) for name in joints]
        self._position = np.array([a for a, _ in addresses])
        self._speed = np.array([b for _, b in addresses])
        self.slides = tuple(self._kind(name) == mujoco.mjtJoint.mjJNT_SLIDE for name in joints)
        self.tip = self._last_body()
        """The link that carries a load."""
        self.armature = np.array(self._model.dof_armature[self._speed])
        """Rotor inertia that the model has already, (joints,) [kg m2 or kg]."""
        self.friction = np.array(self._model.dof_frictionloss[self._speed])
        """Coulomb friction that the model has already, (joints,) [N m or N]."""
        self.damping = np.array(self._model.dof_damping[self._speed])
        """Viscous friction that the model has already, (joints,) [N m s/rad or N s/m]."""

    def _compiled(self, load_at: FloatArray | None = None) -> Any:
        """The model, with a point mass of 1 kg on the last link."""
        try:
            spec = self._mujoco.MjSpec.from_string(self._text)
            if load_at is not None:
                spec.body(self.tip).add_body(
                    pos=load_at, mass=1.0, ipos=[0.0] * 3, inertia=[1e-9] * 3, explicitinertial=True
                )
            model = spec.compile()
        except ValueError as error:
            raise ConfigError(f"{self.path}: {' '.join(str(error).split())}") from None
        flag = self._mujoco.mjtDisableBit
        for off in ("CONTACT", "LIMIT", "EQUALITY", "FRICTIONLOSS", "ACTUATION"):
            model.opt.disableflags |= int(getattr(flag, f"mjDSBL_{off}"))
        if not self._gravity:
            model.opt.gravity[:] = 0.0
        return model

    def _address(self, name: str) -> tuple[int, int]:
        try:
            joint = self._model.joint(name)
        except KeyError:
            known = [self._model.joint(j).name for j in range(self._model.njnt)]
            near = difflib.get_close_matches(name, known, n=1)
            meant = f" (did you mean '{near[0]}'?)" if near else ""
            raise ConfigError(
                f"{self.path}: has no moving joint '{name}'{meant}; `joints` of the robot file must"
                f" be some of: {', '.join(known)}"
            ) from None
        return int(joint.qposadr[0]), int(joint.dofadr[0])

    def _kind(self, name: str) -> int:
        return int(self._model.joint(name).type[0])

    def _last_body(self) -> str:
        bodies = [int(self._model.joint(name).bodyid[0]) for name in self.joints]
        return str(self._model.body(max(bodies)).name)

    def efforts(self, at: FloatArray, speed: FloatArray, change: FloatArray) -> FloatArray:
        """What moves the joints so, (n, joints) [N m or N]; positions, velocities and accelerations
        (n, joints) in rad or m.
        """
        return self._inverse(self._model, at, speed, change)

    def _inverse(
        self, model: Any, at: FloatArray, speed: FloatArray, change: FloatArray
    ) -> FloatArray:
        data = self._mujoco.MjData(model)
        made = np.empty_like(at)
        for row in range(len(at)):
            data.qpos[self._position] = at[row]
            data.qvel[self._speed] = speed[row]
            data.qacc[self._speed] = change[row]
            self._mujoco.mj_inverse(model, data)
            made[row] = data.qfrc_inverse[self._speed]
        return made

    def load_columns(self, at: FloatArray, speed: FloatArray, change: FloatArray) -> FloatArray:
        """Effort by each of the moments of `BODY` of a load on the last link, (n, joints, 10).

        A point mass at p makes an effort that is a quadratic form of p, and any load is a sum of
        points: ten points give all ten columns exactly.
        """
        along = FROM_AFAR_M * np.eye(3)
        pairs = [along[0] + along[1], along[0] + along[2], along[1] + along[2]]
        points = np.array([np.zeros(3), *along, *-along, *pairs])
        bare = self.efforts(at, speed, change)
        made = np.stack(
            [self._inverse(self._compiled(p), at, speed, change) - bare for p in points], axis=-1
        )
        x, y, z = points.T
        moments = np.stack([np.ones(10), x, y, z, x * x, y * y, z * z, x * y, x * z, y * z])
        columns: FloatArray = made @ np.linalg.inv(moments)
        return columns

    @property
    def mass_kg(self) -> float:
        """Mass of all that moves."""
        return float(np.sum(self._model.body_mass[1:]))

    @property
    def reach_m(self) -> float:
        """From the base along all links to the last."""
        offsets = [float(np.linalg.norm(self._model.body_pos[b])) for b in range(1, self._bodies)]
        return max(sum(offsets), FROM_AFAR_M)

    @property
    def _bodies(self) -> int:
        return int(self._model.nbody)


def moving_joints(path: Path) -> list[str]:
    """Names of the joints of a URDF or MJCF that turn or slide. Raises as `RigidChain` does."""
    root = document_of(path)
    if root.tag == "robot":
        found = [one.get("name", "") for one in root.iter("joint") if one.get("type") in MOVING]
    else:
        world = root.find("worldbody")
        found = [] if world is None else [one.get("name", "") for one in world.iter("joint")]
    if not found or not all(found):
        what = "a joint without a name" if found else "no joint that turns or slides"
        raise ConfigError(f"{path}: has {what}; a chain is diagnosed by its named joints")
    return found


def document_of(path: Path) -> ET.Element:
    """The XML of a URDF or MJCF, with its comments. Raises as `RigidChain` does."""
    try:
        builder = ET.TreeBuilder(insert_comments=True)
        root = ET.fromstring(path.read_text(encoding="utf-8"), ET.XMLParser(target=builder))
    except FileNotFoundError:
        raise MissingFile(
            f"{path}: no such file; `model` is a URDF or MJCF, beside the robot file"
        ) from None
    except (OSError, UnicodeDecodeError, ET.ParseError) as error:
        raise ConfigError(f"{path}: is no XML that can be read ({error})") from None
    if root.tag not in ("robot", "mujoco"):
        hint = "; run xacro on it first" if "xacro" in path.name else ""
        raise ConfigError(f"{path}: is neither a URDF (<robot>) nor an MJCF (<mujoco>){hint}")
    return root


def _without_shapes(path: Path) -> str:
    """The text of a model, without what only a drawing or a collision needs."""
    root = document_of(path)
    if root.tag == "robot":
        _refuse_loops(path, root)
        _refuse_weightless(path, root)
        for link in root.iter("link"):
            for shape in [*link.findall("visual"), *link.findall("collision")]:
                link.remove(shape)
    else:
        _refuse_unsupported(path, root)
        for body in root.iter("body"):
            if body.find("inertial") is not None:  # else the shapes are all that is heavy
                for shape in body.findall("geom"):
                    body.remove(shape)
        if not any(geom.get("mesh") for geom in root.iter("geom")):
            for asset in root.findall("asset"):
                root.remove(asset)
        for part in ("contact", "sensor", "keyframe", "actuator"):
            for one in root.findall(part):
                root.remove(one)
    return ET.tostring(root, encoding="unicode")


def _refuse_loops(path: Path, robot: ET.Element) -> None:
    """A link that two joints carry closes a loop."""
    carried: dict[str, str] = {}
    for joint in robot.findall("joint"):
        child, name = joint.find("child"), joint.get("name", "")
        link = "" if child is None else child.get("link", "")
        if link in carried:
            raise ConfigError(
                f"{path}: joints '{carried[link]}' and '{name}' both carry link '{link}': that is a"
                " loop, and a chain has none; leave one of them out"
            )
        carried[link] = name


def _refuse_weightless(path: Path, robot: ET.Element) -> None:
    """A link that moves, and nothing fixed to it, must have a mass."""
    heavy = {
        link.get("name", "")
        for link in robot.findall("link")
        if (mass := link.find("inertial/mass")) is not None and float(mass.get("value", 0)) > 0.0
    }
    fixed: dict[str, list[str]] = {}
    moved: dict[str, str] = {}
    for joint in robot.findall("joint"):
        parent, child = joint.find("parent"), joint.find("child")
        if parent is None or child is None:
            continue
        link = child.get("link", "")
        if joint.get("type") == "fixed":
            fixed.setdefault(parent.get("link", ""), []).append(link)
        else:
            moved[link] = joint.get("name", "")

    def weighs(link: str) -> bool:
        return link in heavy or any(map(weighs, fixed.get(link, [])))

    for link, joint_name in moved.items():
        if not weighs(link):
            raise ConfigError(
                f"{path}: link '{link}', which joint '{joint_name}' moves, has no mass: give it an"
                " <inertial> with mass and inertia (the maker's, or from the drawing)"
            )


def _refuse_unsupported(path: Path, mujoco: ET.Element) -> None:
    """Loops and bodies that float."""
    if mujoco.find("equality/connect") is not None or mujoco.find("equality/weld") is not None:
        raise ConfigError(f"{path}: <equality> closes a loop, and a chain has none; leave it out")
    free = any(one.get("type") in ("free", "ball") for one in mujoco.iter("joint"))
    if free or mujoco.find(".//freejoint") is not None:
        raise ConfigError(
            f"{path}: has a free or ball joint; only joints that turn or slide are read"
        )
