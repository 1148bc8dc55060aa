"""Data, models and runs of the reproduction, each made once and kept in a folder."""

from __future__ import annotations

import hashlib
import time
from collections.abc import Callable
from dataclasses import dataclass, field, fields
from functools import cached_property
from pathlib import Path
from typing import Any

import numpy as np

from deltactl.firmware_py.robot_file import RobotFile
from deltactl.foundation.errors import NetworkError, UnreachablePoint
from deltactl.models.inverse_kinematics import GeometricInverse
from deltactl.models.network.file import NetworkFile
from deltactl.models.network.inverse import InverseNetwork
from deltactl.models.robot import FloatArray, Sensors
from deltactl.models.training.calibrate import Calibrated, calibrate
from deltactl.models.training.calibrated_file import true_m
from deltactl.models.training.dataset import DataSet, IntArray, load_dataset
from deltactl.models.training.sources import of_dataset
from deltactl.models.training.train import Recipe, settings_in_file, train_from_samples
from deltactl.proof.recorded import Machine
from deltactl.reproduction.outcome import Arrays, kept
from deltactl.reproduction.zhao_2023.as_built import AsBuiltFile, machine_of
from deltactl.reproduction.zhao_2023.collecting import collect
from deltactl.reproduction.zhao_2023.corrected import (
    PASSES,
    angles_of,
    corrected_robot,
    with_feedback,
)
from deltactl.reproduction.zhao_2023.settling import ExpectedMap
from deltactl.reproduction.zhao_2023.tracking import (
    CURVES,
    T_PWM_S,
    TRAINED_T_PWM_S,
    Track,
    collect_on_curve,
    follow,
    targets,
)


@dataclass(frozen=True)
class Scale:
    """Samples and effort of a study."""

    samples: tuple[int, ...]
    """Data set sizes to train with, rising."""
    main: int
    """The size of the paper's."""
    few: int
    """The size with which our model shall do as well as Zhao's with `main`."""
    ablation: tuple[int, ...]
    """The sizes the paper compares."""
    speeds: tuple[float, ...] = T_PWM_S
    effort: int | None = None
    """Epochs or iterations; None is each recipe's own."""
    survey_s: float = 240.0
    """Length of the survey that the robot is diagnosed from."""
    part: float = 1.0
    """How much of each curve is followed."""


FULL = Scale(
    samples=(100, 300, 500, 1000, 3000, 5000, 20_000),
    main=5000,
    few=500,
    ablation=(1000, 3000, 5000),
)
QUICK = Scale(
    samples=(100, 200),
    main=200,
    few=100,
    ablation=(100, 200),
    effort=10,
    survey_s=30.0,
    part=0.1,
    speeds=(0.002, 0.006),
)


Say = Callable[[str], None]
GEOMETRY, LIMIT = "geometry", "limit"
RECIPES: tuple[Recipe, ...] = ("zhao", "uzunovic", "ours")
CALIBRATED, TRUSTING = "calibrated", "trusting"
"""The calibrated geometry; and the same asked for what the sensors will say, not for the truth."""
CORRECTED, WITH_FEEDBACK = "corrected", "with_feedback"
"""Diagnosed and corrected from one survey; and the same with feedback from the sensors."""
SEED = 1
EVERY_S = 10.0


