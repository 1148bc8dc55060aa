"""Arms and single axes with effort by mujoco.sysid 4.0, by MuJoCo's inverse dynamics.

Imports nothing of deltactl. A forward simulation that is driven by the recorded effort leaves the
recorded motion within seconds; so the residual is the effort less what `mj_inverse` asks for at the
recorded motion, both low-passed as in arm_signals.py and axis_signals.py. The optimizer is
mujoco's own. Sizes have the intervals of `calculate_intervals`, widened by the correlation of what
is left.

Protocol of arms: the model is the URDF as MuJoCo reads it. Open are of each joint friction loss,
damping, armature, a constant force, a gain (0.2 to 5) and a dead time (0 to 0.2 s), and of the last
link a mass with its moments and inertias. Each joint is weighted by the residual of a first fit.
Protocol of axes: one hinge with the file's inertia; the weight of the file and a recorded load are
taken off the effort. Open are the same but for the gain, which inertia and friction together are;
commanded axes have no effort, and their errors are no parameters of bodies.

`sysid, true set` opens what is off and states its sizes; healthy machines, and what the list has
not, are left out. `sysid, all` opens the list; a size of |t| > 4 is a name, under the rules of
arm_tools.py on an arm and above zero for friction, damping, armature and lag.
"""

from __future__ import annotations

import contextlib
import copy
import importlib
import io
import json
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from functools import partial
from pathlib import Path
from typing import Any

import numpy as np

from benchmarks.rivals.arm_signals import (
    POSITIVE,
    SURE_T,
    ArmRun,
    arm_finding,
    least_size,
    sureness,
    widening,
)
from benchmarks.rivals.axis_signals import Array, Json, Signals, finding_of

TOLD = "sysid, true set"
FINE_S = 1e-4
"""Step of the model: MuJoCo's dry friction yields over two of them."""
LATEST_S = 0.2
SMALL = 1e-3
"""Share of the last link's mass that changes its efforts, and leaves it a possible body."""
LOAD = ("payload", "mx", "my", "mz", "Ixx", "Ixy", "Iyy", "Ixz", "Iyz", "Izz")
"""Mass, moments and inertias of a load about the frame of the last link."""
WIDE = 100.0
"""Bounds, in units of sizes that a drawing leaves open, of what has none."""
CHANGE = 0.01
"""Step of finite differences, in those."""
Entry = tuple[str, str]
"""Effect and place."""
Values = Mapping[Entry, float]


@dataclass(frozen=True)
class Open:
    """One parameter: the unit that the optimizer sees, its least and largest size."""

    unit: float
    low: float
    high: float

    @property
    def start(self) -> float:
        """Off the healthy size where that is a bound."""
        return self.unit if self.low == 0.0 else 0.0


@dataclass(frozen=True)
class Plant:
    """What the optimizer moves: rows (n, joints) of a motion and an effort."""

    model: Any
    motion: tuple[Array, Array, Array]
    effort: Callable[[Array], Array]
    """Measured effort (n, joints), so late at each joint [s]."""
    joints: Sequence[str]
    dry: Array
    viscous: Array
    rotor: Array
    pull: Array
    """Known to act beside the model (n, joints)."""
    load: Array
    """What one unit of each term of a load asks for (terms, n, joints)."""

    def misses(self, values: Values) -> Array:
        """Measured effort less what the model asks for (n, joints)."""
        of = partial(self._of, values=values)
        model = self.model
        model.dof_frictionloss[:] = self.dry + of("joint_friction")
        model.dof_damping[:] = self.viscous + of("viscous_friction")
        model.dof_armature[:] = self.rotor + of("inertia")
        asked = _asked(model, self.motion) + self.pull + of("effort_offset")
        if len(self.load):
            terms = [sum(v for (name, _), v in values.items() if name == one) for one in LOAD]
            asked = asked + np.tensordot(terms, self.load, 1)
        off: Array = self.effort(of("following_lag")) - asked / (1.0 + of("effort_gain"))
        return off

    def _of(self, name: str, values: Values) -> Array:
        return np.array([values.get((name, joint), 0.0) for joint in self.joints])


def _asked(model: Any, motion: tuple[Array, ...]) -> Array:
    """Efforts (n, joints) by inverse dynamics."""
    mujoco: Any = importlib.import_module("mujoco")
    data = mujoco.MjData(model)
    # A hinge alone keeps its inertia there.
    mujoco.mj_setConst(model, data)
    asked = np.empty_like(motion[0])
    for row, (data.qpos[:], data.qvel[:], data.qacc[:]) in enumerate(zip(*motion, strict=True)):
        mujoco.mj_inverse(model, data)
        asked[row] = data.qfrc_inverse
    return asked


