"""What may be wrong with the poses of a chain, and what each size of it changes of the angles.

A key is the stem of an effect (`chain_poses`) and its joint. Only those directions of the geometry
are tried that base, targets and zeros of the joints do not span (Mooring, Roth and Driels 1991,
Fundamentals of Manipulator Calibration, chapter 3).
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from deltactl.diagnosis.observations.readings import FloatArray
from deltactl.diagnosis.plants.chain.pose_model import At, PoseModel, Shape
from deltactl.diagnosis.plants.chain.pose_readings import last_way
from deltactl.models.effects.chain_poses import LATE, POSE_EFFECTS, SENSORS
from deltactl.models.robot import ChainRobot

GEOMETRY = "geometry"
UNKNOWNS = {"left_angle": "angle", "left_load": "load"}
"""Stems of errors that have no name, and what they follow."""
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
        self.waves: dict[str, tuple[int, int]] = {}
        """Waves a turn of the gear's error at each joint, and among how many they were chosen."""
        self.free: tuple[str, ...] = ()
        """Keys that are always fitted and no finding."""
        self.spanned: dict[str, str] = {}
        """Keys that these poses cannot show, and why."""
        placed = model.at({}).placed
        self._loads, along = placed.loads, np.sum(placed.axes * placed.moments, axis=2)
        self._across = placed.moments - placed.axes * along[:, :, None]
        """Moments of the weight across the joints' axes, (n, joints, 3) [N m]."""
        self.tops = {
            "droop": np.abs(self._loads).max(axis=0),
            "bend": np.abs(self._across).max(axis=(0, 2)),
        }
        """Largest loads and moments (joints,), to which sags are relative."""
        every = self._every()
        self.model.shapes = {key: shape for key, shape in every.items() if shape.acts}
        self._enter_known(every)

    def _every(self) -> dict[str, Shape]:
        """All that may be wrong; of geometry all, of which directions are chosen."""
        heaviest = max(*(float(top.max()) for top in self.tops.values()), 1e-300)
        weighs = {stem: top > POSES.least_load * heaviest for stem, top in self.tops.items()}
        found: dict[str, Shape] = {}
        for j, joint in enumerate(self.joints):
            for stem, (acts, angle) in self._angles(j, bool(weighs["droop"][j])).items():
                found[f"{stem} {joint}"] = Shape({j: angle.reshape(len(angle), -1)}, acts=acts)
            across = {j: self._across[:, j, :, None]}
            found[f"bend {joint}"] = Shape(about=across, acts=bool(weighs["bend"][j]))
            found[f"{GEOMETRY} {joint}"] = Shape(before={j: np.eye(6)}, acts=False)
        late = {j: -step[:, None] for j, step in enumerate(self.poses.step.T)}
        return found | {f"rest {SENSORS}": Shape(late, acts=bool(np.any(self.poses.step)))}

    def _angles(self, j: int, weighs: bool) -> dict[str, tuple[bool, FloatArray]]:
        """Changes (n,) or (n, k) of a joint's angle, and whether there are any."""
        q, load, way = self.poses.at[:, j], self._loads[:, j], last_way(self.poses)[:, j]
        ahead = self.poses.ahead[:, j]
        share = load / max(self.tops["droop"][j], 1e-300)
        moves = bool(np.ptp(q) > 0.0)
        turns = moves and not self.slides[j]
        first, last = POSES.harmonics
        rough = np.concatenate([_wave(q, n) for n in range(first, last + 1)], axis=1)
        found = {
            "home": (True, np.ones(len(q))),
            "ratio": (moves, q),
            **{stem: (turns, _wave(q, waves)) for stem, waves in WHOLE_WAVES.items()},
            "left_angle": (turns, rough),
            "droop": (weighs, load),
            "hang": (weighs, 0.5 * np.sign(load)),
            "left_load": (weighs, np.stack([share**2, share**3], axis=1)),
            "play": (bool(np.any(way)), 0.5 * way),
            "windup": (bool(np.any(np.abs(ahead) > NO_ERROR)), ahead),
        }
        finer = self.waves.get(self.joints[j])
        return found | ({"gear": (True, _wave(q, finer[0]))} if finer else {})

    def find_directions(self, at: At) -> None:
        """Enter the directions of geometry that are not spanned, and note what is."""
        valid = self.model.valid
        basis = _Basis(np.concatenate([*self.model.placing(at).values()], axis=2)[valid])
        absolute = self.robot.zero == "absolute"
        for joint in self.joints:
            key = f"home {joint}"
            new = basis.directions(self.model.column(at, key)[valid])
            if not new.size and absolute:
                self.spanned[key] = "base and targets, whose places are not known, make up for it"
                del self.model.shapes[key]
        kept: dict[str, list[FloatArray]] = {joint: [] for joint in self.joints}
        for part in (slice(0, 3), slice(3, 6)):
            for j, joint in enumerate(self.joints):
                block = self.model.geometry(at, j)[valid][:, part]
                kept[joint].append(np.eye(6)[:, part] @ basis.directions(block))
        for j, joint in enumerate(self.joints):
            key, change = f"{GEOMETRY} {joint}", np.concatenate(kept[joint], axis=1)
            if change.shape[1]:
                self.model.shapes[key] = Shape(before={j: change})
            else:
                self.spanned[key] = "base, targets and zeros of joints make up for it"
        if not absolute:
            self.free = tuple(f"home {joint}" for joint in self.joints)

    def spread(self, key: str) -> FloatArray:
        """Prior spreads (k,) of the sizes of a key, in SI units."""
        stem, _, joint = key.partition(" ")
        usual = POSES.unknown_rad if stem in UNKNOWNS else POSE_EFFECTS[stem].spread
        top = self.tops[stem][self.joints.index(joint)] if stem in self.tops else 1.0
        return np.full(self.model.shapes[key].count, usual / top)

    @property
    def named(self) -> list[str]:
        """Keys of all sizes that have a name."""
        return [key for key in self.model.shapes if key.partition(" ")[0] not in UNKNOWNS]

    def _enter_known(self, every: dict[str, Shape]) -> None:
        """What the effects of the robot file do, so that all that is found lies beyond it."""
        for entry in self.robot.effects:
            stem = next((k for k, e in POSE_EFFECTS.items() if e.name == entry.effect), "")
            if not stem or entry.component not in (*self.joints, SENSORS):
                continue
            values = {n: float(np.mean(v)) for n, v in entry.parameters.items()}
            size, shape = POSE_EFFECTS[stem].from_file(values), every[f"{stem} {entry.component}"]
            if stem in WAVES:
                (j,) = shape.angles
                shape = Shape({j: _wave(self.poses.at[:, j], 2.0 * np.pi / values["period"])})
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
        finer = [f"gear {joint}" for joint in self.waves]
        self.model.shapes |= {key: one for key, one in self._every().items() if key in finer}

    def take_over(self, other: PoseShapes) -> None:
        """The shapes of another recording's keys in these poses."""
        self.waves, self.tops, self.free = other.waves, other.tops, other.free
        every, chosen = self._every(), other.model.shapes
        self.model.shapes = {k: one if one.before else every[k] for k, one in chosen.items()}


