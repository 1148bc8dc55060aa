"""The delta as MuJoCo bodies: three arms on hinges, six rods, a free platform, closed loops.

Each rod hangs on its arm in a universal joint (a ball joint without the idle spin of the rod
about itself) and is held to the platform by a `connect` constraint, so the platform stays
level only because the rods make it. Coordinates: robot frame of the contract, z up, arm angle
0 is horizontal and positive is down. The hinge is the local y axis, along which a positive
turn lowers an arm that points along local x.
"""

from __future__ import annotations

import mujoco
import numpy as np

from deltactl.foundation.errors import UnreachablePoint
from deltactl.proof.robot.as_built import YIELDS_NM_PER_RAD, Body, FloatArray, Joints

ARMS = (1, 2, 3)
SIDES = ("a", "b")
CONSTRAINT = 'solref="{time:.6f} 1" solimp="0.9999 0.9999 0.0001"'
"""Stiff closed loops: a time constant of two steps, and 1e-4 of the force for softness."""
ROD_DRAG_NMS_PER_RAD = 1e-4
PAD_M = 0.01
PUSHES = "".join(
    f'<general site="push" gear="{way} 0 0 0"/>' for way in ("1 0 0", "0 1 0", "0 0 1")
)
"""Forces from outside, each as large as its control [N]; the platform stays level."""


def build(body: Body, joints: Joints, timestep_s: float) -> mujoco.MjModel:
    """Compile the robot. Raises ValueError from MuJoCo for impossible figures (negative mass)."""
    loops = CONSTRAINT.format(time=2.0 * timestep_s)
    arms = "".join(_arm(number, body, joints, loops) for number in ARMS)
    equalities = "".join(
        f'<connect site1="rod_end_{arm}{side}" site2="anchor_{arm}{side}" {loops}/>'
        for arm in ARMS
        for side in SIDES
    )
    actuators = "".join(_gear(number, joints) for number in ARMS)
    if joints.yields_at_nm is not None:
        actuators += "".join(_mount(number, joints) for number in ARMS)
    if body.pulls:
        actuators += PUSHES
    text = f"""<mujoco model="delta">
  <compiler angle="radian" autolimits="true"/>
  <option timestep="{timestep_s}" gravity="0 0 -9.81" integrator="implicitfast"
    solver="Newton" iterations="20" tolerance="1e-12" cone="pyramidal" jacobian="dense">
    <flag eulerdamp="disable" {"" if body.table_height_m is not None else 'contact="disable"'}/>
  </option>
  <worldbody>{arms}{_platform(body, loops)}{_table(body, loops)}</worldbody>
  <equality>{equalities}</equality>
  <actuator>{actuators}</actuator>
</mujoco>"""
    return mujoco.MjModel.from_xml_string(text)


def _arm(number: int, body: Body, joints: Joints, loops: str) -> str:
    i = number - 1
    azimuth, length = body.azimuth_rad[i], body.upper_arm_m[i]
    x, y = body.base_radius_m[i] * np.cos(azimuth), body.base_radius_m[i] * np.sin(azimuth)
    half = 0.5 * body.rod_distance_m
    rods = "".join(
        _rod(f"{number}{side}", length, shift, body.forearm_m[i], 0.5 * body.forearm_kg)
        for side, shift in zip(SIDES, (-half, half), strict=True)
    )
    return f"""
    <body name="arm_{number}" pos="{x:.12g} {y:.12g} 0" euler="0 0 {azimuth:.12g}">
      <joint name="arm_{number}" type="hinge" axis="0 1 0" armature="{joints.hub_kgm2}"
        damping="{joints.drag_nms_per_rad[i]:.9g}" frictionloss="{joints.friction_nm[i]:.9g}"
        solreffriction="0.002 1" solimpfriction="0.9999 0.9999 0.001"/>
      {_bar(body.upper_arm_kg, length, "x")}{rods}
    </body>"""


