"""A chain of joints by poses that were measured from outside, at rest in each.

What base and targets leave of the measured places is a sum of columns, the Jacobian of the model
times what is wrong at a joint. It is linearised at the most probable sizes of all that may be wrong
together: at the model's own a home that is 20 mrad off leaves more than a tracker's noise. Of the
geometry only those directions are tried that base, targets and zeros of the joints do not span
(Mooring, Roth and Driels 1991, Fundamentals of Manipulator Calibration, chapter 3).
"""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass

import numpy as np

from deltactl.diagnosis.answer.records import NotTestable
from deltactl.diagnosis.assessment.options import ASSESSMENT
from deltactl.diagnosis.evidence.options import EVIDENCE
from deltactl.diagnosis.observations.readings import FloatArray, IntArray, Readings
from deltactl.diagnosis.plants.chain.pose_model import At, PoseModel, Shapes
from deltactl.diagnosis.plants.chain.pose_readings import ROTATION, last_way, poses_of
from deltactl.diagnosis.plants.options import SPLINE_TERMS
from deltactl.diagnosis.plants.regression import (
    Columns,
    Draws,
    Regressor,
    Shown,
    Sizes,
    instead,
)
from deltactl.diagnosis.plants.spline_terms import KeepsBeside
from deltactl.models.effects.chain_poses import POSE_EFFECTS, SENSORS
from deltactl.models.effects.link_geometry import OFF
from deltactl.models.effects.lone_axis import LINEAR_UNIT
from deltactl.models.rigid_chain import RigidChain
from deltactl.models.robot import ChainRobot
from deltactl.recording.tables.flat import FlatRecording

UNKNOWN, GEOMETRY = "left", "geometry"
WAVES = ("wave", "second", "gear")
COMMONEST = (
    "home", GEOMETRY, "droop", "windup", "wave", "second", "play", "rest", "ratio", "gear", "bend",
    "hang",
)  # fmt: skip
"""The order in which they are part of the set that shows the noise."""
POSITIVE = ("droop", "play", "hang", "bend", "rest")
"""No joint has less than none of these."""
ANYWHERE = 1.0
"""Prior spread [m, rad] of placements, which have been found already."""
ROUNDED = 1e-6
"""Part of a direction of length 1 that is rounding."""
SHORTEST_RAD = 1e-3
"""Range of a joint that is none."""
NO_ERROR = 1e-9
"""Following error [rad, m] that is none."""


@dataclass(frozen=True, slots=True)
class PoseOptions:
    """What is usual of arms that are measured by a tracker."""

    zero_rad: float = 0.01
    """A mark on a joint, set by eye."""
    ratio_share: float = 1e-3
    wave_rad: float = 1e-3
    """Of an encoder's disc or a gear's ring that runs out of centre."""
    gear_rad: float = 3e-4
    """Of a strain wave gear."""
    sag_rad: float = 2e-3
    """At the largest weight that a joint holds in these poses."""
    play_rad: float = 1e-3
    """Of gears that are not preloaded."""
    off_m: float = 2e-3
    off_rad: float = 2e-3
    """Of castings that were bolted together."""
    at_once: float = 1.0
    """Share of following errors that lies behind the encoder."""
    unsettled: float = 0.05
    """Share of the last move that is missing yet."""
    unknown_rad: float = 3e-4
    spanned: float = 0.02
    """Share of a column that base, targets and zeros leave of it, below which they span it: a turn
    by a milliradian makes 0.02 mm there."""
    harmonics: tuple[int, int] = (3, 8)
    """Waves a turn of an error that has no name."""
    finest_waves: int = 240
    """Waves a turn of a joint that are searched for: two a turn of a motor behind a gear of 120."""
    least_load: float = 1e-3
    """Share of the largest load on any joint that is none."""
    same_angle: float = 1e-3
    """Share of its range within which a joint is at one angle: a grid of poses has few."""
    repeats: float = 2.0
    """Poses at each angle from which on they are a grid, between whose angles no wave is seen."""


POSES = PoseOptions()


