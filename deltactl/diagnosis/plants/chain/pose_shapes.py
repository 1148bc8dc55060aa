"""What may be wrong with the poses of a chain, and what each size of it changes of the angles.

A key is the stem of an effect (`chain_poses`) and its joint. Only those directions of the geometry
are tried that base, targets and zeros of the joints do not span (Mooring, Roth and Driels 1991,
Fundamentals of Manipulator Calibration, chapter 3).
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from deltactl.diagnosis.observations.readings import FloatArray
from deltactl.diagnosis.plants.chain.pose_model import At, PoseModel, Shape, Shapes
from deltactl.diagnosis.plants.chain.pose_readings import last_way
from deltactl.models.effects.chain_poses import LATE, POSE_EFFECTS, SENSORS
from deltactl.models.robot import ChainRobot

UNKNOWN, GEOMETRY = "left", "geometry"
WHOLE_WAVES = {"wave": 1, "second": 2}
"""Waves a turn of a joint of those whose number is known."""
WAVES = (*WHOLE_WAVES, "gear")
ROUNDED = 1e-6
"""Part of a direction of length 1 that is rounding."""
NO_ERROR = 1e-9
"""Following error [rad, m] that is none."""


@dataclass(frozen=True, slots=True)
class PoseOptions:
    """What poses of an arm can tell."""

    spanned: float = 0.02
    """Share of a column that base, targets and zeros leave of it, below which they span it: a turn
    by a milliradian makes 0.02 mm there."""
    harmonics: tuple[int, int] = (3, 8)
    """Waves a turn of an error that has no name."""
    unknown_rad: float = 3e-4
    """Its usual size."""
    finest_waves: int = 240
    """Waves a turn of a joint that are searched for: two a turn of a motor behind a gear of 120."""
    least_load: float = 1e-3
    """Share of the largest load on any joint that is none."""
    same_angle: float = 1e-3
    """Share of its range within which a joint is at one angle: a grid of poses has few."""
    repeats: float = 2.0
    """Poses at each angle from which on they are a grid, between whose angles no wave is seen."""


POSES = PoseOptions()


class PoseShapes:
    """The shapes of all keys in some poses of a robot."""

    def __init__(self, robot: ChainRobot, model: PoseModel):
        self.robot, self.model, self.poses = robot, model, model.poses
        self.joints, self.slides = model.chain.joints, model.chain.slides
        self.made: Shapes = {}
        self.waves: dict[str, tuple[int, int]] = {}
        """Waves a turn of the gear's error at each joint, and among how many they were chosen."""
        self.free: tuple[str, ...] = ()
        """Keys that are always fitted and no finding."""
        self.spanned: dict[str, str] = {}
        """Keys that these poses cannot show, and why."""
        self.start = model.at(self.made, {})
        self.tops = self._tops()
        self._joint_by_joint()
        self._enter_known()

    def _tops(self) -> dict[str, float]:
        """Largest loads and moments on joints, to which sags are relative."""
        loads = {
            j: float(np.abs(self.start.placed.loads[:, i]).max()) for i, j in enumerate(self.joints)
        }
        across = {
            f"across {j}": float(np.abs(across_axis(self.start, i)).max())
            for i, j in enumerate(self.joints)
        }
        return loads | across

    def _joint_by_joint(self) -> None:
        """Enter all that may be wrong at a joint and changes in these poses."""
        heaviest = max(max(self.tops.values()), 1e-300)
        for j, joint in enumerate(self.joints):
            stems = ["home"]
            turns = not self.slides[j]
            if np.ptp(self.poses.at[:, j]) > 0.0:
                stems += ["ratio", *(["wave", "second", f"{UNKNOWN}angle"] if turns else [])]
            if self.tops[joint] > POSES.least_load * heaviest:
                stems += ["droop", "hang", f"{UNKNOWN}load"]
            if np.any(last_way(self.poses)[:, j]):
                stems.append("play")
            if self.poses.ahead is not None and np.any(np.abs(self.poses.ahead[:, j]) > NO_ERROR):
                stems.append("windup")
            for stem in stems:
                key = f"{stem} {joint}"
                if stem.startswith(UNKNOWN):
                    key = f"{UNKNOWN} {joint} {stem.removeprefix(UNKNOWN)}"
                self.made[key] = self.shape(key)
            if self.tops[f"across {joint}"] > POSES.least_load * heaviest:
                self.made[f"bend {joint}"] = self.shape(f"bend {joint}")
        if np.any(self.poses.step):
            self.made[f"rest {SENSORS}"] = self.shape(f"rest {SENSORS}")

    def shape(self, key: str) -> Shape:
        """What a key changes in these poses; of geometry all, of which directions are chosen."""
        stem, joint, _ = parts_of(key)
        if joint == SENSORS:
            return Shape({j: -step[:, None] for j, step in enumerate(self.poses.step.T)})
        j = self.joints.index(joint)
        if stem == GEOMETRY:
            return Shape(before={j: np.eye(6)})
        if stem == "bend":
            return Shape(about={j: across_axis(self.start, j)[:, :, None]})
        return Shape({j: self.angle(key)})

    def angle(self, key: str) -> FloatArray:
        """Change (n, k) of a joint's angle by the sizes of a key."""
        stem, joint, follows = parts_of(key)
        j = self.joints.index(joint)
        q, load = self.poses.at[:, j], self.start.placed.loads[:, j]
        if follows == "angle":
            waves = range(POSES.harmonics[0], POSES.harmonics[1] + 1)
            return np.concatenate([_wave(q, n) for n in waves], axis=1)
        if follows == "load":
            share = load / self.tops[joint]
            return np.stack([share**2, share**3], axis=1)
        if stem in WAVES:
            return _wave(q, WHOLE_WAVES.get(stem) or self.waves[joint][0])
        ahead = np.zeros_like(self.poses.at) if self.poses.ahead is None else self.poses.ahead
        plain = {
            "home": np.ones(len(q)), "ratio": q, "droop": load, "hang": 0.5 * np.sign(load),
            "play": 0.5 * last_way(self.poses)[:, j], "windup": ahead[:, j],
        }  # fmt: skip
        shape: FloatArray = plain[stem][:, None]
        return shape

    def find_directions(self, at: At) -> None:
        """Enter the directions of geometry that are not spanned, and note what is."""
        valid = self.model.valid
        basis = _Basis(np.concatenate([*self.model.placing(at).values()], axis=2)[valid])
        absolute = self.robot.zero == "absolute"
        for joint in self.joints:
            key = f"home {joint}"
            if not basis.takes(self.model.column(at, self.made, key)[valid]) and absolute:
                self.spanned[key] = "base and targets, whose places are not known, make up for it"
                del self.made[key]
        kept: dict[int, list[FloatArray]] = {j: [] for j in range(len(self.joints))}
        spread = POSE_EFFECTS[GEOMETRY].spread
        for part in (slice(0, 3), slice(3, 6)):
            for j in range(len(self.joints)):
                block = self.model.geometry(at, j)[valid][:, part]
                for direction in basis.directions(block).T:
                    whole = np.zeros(6)
                    whole[part] = spread * direction
                    kept[j].append(whole)
        for j, joint in enumerate(self.joints):
            key = f"{GEOMETRY} {joint}"
            if kept[j]:
                self.made[key] = Shape(before={j: np.stack(kept[j], axis=1)})
            else:
                self.spanned[key] = "base, targets and zeros of joints make up for it"
        if not absolute:
            self.free = tuple(f"home {joint}" for joint in self.joints)

    def spread(self, key: str) -> FloatArray:
        """Prior spreads (k,) of the sizes of a key, in SI units."""
        stem, joint, _ = parts_of(key)
        usual = POSES.unknown_rad if stem == UNKNOWN else POSE_EFFECTS[stem].spread
        if stem == GEOMETRY:
            usual = 1.0  # its directions have their spread already
        elif stem in ("droop", "bend"):
            usual /= self.tops[joint if stem == "droop" else f"across {joint}"]
        return np.full(self.made[key].count, usual)

    @property
    def named(self) -> list[str]:
        """Keys of all sizes that have a name."""
        return [key for key in self.made if not key.startswith(UNKNOWN)]

    def _enter_known(self) -> None:
        """What the effects of the robot file do, so that all that is found lies beyond it."""
        for entry in self.robot.effects:
            stem = next((k for k, e in POSE_EFFECTS.items() if e.name == entry.effect), "")
            if not stem or entry.component not in (*self.joints, SENSORS):
                continue
            values = {n: float(np.mean(v)) for n, v in entry.parameters.items()}
            size = POSE_EFFECTS[stem].from_file(values)
            if stem in WAVES:
                j = self.joints.index(entry.component)
                shape = Shape({j: _wave(self.poses.at[:, j], 2.0 * np.pi / values["period"])})
            else:
                shape = self.shape(f"{stem} {entry.component}")
            if stem == "rest" and self.poses.period_s:
                size = size + values.get(LATE, 0.0) / self.poses.period_s
            self.model.given.append((shape, size))

    def find_gear_waves(self, at: At) -> None:
        """For each joint the wave, finer than its own, that explains most of the residual."""
        left, valid = np.nan_to_num(at.left), self.model.valid
        for j, joint in enumerate(self.joints):
            q = self.poses.at[:, j]
            if self.slides[j] or not np.ptp(q) > 0.0:
                continue
            waves = np.arange(POSES.harmonics[0], POSES.finest_waves + 1)
            waves = waves[waves < _finest(q)]
            if len(waves):
                pull = np.sum(self.model.jacobian(at, j) * valid * left, axis=1)
                power = np.abs(np.exp(1j * np.outer(waves, q)) @ pull) ** 2
                self.waves[joint] = (int(waves[np.argmax(power)]), len(waves))
                self.made[f"gear {joint}"] = self.shape(f"gear {joint}")

    def take_over(self, other: PoseShapes) -> None:
        """The shapes of another recording's keys in these poses."""
        self.waves, self.tops, self.free = other.waves, other.tops, other.free
        self.made = {k: one if one.before else self.shape(k) for k, one in other.made.items()}