def _rod(name: str, arm_m: float, shift_m: float, length_m: float, mass_kg: float) -> str:
    return f"""
      <body name="rod_{name}" pos="{arm_m:.12g} {shift_m:.12g} 0">
        <joint name="swing_{name}" type="hinge" axis="0 1 0" damping="{ROD_DRAG_NMS_PER_RAD}"/>
        <joint name="lean_{name}" type="hinge" axis="1 0 0" damping="{ROD_DRAG_NMS_PER_RAD}"/>
        {_bar(mass_kg, length_m, "z")}
        <site name="rod_end_{name}" pos="0 0 {-length_m:.12g}"/>
      </body>"""


def _bar(mass_kg: float, length_m: float, along: str) -> str:
    """A thin straight bar that starts at its joint."""
    across, thin = mass_kg * length_m**2 / 12.0, mass_kg * 0.01**2
    middle = f"{0.5 * length_m:.9g} 0 0" if along == "x" else f"0 0 {-0.5 * length_m:.9g}"
    inertia = (thin, across, across) if along == "x" else (across, across, thin)
    diagonal = " ".join(f"{value:.9g}" for value in inertia)
    return f'<inertial pos="{middle}" mass="{mass_kg:.9g}" diaginertia="{diagonal}"/>'


def _platform(body: Body, loops: str) -> str:
    half, mass = 0.5 * body.rod_distance_m, body.platform_kg + body.payload_kg
    sites = ""
    for number in ARMS:
        azimuth, radius = body.azimuth_rad[number - 1], body.platform_radius_m[number - 1]
        out = np.array([np.cos(azimuth), np.sin(azimuth)])
        along = np.array([-out[1], out[0]])
        for side, shift in zip(SIDES, (-half, half), strict=True):
            x, y = radius * out + shift * along
            sites += f'<site name="anchor_{number}{side}" pos="{x:.12g} {y:.12g} 0"/>'
    across = 0.5 * mass * 0.075**2
    pad = f'<geom type="sphere" size="{PAD_M}" mass="0" {loops}/>'
    return f"""
    <body name="platform" pos="0 0 -0.45">
      <freejoint name="platform"/>
      <inertial pos="0 0 0" mass="{mass:.9g}"
        diaginertia="{across:.9g} {across:.9g} {2 * across:.9g}"/>
      {pad if body.table_height_m is not None else ""}{sites}{_target(body)}
      {'<site name="push"/>' if body.pulls else ""}
    </body>"""


def _target(body: Body) -> str:
    """What the sensors look at: a light plate, on springs where the robot rings."""
    if body.ringing_hz is None:
        return ""
    mass = 0.02
    stiffness = mass * (2.0 * np.pi * body.ringing_hz) ** 2
    damping = 2.0 * body.ringing_damping * np.sqrt(stiffness * mass)
    slides = "".join(
        f'<joint type="slide" axis="{axis}" stiffness="{stiffness:.9g}" damping="{damping:.9g}"/>'
        for axis in ("1 0 0", "0 1 0", "0 0 1")
    )
    return f"""<body name="target" gravcomp="1">{slides}
      <inertial pos="0 0 0" mass="{mass}" diaginertia="1e-6 1e-6 1e-6"/></body>"""


def _table(body: Body, loops: str) -> str:
    if body.table_height_m is None:
        return ""
    return f"""<geom name="table" type="plane" size="1 1 0.1" friction="1 0 0" condim="3"
      pos="0 0 {body.table_height_m - PAD_M:.9g}" {loops}/>"""


def _gear(number: int, joints: Joints) -> str:
    """Two flanks, each a spring that can only push: the dead band lies between their controls."""
    k = joints.stiffness_nm_per_rad[number - 1]
    limit_nm = joints.limit_nm
    if joints.yields_at_nm is not None and _stiff(number, joints):
        limit_nm = joints.yields_at_nm
    return _flanks(f"gear_{number}", number, k, damping_of(k, joints.hub_kgm2), limit_nm)


def _mount(number: int, joints: Joints) -> str:
    """What goes on pushing, less stiffly, once a stiff gear has given way."""
    k = YIELDS_NM_PER_RAD if _stiff(number, joints) else 0.0
    return _flanks(f"mount_{number}", number, k, 0.0, joints.limit_nm)


