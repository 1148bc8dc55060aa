"""A robot and short synthetic recordings of it for the tests of the diagnosis."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest

from deltactl.models.chain import Chain, Commands
from deltactl.models.robot import DeltaRobot, EffectEntry
from deltactl.models.robot_files import load_delta
from deltactl.recording.tables.flat import FlatRecording

ZHAO = Path(__file__).parents[2] / "config" / "zhao-2023.yaml"

Record = Callable[..., FlatRecording]


@pytest.fixture(scope="session")
def delta() -> DeltaRobot:
    return load_delta(ZHAO)


def _survey(rng: np.random.Generator, samples: int) -> np.ndarray:
    """Counts of motors that run at full rate from one random target to the next, (n, 3)."""
    counts, at = np.empty((samples, 3)), rng.integers(0, 3300, 3).astype(float)
    goal, rate = at.copy(), 3.0
    for k in range(samples):
        if (at == goal).all():
            goal = rng.integers(0, 3300, 3).astype(float)
        at = at + np.clip(goal - at, -rate, rate)
        counts[k] = at
    return counts


@pytest.fixture(scope="session")
def record(delta: DeltaRobot) -> Record:
    """Make a recording: true chain at 200 Hz, sensors averaging 20 ms, AR(1) noise, 1 mm steps."""

    made: dict[str, FlatRecording] = {}

    def make(
        *effects: EffectEntry, seed: int = 1, seconds: float = 30.0, rho: float = 0.4
    ) -> FlatRecording:
        asked = repr((effects, seed, seconds, rho))
        if asked not in made:
            made[asked] = simulated(*effects, seed=seed, seconds=seconds, rho=rho)
        one = made[asked]  # whoever changes its columns changes their own
        columns = {name: values.copy() for name, values in one.columns.items()}
        return FlatRecording(one.t_s.copy(), columns, {}, one.source)

    def simulated(*effects: EffectEntry, seed: int, seconds: float, rho: float) -> FlatRecording:
        rng = np.random.default_rng(seed)
        t_s = 0.005 * np.arange(round(seconds / 0.005))
        counts = _survey(rng, len(t_s))
        assert delta.drive is not None
        ranges = Chain(delta).simulate(Commands.of_counts(t_s, counts, delta.drive), effects).ranges
        mean = np.stack([np.convolve(r, np.full(4, 0.25))[: len(t_s)] for r in ranges.T], axis=1)
        t_s, counts, seen = t_s[8::4], counts[8::4], mean[8::4].copy()
        noise = np.zeros(3)
        for k in range(len(seen)):
            noise = rho * noise + 0.002 * np.sqrt(1 - rho**2) * rng.standard_normal(3)
            seen[k] += noise
        seen[rng.random(seen.shape) < 0.002] += 0.08
        columns = {f"steps_{j + 1}": counts[:, j] for j in range(3)}
        columns |= {f"range_{a}": np.round(seen[:, i], 3) for i, a in enumerate("xyz")}
        return FlatRecording(t_s, columns, {}, "synthetic")

    return make


@pytest.fixture
def arm_urdf() -> str:
    """The model of an arm of three joints."""
    from tests.diagnosis.test_chain_of_joints import urdf_text

    return urdf_text()


@pytest.fixture
def robot(tmp_path: Path, arm_urdf: str) -> Path:
    """The robot file of an arm, its URDF beside it."""
    from deltactl.cli.recordings.init_chain import chain

    (tmp_path / "arm.urdf").write_text(arm_urdf)
    file = tmp_path / "arm.yaml"
    chain(file, tmp_path / "arm.urdf")
    return file