def parts_of(key: str) -> tuple[str, str, str]:
    """Stem, joint, and what it follows where it has no name."""
    stem, _, joint = key.partition(" ")
    if stem != UNKNOWN:
        return stem, joint, ""
    joint, _, follows = joint.rpartition(" ")
    return stem, joint, follows


def _wave(q: FloatArray, waves: float) -> FloatArray:
    """Sine and cosine of so many waves a turn, (n, 2)."""
    return np.stack([np.sin(waves * q), np.cos(waves * q)], axis=1)


def _finest(q: FloatArray) -> float:
    """Waves a turn that angles (n,) tell from coarser ones; any, where they are no grid."""
    span = float(np.ptp(q))
    angles = len(np.unique(np.round((q - q.min()) / (POSES.same_angle * span))))
    grid = len(q) > POSES.repeats * angles
    return np.pi * angles / span if grid else np.inf


def across_axis(at: At, joint: int) -> FloatArray:
    """Moment of the weight across a joint's axis, (n, 3) [N m]."""
    axis, moment = at.placed.axes[:, joint], at.placed.moments[:, joint]
    across: FloatArray = moment - axis * np.sum(axis * moment, axis=1)[:, None]
    return across


class _Basis:
    """What columns span, one block after another."""

    def __init__(self, columns: FloatArray):
        norms = np.maximum(np.linalg.norm(columns, axis=0), 1e-300)
        left, size, _ = np.linalg.svd(columns / norms, full_matrices=False)
        self._spans = left[:, size > POSES.spanned * size[0]]

    def takes(self, column: FloatArray) -> bool:
        """Whether a column (m, 1) is not spanned; then it is from now on."""
        return self.directions(column).shape[1] == 1

    def directions(self, block: FloatArray) -> FloatArray:
        """Directions (j, k) of a block (m, j) that are not spanned; then they are."""
        whole = max(float(np.linalg.norm(block, axis=0).max()), 1e-300)
        beyond = block - self._spans @ (self._spans.T @ block)
        left, size, right = np.linalg.svd(beyond, full_matrices=False)
        kept = size > POSES.spanned * whole
        self._spans = np.concatenate([self._spans, left[:, kept]], axis=1)
        directions: FloatArray = np.where(np.abs(right[kept]) < ROUNDED, 0.0, right[kept]).T
        return directions
