"""One recording of an arm as columns on an even grid, and its URDF as it is.

Imports nothing of deltactl. A case's `robot.json` states the joints in the order of the columns
and what one unit of each effort is at the joint; beside it lies `arm.urdf`.

All tools get the same low-pass (10 Hz, zero phase) of positions, speeds and efforts; accelerations
are the slopes of a cubic spline. Rows in which a joint is slower than a fiftieth of its usual speed
are left out, as no law of friction of these tools holds there.
"""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path
from xml.etree import ElementTree

import numpy as np
from scipy.signal import butter, sosfiltfilt

from benchmarks.rivals.axis_signals import SLOW, Array, Json, finding_of, rate, read, size_of

URDF = "arm.urdf"
CUT_HZ = 10.0
EDGE_S = 0.5
"""What the low-pass smears at both ends."""
DRAWN = 0.02
"""Share of an effort, or of the mass of all links, that a drawing leaves open."""
SURE_T = 4.0
POSITIVE = ("joint_friction", "viscous_friction", "inertia", "following_lag")
PARAMETERS = {
    "joint_friction": "torque",
    "viscous_friction": "coefficient",
    "inertia": "inertia",
    "effort_offset": "offset",
    "effort_gain": "scale",
    "following_lag": "dead_time",
    "payload": "mass",
}
"""Effect -> its size: the list of all tools, each at every joint, the payload at the last link."""


@dataclass(frozen=True)
class ArmRun:
    """One recording: positions, speeds, accelerations and efforts at the joints, all (n, joints).

    kept: rows to use (n,); dry, viscous: friction that the URDF states (joints,);
    links_kg, tip_kg: mass of all of its links and of the last one.
    """

    step_s: float
    q: Array
    v: Array
    a: Array
    effort: Array
    kept: np.ndarray[tuple[int], np.dtype[np.bool_]]
    joints: list[str]
    tip: str
    dry: Array
    viscous: Array
    links_kg: float
    tip_kg: float
    urdf: Path

    @property
    def rows(self) -> np.ndarray[tuple[int], np.dtype[np.int_]]:
        """Rows to use, as far apart as the low-pass leaves them independent."""
        every = max(1, int(0.5 / CUT_HZ / self.step_s))
        return np.flatnonzero(self.kept & (np.arange(len(self.kept)) % every == 0))


def arm_signals(file: Path, robot: Json) -> ArmRun:
    """A recording as the tools use it."""
    columns = read(file)
    t_s, joints = columns["t"], robot["joints"]
    step_s = float(np.median(np.diff(t_s)))
    even_s = np.arange(t_s[0], t_s[-1], step_s)
    sections = butter(4, min(2.0 * CUT_HZ * step_s, 0.9), output="sos")

    def smooth(name: str) -> Array:
        parts = [columns[f"{name}_{n}"] for n in range(1, len(joints) + 1)]
        even = [np.interp(even_s, t_s, part) for part in parts]
        passed: Array = sosfiltfilt(sections, np.column_stack(even), axis=0)
        return passed

    def slope(of: Array) -> Array:
        return np.column_stack([rate(column, step_s) for column in of.T])

    q = smooth("theta")
    v = smooth("velocity") if "velocity_1" in columns else slope(q)
    kept = (np.abs(v) > SLOW * np.quantile(np.abs(v), 0.98, axis=0)).all(axis=1)
    kept &= (even_s > even_s[0] + EDGE_S) & (even_s < even_s[-1] - EDGE_S)
    urdf = file.with_name(URDF)
    tree = ElementTree.parse(urdf).getroot()
    stated = {one.get("name"): one for one in tree.iter("joint")}
    friction = [stated[name].find("dynamics") for name in joints]
    dry, viscous = (
        np.array([0.0 if one is None else float(one.get(key, 0.0)) for one in friction])
        for key in ("friction", "damping")
    )
    tip = stated[joints[-1]].find("child")
    masses = [float(one.get("value", 0.0)) for one in tree.iter("mass")]
    named, effort = "" if tip is None else str(tip.get("link")), smooth("effort")
    effort *= np.array(robot["effort_gain"])
    weigh = sum(masses), masses[-1]
    return ArmRun(step_s, q, v, slope(v), effort, kept, joints, named, dry, viscous, *weigh, urdf)


def arm_finding(effect: str, place: str, value: float, half: float) -> Json:
    """In the form of the diagnosis."""
    return finding_of(effect, {PARAMETERS[effect]: size_of(value, half)}, place)


def least_size(run: ArmRun, effect: str, place: str) -> float:
    """What a drawing leaves open; of a lag a quarter of the rows' period."""
    if effect == "payload":
        return DRAWN * run.links_kg
    if effect == "following_lag":
        return 0.25 * run.step_s
    joint = run.joints.index(place)
    effort = float(np.sqrt(np.mean(run.effort[run.rows, joint] ** 2)))
    moved = {
        "viscous_friction": np.sqrt(np.mean(run.v[run.rows, joint] ** 2)),
        "inertia": np.sqrt(np.mean(run.a[run.rows, joint] ** 2)),
        "effort_gain": effort,
    }
    return float(DRAWN * effort / moved.get(effect, 1.0))


def sureness(run: ArmRun, name: tuple[str, str], term: float, error: float) -> float:
    """|t|, or less where the size is hardly beyond what the drawing leaves open."""
    size, least = term if name[0] in POSITIVE else abs(term), least_size(run, *name)
    return float(min(size / error, SURE_T * size / least))


def widening(left: Array) -> float:
    """Factor of standard errors: rows (n, joints) correlate with those before them."""
    off = left - left.mean(axis=0)
    r = float(np.clip((off[1:] * off[:-1]).sum() / (off**2).sum(), 0.0, 0.99))
    return float(np.sqrt((1.0 + r) / (1.0 - r)))
