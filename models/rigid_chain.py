"""A robot that a URDF or MJCF describes: where its links are, and what moves its joints.

MuJoCo reads both formats and does the inverse dynamics. Shapes are looked at by nobody here, so
meshes may be missing.
"""

from __future__ import annotations

import copy
import difflib
import xml.etree.ElementTree as ET
from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property
from pathlib import Path
from typing import Any

import numpy as np
from scipy.spatial.transform import Rotation

from deltactl.foundation.errors import ConfigError, MissingFile
from deltactl.foundation.extras import needs
from deltactl.models.robot import FloatArray

BoolArray = np.ndarray[Any, np.dtype[np.bool_]]
IntArray = np.ndarray[Any, np.dtype[np.intp]]
EXTRA = "chain"
FROM_AFAR_M = 0.1
"""Distance from the flange at which loads are tried; the load's columns are exact at any."""
BODY = "mass", "first_x", "first_y", "first_z", "xx", "yy", "zz", "xy", "xz", "yz"
"""Moments of a load about the frame of the link that carries it [kg, kg m, kg m2]."""
MOVING = ("revolute", "continuous", "prismatic")


@dataclass(frozen=True, slots=True, eq=False)
class Placed:
    """Where a chain is in some poses, in the axes of its base [m]; joints in their order.

    links (n, k, 3) and frames (n, k, 3, 3): of the links that were asked for. anchors, axes
    (n, joints, 3): of the joints. parents (n, joints, 3, 3): frame of the link before each joint.
    moments (n, joints, 3): of the weight of all that a joint carries, about its anchor [N m].
    loads (n, joints): effort of that weight along the joint [N m or N].
    """

    links: FloatArray
    frames: FloatArray
    anchors: FloatArray
    axes: FloatArray
    parents: FloatArray
    moments: FloatArray
    loads: FloatArray


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

    def link_columns(self, at: FloatArray, speed: FloatArray, change: FloatArray) -> FloatArray:
        """Effort by the links of each joint up to the next, (n, joints, joints), linear in their
        masses.
        """
        carrier = np.full(self._bodies, -1)
        for body in range(1, self._bodies):
            own = np.flatnonzero(self._model.jnt_bodyid[self._numbers] == body)
            above = carrier[self._model.body_parentid[body]]
            carrier[body] = own[-1] if len(own) else above
        made = []
        for joint in range(len(self.joints)):
            lighter = copy.copy(self._model)
            lighter.body_mass[carrier == joint] *= 0.5
            lighter.body_inertia[carrier == joint] *= 0.5
            made.append(self._inverse(lighter, at, speed, change))
        whole = self.efforts(at, speed, change)[..., None]
        columns: FloatArray = 2.0 * (whole - np.stack(made, axis=-1))
        return columns

    def placed(self, at: FloatArray, links: Sequence[str], off: FloatArray | None = None) -> Placed:
        """Places of links and joints at positions (n, joints) in rad or m.

        off: (joints, 6) shift [m] and turn [rad] of the fixed transform before each joint, in the
        frame of the link before it.
        """
        model = self._model if off is None else self._moved(off)
        data, own = self._mujoco.MjData(model), self._numbers
        body = model.jnt_bodyid[own]
        asked = np.array([model.body(link).id for link in links])
        pull = model.opt.gravity * model.body_subtreemass[body][:, None]
        fixed = _turns(self._model.body_quat[body]) @ np.swapaxes(self._origins, 1, 2)
        before = self._model.body_parentid[body]
        (count, joints), k = at.shape, len(links)
        shapes = (k, 3), (k, 3, 3), (joints, 3), (joints, 3), (joints, 3, 3), (joints, 3), (joints,)
        made = Placed(*(np.empty((count, *shape)) for shape in shapes))
        for row in range(count):
            data.qpos[self._position] = at[row]
            self._mujoco.mj_kinematics(model, data)
            self._mujoco.mj_comPos(model, data)
            made.links[row], made.frames[row] = data.xpos[asked], data.xmat[asked].reshape(-1, 3, 3)
            made.anchors[row], made.axes[row] = data.xanchor[own], data.xaxis[own]
            made.parents[row] = data.xmat[before].reshape(-1, 3, 3) @ fixed
            made.moments[row] = np.cross(data.subtree_com[body] - data.xanchor[own], pull)
        along = np.where(np.array(self.slides)[:, None], pull, made.moments)
        made.loads[:] = np.sum(made.axes * along, axis=2)
        return made

    def frame_of(self, joint: str) -> tuple[FloatArray, FloatArray, FloatArray, FloatArray] | None:
        """Place (3,) [m] and turn (3, 3) of the body that a joint of an MJCF moves, against the
        body before it, and in its own frame the joint's anchor and axis; None where another joint
        moves it too.
        """
        number = int(self._model.joint(joint).id)
        body = int(self._model.jnt_bodyid[number])
        if int(self._model.body_jntnum[body]) > 1:
            return None
        turn = _turns(self._model.body_quat[body][None])[0]
        anchor, axis = self._model.jnt_pos[number], self._model.jnt_axis[number]
        return self._model.body_pos[body].copy(), turn, anchor.copy(), axis.copy()

    def carries(self, link: str) -> BoolArray:
        """Which joints move a link, (joints,)."""
        body, above = int(self._model.body(link).id), set()
        while body:
            above.add(body)
            body = int(self._model.body_parentid[body])
        return np.array([int(b) in above for b in self._model.jnt_bodyid[self._numbers]])

    def moving_link(self, name: str) -> str:
        """A link, or the last of the chain where it is none that a joint moves by itself."""
        known = [self._model.body(b).name for b in range(1, self._bodies)]
        return name if name in known else self.tip

    @property
    def limits(self) -> tuple[FloatArray, FloatArray]:
        """Least and largest position of each joint, (joints,) [rad or m]; a turn, or its reach,
        where the model has no limits.
        """
        own = self._numbers
        free = np.where(self.slides, self.reach_m, np.pi)[:, None] * np.array([-1.0, 1.0])
        limited = self._model.jnt_limited[own].astype(bool)[:, None]
        low, high = np.where(limited, self._model.jnt_range[own], free).T
        return low, high

    @property
    def top_speeds(self) -> FloatArray:
        """Velocity limits that a URDF states, (joints,) [rad/s or m/s]; infinite where none."""
        root = document_of(self.path)
        limits = [root.find(f"joint[@name='{name}']/limit") for name in self.joints]
        stated = [0.0 if one is None else float(one.get("velocity", 0.0)) for one in limits]
        return np.array([one if one > 0.0 else np.inf for one in stated])

    @property
    def _numbers(self) -> IntArray:
        return np.array([int(self._model.joint(name).id) for name in self.joints])

    @cached_property
    def _origins(self) -> FloatArray:
        """How each joint's frame is turned against the link before it, (joints, 3, 3)."""
        root = document_of(self.path)
        if root.tag != "robot":
            return _turns(self._model.body_quat[self._model.jnt_bodyid[self._numbers]])
        turned = []
        for name in self.joints:
            origin = root.find(f"joint[@name='{name}']/origin")
            text = "0 0 0" if origin is None else origin.get("rpy", "0 0 0")
            turned.append(Rotation.from_euler("xyz", [float(x) for x in text.split()]).as_matrix())
        return np.array(turned)

    def _moved(self, off: FloatArray) -> Any:
        """The model with its joints elsewhere; a joint turns about its own anchor."""
        model = copy.copy(self._model)
        for number, joint in enumerate(self._numbers):
            body, anchor = int(model.jnt_bodyid[joint]), model.jnt_pos[joint]
            before = _turns(model.body_quat[body][None])[0]
            parent = before @ self._origins[number].T
            after = parent @ Rotation.from_rotvec(off[number, 3:]).as_matrix() @ parent.T @ before
            x, y, z, w = Rotation.from_matrix(after).as_quat()
            model.body_pos[body] += parent @ off[number, :3] + before @ anchor - after @ anchor
            model.body_quat[body] = w, x, y, z
        return model

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
    def tip_m(self) -> float:
        """How far the last link goes on beyond its joint: twice to its own centre."""
        return 2.0 * float(np.linalg.norm(self._model.body(self.tip).ipos))

    @property
    def _bodies(self) -> int:
        return int(self._model.nbody)