def _stiff(number: int, joints: Joints) -> bool:
    return bool(joints.stiffness_nm_per_rad[number - 1] > YIELDS_NM_PER_RAD)


def _flanks(name: str, number: int, k: float, c: float, limit_nm: float) -> str:
    pair = ""
    for flank, limits in (("lower", f"0 {limit_nm}"), ("upper", f"-{limit_nm} 0")):
        pair += f"""<general name="{name}_{flank}" joint="arm_{number}" gaintype="fixed"
          biastype="affine" gainprm="{k:.9g}" biasprm="0 {-k:.9g} {-c:.9g}"
          forcelimited="true" forcerange="{limits}"/>"""
    return pair


def damping_of(stiffness_nm_per_rad: float, hub_kgm2: float) -> float:
    """Damping of the teeth [N m s/rad]: half of critical with the hub and as much again."""
    return float(np.sqrt(2.0 * stiffness_nm_per_rad * hub_kgm2))


LOOPS = tuple(f"{arm}{side}" for arm in (1, 2, 3) for side in ("a", "b"))
PRECISE_M = 1e-10
ROUNDS = 60


class Assembly:
    """Closes the loops for fixed arm angles by Gauss-Newton on the rods' ends.

    MuJoCo says where the rods end and how that changes with each joint; the arms stay put.
    """

    def __init__(self, model: mujoco.MjModel) -> None:
        self.model, self.data = model, mujoco.MjData(model)
        self.ends = [model.site(f"rod_end_{loop}").id for loop in LOOPS]
        self.anchors = [model.site(f"anchor_{loop}").id for loop in LOOPS]
        arms = [int(model.joint(f"arm_{arm}").dofadr[0]) for arm in (1, 2, 3)]
        self.arms_q = [int(model.joint(f"arm_{arm}").qposadr[0]) for arm in (1, 2, 3)]
        self.free = np.setdiff1d(np.arange(model.nv), arms)

    def at(self, arm_rad: FloatArray, guess: FloatArray | None = None) -> FloatArray:
        """The whole pose for arm angles (3,). Raises UnreachablePoint when it will not close."""
        model, data = self.model, self.data
        data.qpos[:] = model.qpos0 if guess is None else guess
        data.qpos[self.arms_q] = arm_rad
        for _ in range(ROUNDS):
            mujoco.mj_kinematics(model, data)
            mujoco.mj_comPos(model, data)
            gap = (data.site_xpos[self.ends] - data.site_xpos[self.anchors]).ravel()
            if np.abs(gap).max() < PRECISE_M:
                return np.array(data.qpos)
            change = np.linalg.lstsq(self._slope()[:, self.free], -gap, rcond=None)[0]
            step = np.zeros(model.nv)
            step[self.free] = change * min(1.0, 0.3 / max(float(np.abs(change).max()), 1e-12))
            mujoco.mj_integratePos(model, data.qpos, step, 1.0)
        raise UnreachablePoint(
            f"the robot cannot be assembled at arm angles {np.degrees(arm_rad).round(2).tolist()}"
            " degrees; its lengths or the angles are too far from possible"
        )

    def platform_m(self, arm_rad: FloatArray, guess: FloatArray | None = None) -> FloatArray:
        """Position of the platform's middle for rigid joints, shape (3,)."""
        pose = self.at(arm_rad, guess)
        start = int(self.model.joint("platform").qposadr[0])
        return pose[start : start + 3]

    def _slope(self) -> FloatArray:
        model, data = self.model, self.data
        rows = np.zeros((3 * len(LOOPS), model.nv))
        one, other = np.zeros((3, model.nv)), np.zeros((3, model.nv))
        for row, (end, anchor) in enumerate(zip(self.ends, self.anchors, strict=True)):
            mujoco.mj_jacSite(model, data, one, None, end)
            mujoco.mj_jacSite(model, data, other, None, anchor)
            rows[3 * row : 3 * row + 3] = one - other
        return rows