def _load_columns(model: Any, motion: tuple[Array, ...]) -> Array:
    """Efforts are linear in the terms of a load: what a small one of each asks for."""
    bare, size = _asked(model, motion), SMALL * float(model.body_mass[-1])
    found = []
    for place in range(len(LOAD)):
        other, load = copy.copy(model), np.zeros(len(LOAD))
        load[place] = size * (1.0 if place == 0 else 0.01)
        _loaded(other, load)
        found.append((_asked(other, motion) - bare) / load[place])
    return np.array(found)


def _loaded(model: Any, load: Array) -> None:
    """Add mass, moments and inertias (10,) to the last body of a model."""
    mujoco: Any = importlib.import_module("mujoco")
    turned = np.empty(9)
    mujoco.mju_quat2Mat(turned, model.body_iquat[-1])
    turn, mass, at = turned.reshape(3, 3), model.body_mass[-1], model.body_ipos[-1].copy()
    xx, xy, yy, xz, yz, zz = load[4:]
    about = turn @ np.diag(model.body_inertia[-1]) @ turn.T + mass * _spread(at)
    about += np.array([[xx, xy, xz], [xy, yy, yz], [xz, yz, zz]])
    whole = mass + load[0]
    centre = (mass * at + load[1:4]) / whole
    sizes, axes = np.linalg.eigh(about - whole * _spread(centre))
    axes[:, 2] *= np.linalg.det(axes)
    model.body_mass[-1], model.body_ipos[-1], model.body_inertia[-1] = whole, centre, sizes
    mujoco.mju_mat2Quat(model.body_iquat[-1], axes.ravel())


def _spread(at: Array) -> Array:
    """Inertia (3, 3) of a unit mass at a place."""
    made: Array = (at @ at) * np.eye(3) - np.outer(at, at)
    return made


def identified(plant: Plant, opened: Mapping[Entry, Open], fits: int = 2) -> tuple[Values, Values]:
    """Sizes and half widths of their intervals; a gain is stated less 1."""
    sysid: Any = importlib.import_module("mujoco.sysid")
    importlib.import_module("absl.logging").set_verbosity("error")
    weight = 1.0 / np.sqrt(np.mean(plant.misses({}) ** 2, axis=0))
    begin = {entry: own.start / own.unit for entry, own in opened.items()}
    units = np.array([own.unit for own in opened.values()])

    def left(x: Array) -> Array:
        return plant.misses(dict(zip(opened, (units * x).tolist(), strict=True)))

    def misses(x: Array, _: Any) -> Any:
        points = np.asarray(x).reshape(len(units), -1).T
        return [np.column_stack([(left(point) * weight).ravel() for point in points])], None, None

    for _ in range(fits):
        sizes = sysid.ParameterDict()
        for entry, own in opened.items():
            limits = own.low / own.unit, own.high / own.unit
            sizes.add(sysid.Parameter(" ".join(entry), begin[entry], *limits))
        # It prints every step, whatever `verbose` says.
        with contextlib.redirect_stdout(io.StringIO()):
            how = {"optimizer": "mujoco", "max_iters": 20, "eps": CHANGE, "xtol": 1e-5}
            best, result = sysid.optimize(sizes, misses, verbose=False, **how)
        x = np.asarray(best.as_vector(), dtype=np.float64)
        off = left(x)
        begin = dict(zip(opened, x.tolist(), strict=True))
        scaled = (off * weight).ravel()
        _, halves = sysid.calculate_intervals([scaled], result.jac)
        widen = widening(off * weight)
        weight = 1.0 / np.sqrt(np.mean(off**2, axis=0))
    wide = widen * units * np.ravel(halves)
    return (
        dict(zip(opened, (units * x).tolist(), strict=True)),
        dict(zip(opened, wide.tolist(), strict=True)),
    )


def _told(folder: Path) -> list[Entry]:
    text = folder.parent.with_name(f"{folder.parent.name}-told.json").read_text(encoding="utf-8")
    names = json.loads(text)[folder.name.split(".")[0]]
    return [(name.split()[0], name.split()[1]) for name in names]


def by_sysid_of_arms(tool: str, run: ArmRun, folder: Path) -> list[Json] | None:
    """Findings; None for a case that the tool does not take."""
    lists = _open_of_arm(run)
    told = _told(folder) if tool == TOLD else list(lists)
    if not told or set(told) - set(lists):
        return None
    load = [(name, run.tip) for name in LOAD] if ("payload", run.tip) in told else []
    opened = {entry: lists[entry] for entry in dict.fromkeys([*told, *load])}
    values, halves = identified(_arm(run), opened)
    return [
        arm_finding(*entry, values[entry] + (entry[0] == "effort_gain"), halves[entry])
        for entry in told
        if entry[0] not in LOAD[1:]
        and (tool == TOLD or sureness(run, entry, values[entry], halves[entry] / 1.96) > SURE_T)
    ]


