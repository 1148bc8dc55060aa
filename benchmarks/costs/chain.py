"""Time of one 240 s recording (12 000 samples) through the whole delta chain.

python benchmarks/costs/chain.py
"""

from __future__ import annotations

import sys
import time
from pathlib import Path

import numpy as np

from deltactl.models.chain import Chain, Commands
from deltactl.models.effects import VOCABULARY
from deltactl.models.effects.following_lag import EFFECT as LAG
from deltactl.models.effects.gear_backlash import EFFECT as PLAY
from deltactl.models.effects.home_offset import EFFECT as HOME
from deltactl.models.effects.sensor_latency import EFFECT as LATENCY
from deltactl.models.robot import EffectEntry, FloatArray
from deltactl.models.robot_files import load_delta

SAMPLES = 12_000
LIMIT_S = 0.015
ZHAO = Path(__file__).resolve().parents[2] / "config" / "zhao-2023.yaml"
SEVERAL = (
    EffectEntry(effect=PLAY.name, component="motor2", parameters={"width": 0.005}),
    EffectEntry(effect=LAG.name, component="motor1", parameters={"time": 0.03}),
    EffectEntry(effect=HOME.name, component="motor3", parameters={"angle": 0.01}),
    EffectEntry(effect=LATENCY.name, component="sensors", parameters={"time": 0.02}),
)


def survey(samples: int, seed: int = 1) -> tuple[FloatArray, FloatArray]:
    """Times [s] and smooth random arm angles [rad] at 50 Hz."""
    rng = np.random.default_rng(seed)
    t_s = 0.02 * np.arange(samples)
    rates = rng.uniform(0.1, 0.6, size=(3, 4))
    angles = sum(np.sin(t_s[:, None] * rates[:, k] + k) for k in range(4))
    return t_s, 0.6 + 0.15 * np.asarray(angles)


def best_ms(chain: Chain, commands: Commands, effects: tuple[EffectEntry, ...]) -> float:
    """Best of nine whole simulations, commands included."""
    best = np.inf
    for _ in range(9):
        start = time.perf_counter()
        chain.simulate(commands, effects)
        best = min(best, time.perf_counter() - start)
    return 1e3 * best


def main() -> int:
    robot = load_delta(ZHAO)
    chain = Chain.delta(robot)
    commands = Commands.of_angles(*survey(SAMPLES))
    nominal, several = best_ms(chain, commands, ()), best_ms(chain, commands, SEVERAL)
    print(f"chain of a delta, {SAMPLES} samples ({len(VOCABULARY)} effects known)")
    print(f"  no effects    {nominal:6.2f} ms")
    print(f"  four effects  {several:6.2f} ms   limit {1e3 * LIMIT_S:.0f} ms")
    return 0 if several <= 1e3 * LIMIT_S else 1


if __name__ == "__main__":
    sys.exit(main())