@dataclass
class Study:
    """A folder with everything. Models are named `geometry`, `limit`, `<recipe>-<samples>`,
    `calibrated-<samples>`, `trusting-<samples>`, `zhao-on-<curve>` and `zhao-again-<curve>`."""

    folder: Path
    robot: RobotFile
    built: AsBuiltFile
    scale: Scale
    say: Say
    _calibrations: dict[int, Calibrated] = field(default_factory=dict)
    _counts: dict[tuple[str, str], IntArray] = field(default_factory=dict)
    _networks: dict[str, InverseNetwork] = field(default_factory=dict)
    _marks: dict[str, str] = field(default_factory=dict)

    @cached_property
    def machine(self) -> Machine:
        """The as-built robot."""
        return machine_of(self.built, self.robot)

    @cached_property
    def data(self) -> DataSet:
        """The survey, as many samples as the largest training needs."""
        samples = max(self.scale.samples)
        self.say(f"collecting {samples} samples")
        left = _Left(self.say, samples)
        collect(self.folder / "data", self.robot, self.built, samples, SEED, left.seen)
        return load_dataset(self.folder / "data").first(samples)

    @property
    def corrected(self) -> RobotFile:
        """The robot file that one survey of the as-built robot gives."""
        return self._corrected[0]

    @property
    def corrected_all(self) -> RobotFile:
        """The same with --all."""
        return self._corrected[1]

    @cached_property
    def _corrected(self) -> tuple[RobotFile, RobotFile]:
        seconds = self.scale.survey_s
        self.say(f"a survey of {seconds:.0f} s, and its diagnosis")
        name = f"{self.robot.name}.yaml"
        return corrected_robot(self.folder, name, self.machine, self.built, seconds)

    def true_with_feedback(self, curve: str, t_pwm_s: float) -> tuple[FloatArray, bool]:
        """Where the corrected robot truly was at the targets, with feedback, (n, 3) [m].

        And whether the run was closed: the same steps came out of the last two passes.
        """
        mark = f"{self.built.mark} {self._model_mark(CORRECTED)} {len(self.targets(curve))}"

        def run() -> Arrays:
            self.say(f"running {curve} at T_PWM {t_pwm_s:g} s: {CORRECTED}, with feedback")
            counts = self.counts(CORRECTED, curve)
            found = with_feedback(
                self.machine, self.corrected, self.targets(curve), counts, t_pwm_s
            )
            return {"true_m": found[0], "passes": np.array(found[1])}

        path = self.folder / "tracks" / f"{WITH_FEEDBACK}-{curve}-{t_pwm_s:g}.npz"
        found = kept(path, mark, run)
        return np.asarray(found["true_m"]), int(found["passes"]) < PASSES

    def network(self, model: str) -> InverseNetwork:
        """A trained network, trained now unless one of this data and recipe is kept.

        Raises NetworkError.
        """
        if model not in self._networks:
            self._networks[model] = self._trained(model)
        return self._networks[model]

    def _trained(self, model: str) -> InverseNetwork:
        effort = "" if self.scale.effort is None else f"-{self.scale.effort}"
        path = self.folder / f"networks{effort}" / f"{model}.tflite"
        recipe, _, rest = model.partition("-")
        data = self.data.first(int(rest)) if rest.isdigit() else self._curve_data(rest)
        try:
            file = NetworkFile.load(path)
            known = file.metadata.training
            recipe_now = settings_in_file(_recipe(recipe), self.scale.effort)
            if known.data == data.digest and known.settings == recipe_now:
                return InverseNetwork(file)
        except (NetworkError, OSError):
            pass
        self.say(f"training {model}")
        path.parent.mkdir(parents=True, exist_ok=True)
        source = of_dataset(data, self.robot)
        written = train_from_samples(
            source, _recipe(recipe), path, 0, self.scale.effort, _Left(self.say).follow
        )
        return InverseNetwork(written.file)

    def calibration(self, samples: int) -> Calibrated:
        """The calibration on the first so many samples."""
        if samples not in self._calibrations:
            data = self.data.first(samples)
            found = calibrate(self.robot, data.position_m, data.angles_rad)
            self._calibrations[samples] = found
        return self._calibrations[samples]

    def targets(self, curve: str) -> FloatArray:
        """Points of a curve, (n, 3) [m]."""
        whole_m = targets(curve)
        return whole_m[: int(np.ceil(self.scale.part * len(whole_m)))]

    def counts(self, model: str, curve: str) -> IntArray:
        """What a model commands for a curve, (n, 3); kept within the arm limits."""
        if (model, curve) not in self._counts:
            self._counts[model, curve] = self._counts_of(model, curve)
        return self._counts[model, curve]

    def _counts_of(self, model: str, curve: str) -> IntArray:
        target_m = self.targets(curve)
        if model == LIMIT:
            near = self._whole(self.calibration(self.scale.main).angles_rad_many(target_m[:1]))
            expected = ExpectedMap(self.machine, self._sensors)
            return expected.counts_of(target_m, near[0])
        return self._whole(self._angles(model, target_m))

    def track(self, model: str, curve: str, t_pwm_s: float = TRAINED_T_PWM_S) -> Track:
        """A run of the as-built robot along a curve."""
        name = f"{model}-{curve}-{t_pwm_s:g}"
        path_mark = hashlib.sha256(self.targets(curve).tobytes()).hexdigest()[:12]
        mark = f"{self.built.mark} {self._model_mark(model)} {path_mark}"

        def run() -> Arrays:
            self.say(f"running {curve} at T_PWM {t_pwm_s:g} s: {model}")
            rng = np.random.default_rng([SEED, CURVES.index(curve), round(1e4 * t_pwm_s)])
            counts = self.counts(model, curve)
            track = follow(self.machine, self._sensors, self.targets(curve), counts, t_pwm_s, rng)
            return {item.name: np.asarray(getattr(track, item.name)) for item in fields(Track)}

        arrays = kept(self.folder / "tracks" / f"{name}.npz", mark, run)
        plain: dict[str, Any] = dict(arrays)
        for name in ("length_m", "seconds"):
            plain[name] = float(plain[name])
        return Track(**plain)

    @property
    def _sensors(self) -> Sensors:
        assert self.robot.sensors is not None
        return self.robot.sensors

    def _angles(self, model: str, target_m: FloatArray) -> FloatArray:
        if model == GEOMETRY:
            return GeometricInverse(self.robot.geometry).angles_rad_many(target_m)
        if model == CORRECTED:
            return angles_of(self.corrected, target_m)
        name, _, rest = model.partition("-")
        if name in (CALIBRATED, TRUSTING):
            found = self.calibration(int(rest))
            asked_m = true_m(found, target_m) if name == TRUSTING else target_m
            return found.angles_rad_many(asked_m)
        # Without refusing targets beyond the samples: the paper's program does not either.
        return self.network(model).raw_rad_many(target_m)

    def _whole(self, angles_rad: FloatArray) -> IntArray:
        if not np.isfinite(angles_rad).all():
            raise UnreachablePoint("a model gives no angles for part of a curve")
        low, high = np.radians(self.robot.limits.arm_deg) / self.robot.drive.rad_per_step
        steps = np.clip(angles_rad / self.robot.drive.rad_per_step, low, high)
        counts: IntArray = np.rint(steps).astype(np.int64)
        return counts

    def _model_mark(self, model: str) -> str:
        if model not in self._marks:
            self._marks[model] = self._marked(model)
        return self._marks[model]

    def _marked(self, model: str) -> str:
        if model == GEOMETRY:
            return model
        if model == LIMIT:
            return f"{model} {hashlib.sha256(repr(self.scale).encode()).hexdigest()[:8]}"
        if model.partition("-")[0] in (CALIBRATED, TRUSTING, CORRECTED):
            angles = self._angles(model, self.targets(CURVES[0])[:5])
            return f"{model} {hashlib.sha256(np.round(angles, 7).tobytes()).hexdigest()[:12]}"
        return f"{model} {self.network(model).metadata.sha256[:12]}"

    def _curve_data(self, rest: str) -> DataSet:
        """`on-circle`: a circle as geometry drove it; `again-circle`: as Zhao's network does."""
        how, _, curve = rest.partition("-")
        driver = GEOMETRY if how == "on" else f"zhao-{self.scale.main}"
        return collect_on_curve(
            self.folder / f"data-{rest}", self.robot, self.built, curve, self.track(driver, curve)
        )


def _recipe(name: str) -> Recipe:
    for recipe in RECIPES:
        if recipe == name:
            return recipe
    raise ValueError(name)


class _Left:
    """Now and then a line with what is done and the time left."""

    def __init__(self, say: Say, total: int = 0):
        self._say, self._total = say, total
        self._began_s = self._said_s = time.monotonic()
        self._first: int | None = None

    def seen(self, done: int) -> None:
        """So many are done."""
        self.follow(done, self._total, "")

    def follow(self, done: int, total: int, text: str) -> None:
        """So many of a total are done."""
        now_s = time.monotonic()
        if self._first is None:
            self._first = done
        if now_s - self._said_s < EVERY_S or done <= self._first:
            return
        self._said_s = now_s
        left_s = (now_s - self._began_s) / (done - self._first) * (total - done)
        self._say(f"  {done} of {total}, {left_s:.0f} s left {text}".rstrip())