def _turns(quaternions: FloatArray) -> FloatArray:
    """Rotations (n, 3, 3) of quaternions (n, 4), as MuJoCo writes them: w first."""
    turns: FloatArray = Rotation.from_quat(quaternions[:, [1, 2, 3, 0]]).as_matrix()
    return turns


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


NOISE_OF_EFFORT, BESIDE = 0.02, 0.3
"""Shares of what a joint usually needs: noise of its effort, and friction."""


def force_per_unit(
    drawn: FloatArray, needed: FloatArray, beside: FloatArray, own: BoolArray
) -> FloatArray:
    """Torque or force for one unit of each joint's effort, (joints,), 1 of one without rows.

    drawn, needed: efforts (n,) as recorded and as the model has them. beside: (n, k) what else may
    act, as friction. own: (n, joints) whether a row is of a joint.
    """
    squares = own.T @ needed**2 / np.maximum(own.sum(axis=0), 1)
    usual = own @ np.sqrt(np.maximum(squares, 1e-300))
    shapes = np.concatenate([own * drawn[:, None], beside], axis=1) / usual[:, None]
    size = np.sqrt(np.maximum(np.mean(shapes**2, axis=0), 1e-300))
    spread = np.repeat([1e6 * BESIDE, BESIDE], [own.shape[1], beside.shape[1]]) / size
    white = shapes * spread / NOISE_OF_EFFORT
    known = np.eye(len(spread)) + white.T @ white
    found = spread * np.linalg.solve(known, white.T @ (needed / usual / NOISE_OF_EFFORT))
    gains: FloatArray = np.where(own.any(axis=0), found[: own.shape[1]], 1.0)
    return gains


def _refuse_unsupported(path: Path, mujoco: ET.Element) -> None:
    """Loops and bodies that float."""
    if mujoco.find("equality/connect") is not None or mujoco.find("equality/weld") is not None:
        raise ConfigError(f"{path}: <equality> closes a loop, and a chain has none; leave it out")
    free = any(one.get("type") in ("free", "ball") for one in mujoco.iter("joint"))
    if free or mujoco.find(".//freejoint") is not None:
        raise ConfigError(
            f"{path}: has a free or ball joint; only joints that turn or slide are read"
        )