class PosePlant(KeepsBeside):
    """All joints of a chain; `observed` is what base and targets leave of the measured places."""

    averages = False
    rounding = 0.0
    channel = "pos"
    unit = "m"

    def __init__(self, robot: ChainRobot, recordings: Sequence[FlatRecording], chain: RigidChain):
        self.robot, self.chain, self.source = robot, chain, recordings[0].source
        self.joints = chain.joints
        self.poses = poses_of(robot, recordings)
        self.model = PoseModel(robot, chain, self.poses)
        self._lay_out(len(recordings))
        self.beside = np.zeros((len(self.order), 0))
        self.shapes = Shapes()
        self.free_keys: tuple[str, ...] = ()
        start = self.model.at(self.shapes, {})
        self.tops = self._tops(start)
        self._joint_shapes(start)
        self._enter_known(start)
        self.model.place(self.shapes, {})
        placed = self.model.at(self.shapes, {})
        self.placed_only = placed.left
        """What base and targets alone leave, (poses, channels)."""
        self.spanned = self._geometry(placed)
        self.waves: dict[str, tuple[int, int]] = {}
        """Waves a turn of the gear's error at each joint, and among how many they were chosen."""
        self.spreads: dict[str, FloatArray] = {}
        self._settle()
        self._gear_waves()
        self._settle()
        self.regressors = tuple(self._regressors())

    # ---- rows ----------------------------------------------------------------------------------

    def _lay_out(self, parts: int) -> None:
        """Channel after channel in sections of poses, so that a share left out is of poses."""
        count, channels = len(self.poses.at), self.model.channels
        section = np.arange(count) * ASSESSMENT.folds // count
        key = section[:, None] * channels + np.arange(channels)
        self.order: IntArray = np.argsort(key.T.ravel(), kind="stable")
        self.at_channel: IntArray = np.repeat(np.arange(channels), count)[self.order]
        self.at_pose: IntArray = np.tile(np.arange(count), channels)[self.order]
        self.rows: IntArray = np.flatnonzero(self.model.valid[self.at_pose, self.at_channel])
        places = 3 * len(self.poses.targets)
        self.kinds: IntArray = (self.at_channel >= places).astype(np.intp)
        fresh = np.diff(self.at_channel, prepend=-1) != 0
        self.groups = np.cumsum(fresh).astype(np.intp)
        self.t_s = np.arange(len(self.order), dtype=float)
        valid = np.zeros((len(self.order), 1), dtype=bool)
        valid[self.rows] = True
        self.readings = Readings(
            self.t_s, fresh, self.poses.part[self.at_pose], (0.0,) * parts, (self.channel,), ("m",),
            np.zeros((len(self.order), 1)), valid,
        )  # fmt: skip

    def laid(self, values: FloatArray) -> FloatArray:
        """(poses, channels) or (poses, channels, k) as (n,) or (n, k); 0 where nothing was read."""
        laid: FloatArray = np.nan_to_num(values[self.at_pose, self.at_channel])
        return laid

    # ---- what may be wrong ---------------------------------------------------------------------

    def _tops(self, at: At) -> dict[str, float]:
        """Largest loads and moments on joints, to which sags are relative."""
        loads = {j: float(np.abs(at.placed.loads[:, i]).max()) for i, j in enumerate(self.joints)}
        across = {
            f"across {j}": float(np.abs(_across(at, i)).max()) for i, j in enumerate(self.joints)
        }
        return loads | across

    def _joint_shapes(self, at: At) -> None:
        """Enter all that may be wrong at a joint and changes in these poses."""
        heaviest = max(max(self.tops.values()), 1e-300)
        for j, joint in enumerate(self.joints):
            stems = ["home"]
            turns = not self.chain.slides[j]
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
                self.shapes.angles[key] = (j, self._angle(key, at))
            if self.tops[f"across {joint}"] > POSES.least_load * heaviest:
                self.shapes.bends[f"bend {joint}"] = (j, _across(at, j))
        if np.any(self.poses.step):
            self.shapes.steps[f"rest {SENSORS}"] = -self.poses.step

    def _angle(self, key: str, at: At) -> FloatArray:
        """Change (n, k) of a joint's angle by the sizes of a key."""
        stem, joint, *follows = key.split(" ")
        j = self.joints.index(joint)
        q, load = self.poses.at[:, j], at.placed.loads[:, j]
        if stem == UNKNOWN and follows == ["angle"]:
            waves = range(POSES.harmonics[0], POSES.harmonics[1] + 1)
            return np.concatenate([_wave(q, n) for n in waves], axis=1)
        if stem == UNKNOWN:
            share = load / self.tops[joint]
            return np.stack([share**2, share**3], axis=1)
        if stem in WAVES:
            return _wave(q, {"wave": 1, "second": 2}.get(stem) or self.waves[joint][0])
        ahead = np.zeros_like(self.poses.at) if self.poses.ahead is None else self.poses.ahead
        plain = {
            "home": np.ones(len(q)), "ratio": q, "droop": load, "hang": 0.5 * np.sign(load),
            "play": 0.5 * last_way(self.poses)[:, j], "windup": ahead[:, j],
        }  # fmt: skip
        shape: FloatArray = plain[stem][:, None]
        return shape

    def _geometry(self, at: At) -> dict[str, str]:
        """Enter the directions of geometry that are not spanned; those that are, and by what."""
        valid, lost = self.model.valid, {}
        basis = _Basis(np.concatenate([*self.model.placing(at).values()], axis=2)[valid])
        for joint in self.joints:
            key = f"home {joint}"
            if self.robot.zero == "absolute" and not basis.takes(self._column(at, key)[valid]):
                lost[key] = "base and targets, whose places are not known, make up for it"
                del self.shapes.angles[key]
            elif self.robot.zero == "arbitrary":
                basis.takes(self._column(at, key)[valid])
        kept: dict[int, list[FloatArray]] = {j: [] for j in range(len(self.joints))}
        for part, spread in ((slice(0, 3), POSES.off_m), (slice(3, 6), POSES.off_rad)):
            for j in range(len(self.joints)):
                block = self.model.geometry(at, j)[valid][:, part]
                for direction in basis.directions(block).T:
                    whole = np.zeros(6)
                    whole[part] = spread * direction
                    kept[j].append(whole)
        for j, joint in enumerate(self.joints):
            if kept[j]:
                self.shapes.offs[f"{GEOMETRY} {joint}"] = (j, np.stack(kept[j], axis=1))
            else:
                lost[f"{GEOMETRY} {joint}"] = "base, targets and zeros of joints make up for it"
        if self.robot.zero == "arbitrary":
            self.free_keys = tuple(
                f"home {j}" for j in self.joints if f"home {j}" in self.shapes.angles
            )
        return lost

    def _column(self, at: At, key: str) -> FloatArray:
        return self.model.column(at, self.shapes, key)

    def spread(self, key: str) -> FloatArray:
        """Prior spreads (k,) of the sizes of a key, in SI units."""
        stem, _, joint = key.partition(" ")
        usual = {
            "home": POSES.zero_rad, "ratio": POSES.ratio_share, "wave": POSES.wave_rad,
            "second": POSES.wave_rad, "gear": POSES.gear_rad, "play": POSES.play_rad,
            "hang": POSES.play_rad, "windup": POSES.at_once, "rest": POSES.unsettled,
            "droop": POSES.sag_rad / (self.tops.get(joint) or 1.0),
            "bend": POSES.sag_rad / (self.tops.get(f"across {joint}") or 1.0),
            GEOMETRY: 1.0, UNKNOWN: POSES.unknown_rad,
        }  # fmt: skip
        return np.full(self.shapes.count(key), usual[stem])

    @property
    def named(self) -> list[str]:
        """Keys of all sizes that have a name."""
        parts = (self.shapes.angles, self.shapes.offs, self.shapes.bends, self.shapes.steps)
        return [key for part in parts for key in part if not key.startswith(UNKNOWN)]

    def _enter_known(self, at: At) -> None:
        """What the effects of the robot file do, so that all that is found lies beyond it."""
        for entry in self.robot.effects:
            stem = next((k for k, e in POSE_EFFECTS.items() if e.name == entry.effect), "")
            values = {n: float(np.mean(v)) for n, v in entry.parameters.items()}
            if stem == "rest":
                self.model.given -= values.get("share_of_last_move", 0.0) * self.poses.step
            elif stem and entry.component in self.joints:
                j = self.joints.index(entry.component)
                if stem == GEOMETRY:
                    self.model.off[j] += [values.get(name, 0.0) for name in OFF]
                elif stem == "bend":
                    self.model.given_bends.append((j, values["compliance"] * _across(at, j)))
                else:
                    self.model.given[:, j] += self._given(stem, j, values, at)

    def _given(self, stem: str, j: int, values: Mapping[str, float], at: At) -> FloatArray:
        """Change (n,) of a joint's angle by an effect of the robot file."""
        size = POSE_EFFECTS[stem].from_file(values)
        if stem in WAVES:
            shape = _wave(self.poses.at[:, j], 2.0 * np.pi / values["period"])
        else:
            shape = self._angle(f"{stem} {self.joints[j]}", at)
        given: FloatArray = shape @ size
        return given

    def _settle(self) -> None:
        """Linearise at the most probable sizes of all that has a name, together."""
        self.spreads = {key: self.spread(key) for key in self.named}
        self.best, at = self.model.settle(self.shapes, {}, self.spreads, self.named)
        self._linearise(at)

    def _linearise(self, at: At) -> None:
        """Columns at some sizes, and what is to be explained: all beyond the robot file's."""
        self._at = at
        keys = [*self.named, *(key for key in self.shapes.angles if key.startswith(UNKNOWN))]
        each = {key: self.laid(self.model.column(at, self.shapes, key)) for key in keys}
        self._columns = {
            key: Columns(values, self.spread(key), self._names(key)) for key, values in each.items()
        }
        placing = [self.laid(values) for values in self.model.placing(at).values()]
        wide = [np.full(one.shape[1], ANYWHERE) for one in placing]
        zeros = [self._columns[key] for key in self.free_keys]
        self._free = Columns(
            np.concatenate([*placing, *(one.values for one in zeros)], axis=1),
            np.concatenate([*wide, *(one.spread for one in zeros)]),
        )
        self.observed = self.laid(at.left)
        for key, size in self.best.items():
            self.observed += each[key] @ size
        self.drawn_on = self.laid(self._measured()) - self.observed
        self.readings.values[:, 0] = self.observed
        self.done_by_known = None

    @property
    def names(self) -> list[str]:
        """What was measured, by channel."""
        places = [f"{target}_{axis}" for target in self.poses.targets for axis in "xyz"]
        return places if self.poses.turned is None else [*places, *ROTATION]

    def _measured(self) -> FloatArray:
        """What was read, (poses, channels)."""
        seen = self.poses.places.reshape(len(self.poses.at), -1)
        return (
            seen
            if self.poses.turned is None
            else np.concatenate([seen, 0.0 * self.poses.turned], 1)
        )

    def _names(self, key: str) -> tuple[str, ...]:
        count = self.shapes.count(key)
        return (key.split(" ")[0],) if count == 1 else tuple(f"part{i}" for i in range(count))

    def _gear_waves(self) -> None:
        """Of each joint the wave, finer than those of the joint, that what is left has most of."""
        at = self.model.at(self.shapes, self.best)
        left, valid = np.nan_to_num(at.left), self.model.valid
        for j, joint in enumerate(self.joints):
            q = self.poses.at[:, j]
            if self.chain.slides[j] or not np.ptp(q) > 0.0:
                continue
            along = self.model.jacobian(at, j) * valid
            pull, weight = np.sum(along * left, axis=1), np.sum(along**2, axis=1)
            waves = np.arange(POSES.harmonics[0], POSES.finest_waves + 1)
            waves = waves[waves < _finest(q)]
            if not len(waves):
                continue
            turned = np.exp(1j * np.outer(waves, q))
            power = np.abs(turned @ pull) ** 2 / max(float(weight.sum()), 1e-300)
            n = int(waves[np.argmax(power)])
            self.waves[joint] = (n, len(waves))
            self.shapes.angles[f"gear {joint}"] = (j, _wave(q, n))

    def _shows_noise(self) -> set[str]:
        """Keys of the saturated set: of few poses those that most arms have, as a set with a column
        for every few readings follows the noise.
        """
        room = len(self.rows) // EVIDENCE.readings_a_column - self._free.values.shape[1]
        found = set()
        for key in sorted(self.named, key=lambda key: COMMONEST.index(key.split(" ")[0])):
            room -= self.shapes.count(key)
            if room < 0:
                break
            found.add(key)
        return found

    def _regressors(self) -> list[Regressor]:
        found, saturated = [], self._shows_noise()
        for key in self.named:
            stem, _, component = key.partition(" ")
            one = POSE_EFFECTS[stem]
            places = self.waves[component][1] if stem == "gear" else None
            odds = one.log_odds - (float(np.log(places)) if places else 0.0)
            positive = (stem,) if stem in POSITIVE else ()
            same = instead(f"pose/{stem}")
            if key not in self.free_keys:
                found.append(
                    Regressor(
                        key, one.name, odds, component, equivalents=same, alone=False,
                        positive=positive, places=places, saturated=key in saturated,
                    )
                )  # fmt: skip
        for key in self.shapes.angles:
            if key.startswith(UNKNOWN):
                _, joint, follows = key.split(" ")
                odds = SPLINE_TERMS.unknown_log_odds
                found.append(
                    Regressor(key, "unknown", odds, joint, follows=(follows,), left_over=True)
                )
        return found

    def base(self, keys: frozenset[str], sizes: Sizes) -> FloatArray:
        """Nothing is predicted beyond what base, targets and the robot file make, (n,)."""
        return np.zeros(len(self.order))

    def free(self) -> Columns:
        """Placement of base and targets."""
        return self._free

    def columns(self, key: str, base: FloatArray, sizes: Sizes) -> Columns:
        """Displacements (n, k) by the sizes of a key."""
        return self._columns[key]

    @property
    def covariates(self) -> dict[str, FloatArray]:
        """Angles and loads of all joints, (n,)."""
        placed = self._at.placed
        found = {f"theta_{j + 1}": q[self.at_pose] for j, q in enumerate(self.poses.at.T)}
        return found | {f"load_{j + 1}": q[self.at_pose] for j, q in enumerate(placed.loads.T)}

    def followed(self, key: str) -> FloatArray:
        """Angle or load (n,) that what has no name follows."""
        _, joint, follows = key.split(" ")
        number = self.joints.index(joint) + 1
        return self.covariates[f"theta_{number}" if follows == "angle" else f"load_{number}"]

    def noise_bounds(self, left: FloatArray) -> None:
        """Poses at rest have no course of time that would bound the noise."""

    def not_testable(self) -> list[NotTestable]:
        """Zeros and geometry that these poses cannot tell from the placement."""
        return [
            NotTestable(
                effect=POSE_EFFECTS[key.split(" ")[0]].name, component=key.split(" ")[1], why=why
            )
            for key, why in self.spanned.items()
        ]

    def variant(self) -> None:
        """There is one way to prepare it."""

    def adopt(self, trained: PosePlant) -> None:
        """Linearise where the other recording is: sizes of one hold in the other."""
        self.waves, self.tops = trained.waves, trained.tops
        self.shapes = self._like(trained)
        self.free_keys, self.best = trained.free_keys, trained.best
        self.model.place(self.shapes, self.best)
        self._linearise(self.model.at(self.shapes, self.best))
        self.regressors = trained.regressors

    def _like(self, trained: PosePlant) -> Shapes:
        """The shapes of another recording in these poses."""
        start, shapes = self.model.at(Shapes(), {}), trained.shapes
        return Shapes(
            {key: (j, self._angle(key, start)) for key, (j, _) in shapes.angles.items()},
            shapes.offs,
            {key: (j, _across(start, j)) for key, (j, _) in shapes.bends.items()},
            dict.fromkeys(shapes.steps, -self.poses.step),
        )

    def shown(self, key: str) -> Sequence[Shown]:
        """Parameters of the effects, in SI units."""
        stem, _, component = key.partition(" ")
        if stem == UNKNOWN:
            return []
        if stem == GEOMETRY:
            change = self.shapes.offs[key][1]
            units = ["m"] * 3 + ["rad"] * 3
            order = np.argsort(-np.abs(change @ self.best[key]), kind="stable")
            return [Shown(OFF[i], units[i], _along(change[i])) for i in order]
        if stem in WAVES:
            return self._shown_wave(key)
        slides = component in self.joints and self.chain.slides[self.joints.index(component)]
        ((name, unit),) = POSE_EFFECTS[stem].parameters
        unit = LINEAR_UNIT.get(unit, unit) if slides else unit
        if stem == "ratio":
            return [Shown(name, unit, lambda v: 1.0 + v[stem], 1.0)]
        if stem == "droop":
            return [
                Shown(name, unit, lambda v: 1.0 / np.where(v[stem] == 0.0, 1e-300, v[stem]), np.inf)
            ]
        return [Shown(name, unit, lambda v: np.asarray(v[stem]))]

    def _shown_wave(self, key: str) -> list[Shown]:
        """A wave by amplitude, period and phase; its period is as sure as its phase over the range
        of the joint.
        """
        stem, _, joint = key.partition(" ")
        waves = {"wave": 1, "second": 2}.get(stem) or self.waves[joint][0]
        q = self.poses.at[:, self.joints.index(joint)]
        apart = float(np.sqrt(12.0)) / max(float(np.ptp(q)), SHORTEST_RAD)

        def period(v: Draws) -> FloatArray:
            wave = np.asarray(v["part0"]) + 1j * np.asarray(v["part1"])
            off = np.angle(wave * np.conj(np.mean(wave)))
            return np.asarray(2.0 * np.pi / (waves + apart * off))

        return [
            Shown("amplitude", "rad", lambda v: np.hypot(v["part0"], v["part1"])),
            Shown("period", "rad", period),
            Shown("phase", "rad", lambda v: np.arctan2(v["part1"], v["part0"]), np.nan),
        ]

    def impossible(
        self, keys: frozenset[str], sizes: Sizes, linear: Mapping[str, FloatArray]
    ) -> bool:
        """What gives way against its load, or play below zero."""
        return any(key.split(" ")[0] in POSITIVE and float(linear[key][0]) <= 0.0 for key in keys)

    def starts(self, key: str, residual: FloatArray) -> Sequence[dict[str, float]]:
        """All sizes are linear."""
        return [{}]


