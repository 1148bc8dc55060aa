"""A chain of joints by poses that were measured from outside, at rest in each.

What base and targets leave of the measured places is a sum of columns, the Jacobian of the model
times what is wrong at a joint. It is linearised at the most probable sizes of all that may be wrong
together: at the model's own a home that is 20 mrad off leaves more than a tracker's noise.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence

import numpy as np

from deltactl.diagnosis.answer.records import NotTestable
from deltactl.diagnosis.assessment.options import ASSESSMENT
from deltactl.diagnosis.evidence.options import EVIDENCE
from deltactl.diagnosis.observations.readings import FloatArray, IntArray, Layout, Readings
from deltactl.diagnosis.plants.chain.pose_model import At, PoseModel
from deltactl.diagnosis.plants.chain.pose_readings import poses_of
from deltactl.diagnosis.plants.chain.pose_shapes import (
    GEOMETRY,
    UNKNOWNS,
    WAVES,
    WHOLE_WAVES,
    PoseShapes,
)
from deltactl.diagnosis.plants.options import SPLINE_TERMS
from deltactl.diagnosis.plants.regression import RegressionPlant
from deltactl.diagnosis.plants.regressor import Columns, Draws, Regressor, Shown, Sizes, instead
from deltactl.models.effects.chain_poses import LATE, POSE_EFFECTS
from deltactl.models.effects.link_geometry import OFF
from deltactl.models.effects.lone_axis import LINEAR_UNIT
from deltactl.models.rigid_chain import RigidChain
from deltactl.models.robot import ChainRobot
from deltactl.recording.tables.chain_tables import ROTATION
from deltactl.recording.tables.flat import FlatRecording

ANYWHERE = 1.0
"""Prior spread [m, rad] of placements, which have been found already."""
EXACT = 1e-9
"""Change of the waves a turn with their phase, of waves whose number is known."""
SHORTEST_RAD = 1e-3
"""Range of a joint that is none."""


class PosePlant(RegressionPlant):
    """All joints of a chain; `observed` is what base and targets leave of the measured places."""

    channel = "pos"
    unit = "m"

    def __init__(self, robot: ChainRobot, recordings: Sequence[FlatRecording], chain: RigidChain):
        self.robot, self.chain, self.source = robot, chain, recordings[0].source
        self.joints = chain.joints
        self.poses = poses_of(robot, recordings)
        self.model = PoseModel(robot, chain, self.poses)
        self._lay_out(len(recordings))
        self.may_be = PoseShapes(robot, self.model)
        placed = self.model.place({})
        self.placed_only = placed.left
        """What base and targets alone leave, (poses, channels)."""
        self.may_be.find_directions(placed)
        self.may_be.find_gear_waves(self._settle())
        self._linearise(self._settle())
        self.regressors = tuple(self._regressors())

    def _lay_out(self, parts: int) -> None:
        """Channel after channel in sections of poses, so that a share left out is of poses."""
        valid, places = self.model.valid, 3 * len(self.poses.targets)
        self.layout = Layout(np.ones_like(valid), ASSESSMENT.folds)
        part, nothing = self.poses.part, np.zeros((len(valid), 1))
        visits = Readings(
            np.arange(len(valid), dtype=float), nothing[:, 0] > 0.0, part, (0.0,) * parts,
            (self.channel,), (self.unit,), nothing, nothing == 0.0,
        )  # fmt: skip
        self.readings = self.layout.readings(visits, valid, self.channel, self.unit)
        self.rows: IntArray = np.flatnonzero(self.readings.valid[:, 0])
        self.kinds: IntArray = (self.layout.column >= places).astype(np.intp)

    def laid(self, values: FloatArray) -> FloatArray:
        """(poses, channels) or (poses, channels, k) as (n,) or (n, k); 0 where nothing was read."""
        return np.nan_to_num(self.layout.laid(values))

    @property
    def unsampled(self) -> FloatArray:
        """What encoders that count leave open of where the targets are, (n,)."""
        open_m2 = np.zeros(len(self.observed))
        for j, (q, rad) in enumerate(zip(self.poses.at.T, self.robot.rad_per_count, strict=True)):
            if rad is not None and not np.any(np.round(q / rad, 3) % 1.0):
                open_m2 += (rad * self.laid(self.model.jacobian(self._at, j))) ** 2 / 12.0
        return np.asarray(np.sqrt(open_m2))

    # ---- columns -------------------------------------------------------------------------------

    def _settle(self) -> At:
        """The chain at the most probable sizes of all that has a name, together."""
        spreads = {key: self.may_be.spread(key) for key in self.may_be.named}
        self.best, at = self.model.settle({}, spreads)
        return at

    def _linearise(self, at: At) -> None:
        """Columns at some sizes, and what is to be explained: all beyond the robot file's."""
        self._at = at
        each = {key: self.laid(self.model.column(at, key)) for key in self.model.shapes}
        self._columns = {key: Columns(made, self.may_be.spread(key)) for key, made in each.items()}
        placing = [self.laid(values) for values in self.model.placing(at).values()]
        wide = [np.full(one.shape[1], ANYWHERE) for one in placing]
        zeros = [self._columns[key] for key in self.may_be.free]
        self._free = Columns(
            np.concatenate([*placing, *(one.values for one in zeros)], axis=1),
            np.concatenate([*wide, *(one.spread for one in zeros)]),
        )
        self.observed = self.laid(at.left)
        for key, size in self.best.items():
            self.observed += each[key] @ size
        seen = self.poses.places.reshape(len(self.poses.at), -1)
        measured = np.concatenate([seen, 0.0 * self.poses.turned], axis=1)
        self.drawn_on = self.laid(measured) - self.observed
        self.readings.values[:, 0] = self.observed

    @property
    def names(self) -> list[str]:
        """What was measured, by channel."""
        places = [f"{target}_{axis}" for target in self.poses.targets for axis in "xyz"]
        return [*places, *(ROTATION if self.model.turns_seen else ())]

    def _shows_noise(self) -> set[str]:
        """Keys of the saturated set: of few poses those that most arms have, as a set with a column
        for every few readings follows the noise.
        """
        room = len(self.rows) // EVIDENCE.readings_a_column - self._free.values.shape[1]
        commonest = list(POSE_EFFECTS)
        keys = sorted(self.may_be.named, key=lambda key: commonest.index(key.split()[0]))
        taken = np.cumsum([self.model.shapes[key].count for key in keys])
        return set(keys[: int(np.searchsorted(taken, room, side="right"))])

    def _regressors(self) -> list[Regressor]:
        saturated = self._shows_noise()
        keys = [key for key in self.may_be.named if key not in self.may_be.free]
        found = [self._regressor(key, key in saturated) for key in keys]
        odds = SPLINE_TERMS.unknown_log_odds
        for key in self.model.shapes:
            stem, _, joint = key.partition(" ")
            if stem in UNKNOWNS:
                about = (UNKNOWNS[stem],)
                found.append(Regressor(key, "unknown", odds, joint, follows=about, left_over=True))
        return found

    def _regressor(self, key: str, saturated: bool) -> Regressor:
        stem, _, component = key.partition(" ")
        one = POSE_EFFECTS[stem]
        places = self.may_be.waves[component][1] if stem == "gear" else None
        return Regressor(
            key, one.name, one.log_odds - (float(np.log(places)) if places else 0.0), component,
            equivalents=instead(f"pose/{stem}"), alone=False, places=places, saturated=saturated,
            positive=("0",) if one.positive else (), above=0.0 if one.positive else -np.inf,
        )  # fmt: skip

    def free(self) -> Columns:
        """Placement of base and targets."""
        return self._free

    def columns(self, key: str, base: FloatArray, sizes: Sizes) -> Columns:
        """Displacements (n, k) by the sizes of a key."""
        return self._columns[key]

    @property
    def covariates(self) -> dict[str, FloatArray]:
        """Angles and loads of all joints, (n,)."""
        each = {"theta": self.poses.at, "load": self._at.placed.loads}
        return {
            f"{name}_{j}": values[self.layout.sample]
            for name, joints in each.items()
            for j, values in enumerate(joints.T, 1)
        }

    def followed(self, key: str) -> FloatArray:
        """Angle or load (n,) that what has no name follows."""
        stem, _, joint = key.partition(" ")
        values = self.poses.at if UNKNOWNS[stem] == "angle" else self._at.placed.loads
        return np.asarray(values[self.layout.sample, self.joints.index(joint)])

    def noise_bounds(self, left: FloatArray) -> None:
        """Poses at rest have no course of time that would bound the noise."""

    def not_testable(self) -> list[NotTestable]:
        """Zeros and geometry that these poses cannot tell from the placement."""
        spanned = [(*key.split(" ", 1), why) for key, why in self.may_be.spanned.items()]
        return [NotTestable.of(POSE_EFFECTS[stem].name, *place) for stem, *place in spanned]

    def adopt(self, trained: PosePlant) -> None:
        """Linearise where the other recording is: sizes of one hold in the other."""
        self.may_be.take_over(trained.may_be)
        self.best, self.regressors = trained.best, trained.regressors
        self._linearise(self.model.place(self.best))

    def shown(self, key: str) -> Sequence[Shown]:
        """Parameters of the effects, in SI units."""
        stem, _, component = key.partition(" ")
        if stem in UNKNOWNS:
            return []
        if stem == GEOMETRY:
            (change,) = self.model.shapes[key].before.values()
            units = ["m"] * 3 + ["rad"] * 3
            order = np.argsort(-np.abs(change @ self.best[key]), kind="stable")
            return [Shown(OFF[i], units[i], _along(change[i])) for i in order]
        if stem in WAVES:
            return self._shown_wave(key)
        one = POSE_EFFECTS[stem]
        name, unit = one.parameters[0]
        if stem == "rest" and (period_s := self.poses.period_s):
            return [Shown(LATE, "s", lambda v: period_s * v["0"])]
        if component in self.joints and self.chain.slides[self.joints.index(component)]:
            unit = LINEAR_UNIT.get(unit, unit)
        return [Shown(name, unit, lambda v: one.of_size(v["0"]), one.nothing)]

    def _shown_wave(self, key: str) -> list[Shown]:
        """A wave by amplitude, period and phase. Once and twice a turn are exact; a gear has its
        period as surely as its phase over the range of the joint.
        """
        stem, _, joint = key.partition(" ")
        whole = WHOLE_WAVES.get(stem)
        waves = whole or self.may_be.waves[joint][0]
        q = self.poses.at[:, self.joints.index(joint)]
        apart = EXACT if whole else float(np.sqrt(12.0)) / max(float(np.ptp(q)), SHORTEST_RAD)

        def period(v: Draws) -> FloatArray:
            wave = np.asarray(v["0"]) + 1j * np.asarray(v["1"])
            off = np.angle(wave * np.conj(np.mean(wave)))
            return np.asarray(2.0 * np.pi / (waves + apart * off))

        return [
            Shown("amplitude", "rad", lambda v: np.hypot(v["0"], v["1"])),
            Shown("period", "rad", period),
            Shown("phase", "rad", lambda v: np.arctan2(v["1"], v["0"]), np.nan),
        ]


def _along(weights: FloatArray) -> Callable[[Draws], FloatArray]:
    """One component of geometry by the sizes of its directions."""
    return lambda v: np.asarray(sum(weight * v[str(i)] for i, weight in enumerate(weights)))