def _wave(q: FloatArray, waves: float) -> FloatArray:
    """Sine and cosine of so many waves a turn, (n, 2)."""
    return np.stack([np.sin(waves * q), np.cos(waves * q)], axis=1)


def _finest(q: FloatArray) -> float:
    """Waves a turn that angles (n,) tell from coarser ones; any, where they are no grid."""
    span = float(np.ptp(q))
    angles = len(np.unique(np.round((q - q.min()) / (POSES.same_angle * span))))
    grid = len(q) > POSES.repeats * angles
    return np.pi * angles / span if grid else np.inf


class _Basis:
    """What columns span, one block after another."""

    def __init__(self, columns: FloatArray):
        norms = np.maximum(np.linalg.norm(columns, axis=0), 1e-300)
        left, size, _ = np.linalg.svd(columns / norms, full_matrices=False)
        self._spans = left[:, size > POSES.spanned * size[0]]

    def directions(self, block: FloatArray) -> FloatArray:
        """Directions (j, k) of a block (m, j) that are not spanned; then they are."""
        whole = max(float(np.linalg.norm(block, axis=0).max()), 1e-300)
        beyond = block - self._spans @ (self._spans.T @ block)
        left, size, right = np.linalg.svd(beyond, full_matrices=False)
        kept = size > POSES.spanned * whole
        self._spans = np.concatenate([self._spans, left[:, kept]], axis=1)
        return np.where(np.abs(right[kept]) < ROUNDED, 0.0, right[kept]).T
