"""The micro delta as MuJoCo bodies: arms on hinges, rods on universal joints, a sliding platform.

A forearm is a parallelogram of two rods that move alike: here one rod with the mass of both, and
the platform, which they keep level, slides in x, y and z only. `Rods.POINTS` is what the paper's
kind of model does instead: half a forearm's mass at its elbow, half at the platform, and a
distance constraint in between. Arm angle 0 is horizontal and positive is down, z is up.
"""

from __future__ import annotations

import enum

import mujoco
import numpy as np

from deltactl.proof.micro.as_built import MicroDelta

ARMS = (0, 1, 2)
PERIOD_S = 1e-4
"""The control loop's own period (10 kHz, section 5): one step of MuJoCo is one tick."""
LOOPS = 'solref="{time:.9g} 1" solimp="0.99999 0.99999 0.001"'
"""Stiff closed loops: a time constant of two steps, critically damped."""
DRY = 'solreffriction="{time:.9g} 1" solimpfriction="0.99999 0.99999 0.001"'
THIN_M = 0.002


class Rods(enum.Enum):
    """How the forearms are made."""

    BODIES = "bodies"
    POINTS = "points"


def build(
    robot: MicroDelta, rods: Rods = Rods.BODIES, period_s: float = PERIOD_S, dry: bool = True
) -> mujoco.MjModel:
    """Compile the robot. dry: with Coulomb friction. Raises ValueError for impossible figures."""
    arms = "".join(_arm(number, robot, rods, period_s, dry) for number in ARMS)
    loops = LOOPS.format(time=2.0 * period_s)
    if rods is Rods.BODIES:
        ties = "".join(f'<connect site1="end_{n}" site2="anchor_{n}" {loops}/>' for n in ARMS)
        ropes = ""
    else:
        ties = "".join(f'<tendon tendon1="rod_{n}" {loops}/>' for n in ARMS)
        ropes = "".join(_rope(number) for number in ARMS)
    motors = "".join(f'<motor name="motor_{n}" joint="arm_{n}"/>' for n in ARMS)
    text = f"""<mujoco model="micro">
  <compiler angle="radian" autolimits="true"/>
  <option timestep="{period_s:.9g}" gravity="0 0 -9.80665" integrator="implicitfast"
    solver="Newton" iterations="20" tolerance="1e-10" jacobian="dense">
    <flag contact="disable" island="disable"/>
  </option>
  <worldbody>{arms}{_platform(robot, rods)}</worldbody>
  <tendon>{ropes}</tendon>
  <equality>{ties}</equality>
  <actuator>{motors}</actuator>
</mujoco>"""
    model = mujoco.MjModel.from_xml_string(text)
    if rods is Rods.POINTS:
        # A tendon's equality holds it at its length in the first pose: say which length that is.
        model.tendon_length0[:] = robot.body.forearm_m
    return model


def _arm(number: int, robot: MicroDelta, rods: Rods, period_s: float, dry: bool) -> str:
    body, drives = robot.body, robot.drives
    azimuth = 2.0 * np.pi * number / 3.0
    x, y = body.base_radius_m * np.cos(azimuth), body.base_radius_m * np.sin(azimuth)
    length, rub = body.upper_arm_m, drives.dry_nm()[number] if dry else 0.0
    joint = f"""<joint name="arm_{number}" type="hinge" axis="0 1 0"
        armature="{drives.armature_kgm2()[number]:.12g}" frictionloss="{rub:.12g}"
        damping="{drives.drag_nmsprad()[number]:.12g}" {DRY.format(time=2.0 * period_s)}/>"""
    rod = _rod(number, robot) if rods is Rods.BODIES else _elbow(robot)
    return f"""
    <body name="arm_{number}" pos="{x:.12g} {y:.12g} 0" euler="0 0 {azimuth:.12g}">
      {joint}{_bar(body.upper_arm_kg, length, "x")}<site name="elbow_{number}" pos="{length} 0 0"/>
      {rod}
    </body>"""


def _rod(number: int, robot: MicroDelta) -> str:
    body = robot.body
    return f"""<body name="rod_{number}" pos="{body.upper_arm_m:.12g} 0 0">
        <joint name="swing_{number}" type="hinge" axis="0 1 0"/>
        <joint name="lean_{number}" type="hinge" axis="1 0 0"/>
        {_bar(body.forearm_kg, body.forearm_m, "z")}
        <site name="end_{number}" pos="0 0 {-body.forearm_m:.12g}"/>
      </body>"""


def _elbow(robot: MicroDelta) -> str:
    body = robot.body
    half = 0.5 * body.forearm_kg
    return f"""<body pos="{body.upper_arm_m:.12g} 0 0">
        <inertial pos="0 0 0" mass="{half:.9g}" diaginertia="1e-12 1e-12 1e-12"/></body>"""


def _bar(mass_kg: float, length_m: float, along: str) -> str:
    """A thin uniform bar that starts at its joint."""
    across, thin = mass_kg * length_m**2 / 12.0, mass_kg * THIN_M**2 / 12.0
    middle = f"{0.5 * length_m:.12g} 0 0" if along == "x" else f"0 0 {-0.5 * length_m:.12g}"
    inertia = (thin, across, across) if along == "x" else (across, across, thin)
    diagonal = " ".join(f"{value:.9g}" for value in inertia)
    return f'<inertial pos="{middle}" mass="{mass_kg:.9g}" diaginertia="{diagonal}"/>'


def _platform(robot: MicroDelta, rods: Rods) -> str:
    body = robot.body
    mass = body.platform_kg + body.payload_kg
    if rods is Rods.POINTS:
        mass += 1.5 * body.forearm_kg
    azimuths = [2.0 * np.pi * number / 3.0 for number in ARMS]
    anchors = "".join(
        f'<site name="anchor_{n}" pos="{body.platform_radius_m * np.cos(a):.12g}'
        f' {body.platform_radius_m * np.sin(a):.12g} 0"/>'
        for n, a in zip(ARMS, azimuths, strict=True)
    )
    slides = "".join(
        f'<joint name="slide_{name}" type="slide" axis="{axis}"/>'
        for name, axis in (("x", "1 0 0"), ("y", "0 1 0"), ("z", "0 0 1"))
    )
    return f"""
    <body name="platform">{slides}
      <inertial pos="0 0 0" mass="{mass:.9g}" diaginertia="1e-6 1e-6 1e-6"/>{anchors}
    </body>"""


def _rope(number: int) -> str:
    return (
        f'<spatial name="rod_{number}"><site site="elbow_{number}"/>'
        f'<site site="anchor_{number}"/></spatial>'
    )