def _open_of_arm(run: ArmRun) -> dict[Entry, Open]:
    """The list."""
    found: dict[Entry, Open] = {}
    for j, name in enumerate(run.joints):
        lows = {"joint_friction": -run.dry[j], "viscous_friction": -run.viscous[j], "inertia": 0.0}
        for effect in ("joint_friction", "viscous_friction", "inertia", "effort_offset"):
            unit = least_size(run, effect, name)
            found[effect, name] = Open(unit, lows.get(effect, -WIDE * unit), WIDE * unit)
        found["effort_gain", name] = Open(0.02, -0.8, 4.0)
        found["following_lag", name] = Open(1e-3, 0.0, LATEST_S)
    mass = least_size(run, "payload", run.tip)
    for place, name in enumerate(LOAD):
        unit = mass * (1.0 if place == 0 else 0.1 if place < 4 else 0.01)
        low = -0.5 * run.tip_kg if place == 0 else -WIDE * unit
        found[name, run.tip] = Open(unit, low, WIDE * unit)
    return found


def _arm(run: ArmRun) -> Plant:
    mujoco: Any = importlib.import_module("mujoco")
    model = mujoco.MjSpec.from_file(str(run.urdf)).compile()
    rows, t_s = run.rows, run.step_s * np.arange(len(run.q))

    def effort(late_s: Array) -> Array:
        pairs = zip(late_s, run.effort.T, strict=True)
        return np.column_stack([np.interp(t_s[rows] - late, t_s, one) for late, one in pairs])

    motion = run.q[rows], run.v[rows], run.a[rows]
    none = np.zeros(len(run.joints))
    load = _load_columns(_free(model), motion)
    return Plant(model, motion, effort, run.joints, run.dry, run.viscous, none, none, load)


def _free(model: Any) -> Any:
    """Without contacts and limits, and with dry friction that hardly yields."""
    mujoco: Any = importlib.import_module("mujoco")
    flags = mujoco.mjtDisableBit
    model.opt.disableflags |= int(flags.mjDSBL_CONTACT) | int(flags.mjDSBL_LIMIT)
    model.opt.timestep = FINE_S
    model.dof_solref[:] = (2.0 * FINE_S, 1.0)
    return model


_AXIS = {"dead_time": "total"}
HINGE = """<mujoco><option gravity="0 0 0"/><worldbody><body><joint type="hinge" axis="0 0 1"/>
<inertial pos="0 0 0" mass="1" diaginertia="1e-9 1e-9 1e-9"/></body></worldbody></mujoco>"""


def by_sysid_of_axes(tool: str, given: Signals, folder: Path) -> list[Json] | None:
    """Findings; None for a case that the tool does not take."""
    if "inertia" not in given.sets:
        return None
    mujoco: Any = importlib.import_module("mujoco")
    stated, force = float(given.sets["inertia"]), 0.02 * float(np.abs(given.y).max()) + 1e-12
    slow = force / float(np.std(given.v))
    lists = {
        "joint_friction": Open(force, 0.0, WIDE * force),
        "viscous_friction": Open(slow, 0.0, WIDE * slow),
        "inertia": Open(0.02 * stated, -0.8 * stated, 4.0 * stated),
        "effort_offset": Open(force, -WIDE * force, WIDE * force),
        "effort_gain": Open(0.02, -0.8, 4.0),
        "following_lag": Open(1e-3, 0.0, 0.5),
    }
    told = (
        [name for name, _ in _told(folder)]
        if tool == TOLD
        else [name for name in lists if name != "effort_gain"]
    )
    if not told or set(told) - set(lists):
        return None
    kept, t_s = given.kept, given.step_s * np.arange(len(given.y))
    pull = (given.known - stated * given.a)[kept, None]

    def effort(late_s: Array) -> Array:
        return np.interp(t_s[kept] - late_s[0], t_s, given.y)[:, None]

    motion = given.x[kept, None], given.v[kept, None], given.a[kept, None]
    none, axis = np.zeros(1), "axis"
    model, rotor = _free(mujoco.MjModel.from_xml_string(HINGE)), np.array([stated])
    plant = Plant(model, motion, effort, [axis], none, none, rotor, pull, np.empty(0))
    opened = {(name, axis): lists[name] for name in told}
    values, halves = identified(plant, opened, fits=1)
    found: list[Json] = []
    for name in told:
        size, half = values[name, axis], halves[name, axis]
        sure = (size if name in POSITIVE and name != "inertia" else abs(size)) * 1.96 / half
        if tool == TOLD or sure > SURE_T:
            size += {"effort_gain": 1.0, "inertia": stated}.get(name, 0.0)
            one = arm_finding(name, axis, size, half)
            sizes = {_AXIS.get(key, key): own for key, own in one["parameters"].items()}
            found.append(finding_of(name, sizes))
    return found
