"""Recordings with something hidden, and the two explanations that are fitted to them."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from functools import partial
from pathlib import Path

import numpy as np
import pytest

from deltactl.diagnosis.evidence.laplace import Laplace
from deltactl.diagnosis.experiment.propose import fitted_set
from deltactl.diagnosis.experiment.ties import Tie
from deltactl.diagnosis.plants.delta.model import DeltaModel
from deltactl.diagnosis.plants.delta.motions import Motion
from deltactl.diagnosis.plants.delta.next_runs import commanded
from deltactl.diagnosis.plants.delta.plant import DeltaPlant
from deltactl.diagnosis.plants.delta.recorded import Recorded
from deltactl.models.chain import Chain, Commands
from deltactl.models.linkage import Linkage, inverse
from deltactl.models.robot import DeltaRobot, EffectEntry, FloatArray
from deltactl.models.robot_files import load_delta
from deltactl.recording.tables.flat import FlatRecording

ZHAO = Path(__file__).parents[2] / "config" / "zhao-2023.yaml"

NOISE_M = 0.002
PERIOD_S = 0.02
Names = Sequence[tuple[str, str]]


@pytest.fixture(scope="session")
def delta() -> DeltaRobot:
    return load_delta(ZHAO)


def level_circle(
    robot: DeltaRobot, t_pwm_s: float = 0.004, turns: int = 3, radius: float = 0.1
) -> Motion:
    """A level circle run one way only."""
    turn = 2.0 * np.pi * np.arange(60 * turns + 1) / 60
    points = np.stack([radius * np.cos(turn), radius * np.sin(turn), 0 * turn - 0.45], axis=1)
    arms = inverse(Linkage.of(robot.geometry), points)
    return Motion("circle", "", np.rad2deg(arms.angles_rad), 0.0, t_pwm_s)


@dataclass(frozen=True)
class Bench:
    """A robot that moves and is read, with effects only the test knows."""

    robot: DeltaRobot

    def counts(self, motion: Motion) -> tuple[FloatArray, FloatArray]:
        assert self.robot.drive is not None
        return commanded(motion, self.robot.drive.rad_per_step, PERIOD_S)

    def record(self, motion: Motion, *effects: EffectEntry, seed: int = 1) -> FlatRecording:
        assert self.robot.drive is not None
        t_s, counts = self.counts(motion)
        late = EffectEntry(effect="sensor_latency", component="sensors", parameters={"time": 0.01})
        commands = Commands.of_counts(t_s, counts, self.robot.drive)
        ranges = Chain.delta(self.robot).simulate(commands, [*effects, late]).ranges
        noisy = ranges + NOISE_M * np.random.default_rng(seed).standard_normal(ranges.shape)
        columns = {f"steps_{j + 1}": counts[:, j] for j in range(3)}
        columns |= {f"range_{a}": np.round(noisy[:, i], 4) for i, a in enumerate("xyz")}
        return FlatRecording(t_s, columns, {}, motion.name)

    def tie(
        self, recordings: Sequence[FlatRecording], first: Names, second: Names
    ) -> tuple[DeltaPlant, Tie]:
        """Both explanations fitted to the recordings together."""
        plant = DeltaPlant(Recorded(DeltaModel(self.robot, recordings)))
        evidence = Laplace(plant, plant.own_noise)
        sets = [evidence([" ".join(name) for name in names]) for names in (first, second)]
        return plant, Tie.of(*(fitted_set(plant, one) for one in sets))


@pytest.fixture(scope="session")
def bench(delta: DeltaRobot) -> Bench:
    return Bench(delta)


@pytest.fixture(scope="session")
def circle(delta: DeltaRobot) -> Callable[..., Motion]:
    return partial(level_circle, delta)