def _wave(q: FloatArray, waves: float) -> FloatArray:
    """Sine and cosine of so many waves a turn, (n, 2)."""
    return np.stack([np.sin(waves * q), np.cos(waves * q)], axis=1)


def _finest(q: FloatArray) -> float:
    """Waves a turn that angles (n,) tell from coarser ones; any, where they are no grid."""
    span = float(np.ptp(q))
    angles = len(np.unique(np.round((q - q.min()) / (POSES.same_angle * span))))
    grid = len(q) > POSES.repeats * angles
    return np.pi * angles / span if grid else np.inf


def _across(at: At, joint: int) -> FloatArray:
    """Moment of the weight across a joint's axis, (n, 3) [N m]."""
    axis, moment = at.placed.axes[:, joint], at.placed.moments[:, joint]
    across: FloatArray = moment - axis * np.sum(axis * moment, axis=1)[:, None]
    return across


def _along(weights: FloatArray) -> Callable[[Draws], FloatArray]:
    """One component of geometry by the sizes of its directions."""
    names = ["geometry"] if len(weights) == 1 else [f"part{i}" for i in range(len(weights))]
    return lambda v: np.asarray(sum(w * v[n] for w, n in zip(weights, names, strict=True)))


class _Basis:
    """What columns span, one block after another."""

    def __init__(self, columns: FloatArray):
        left, size, _ = np.linalg.svd(columns / _norms(columns), full_matrices=False)
        self._spans = left[:, size > POSES.spanned * size[0]]

    def _beyond(self, block: FloatArray) -> FloatArray:
        beyond: FloatArray = block - self._spans @ (self._spans.T @ block)
        return beyond

    def takes(self, column: FloatArray) -> bool:
        """Whether a column (m, 1) is not spanned; then it is from now on."""
        return self.directions(column).shape[1] == 1

    def directions(self, block: FloatArray) -> FloatArray:
        """Directions (j, k) of a block (m, j) that are not spanned; then they are."""
        whole = float(np.linalg.norm(block, axis=0).max())
        left, size, right = np.linalg.svd(self._beyond(block), full_matrices=False)
        kept = size > POSES.spanned * max(whole, 1e-300)
        self._spans = np.concatenate([self._spans, left[:, kept]], axis=1)
        directions: FloatArray = np.where(np.abs(right[kept]) < ROUNDED, 0.0, right[kept]).T
        return directions


def _norms(columns: FloatArray) -> FloatArray:
    norms: FloatArray = np.maximum(np.linalg.norm(columns, axis=0), 1e-300)
    return norms
