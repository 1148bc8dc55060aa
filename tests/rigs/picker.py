"""A delta that picks and places, recorded by its arm angles; its drives are of second order.

No effect of the vocabulary is: what a dead time and a first-order lag leave of such a drive is what
real recordings show. Not modelled: the linkage's load on the drives.
"""

from __future__ import annotations

from itertools import pairwise

import numpy as np
import yaml
from scipy.signal import cont2discrete, lfilter

from deltactl.models.robot import DeltaRobot, FloatArray
from deltactl.recording.tables.flat import FlatRecording

ROBOT = """kind: delta
name: picker
geometry: {base_radius_m: 0.122, platform_radius_m: 0.1, upper_arm_m: 0.3142, forearm_m: 0.5875}
"""
STEP_S = 0.02
STAYS = 30
HERTZ, DAMPING, SLOWED = 3.0, 0.7, 0.8
NOISE_RAD = 1e-4


def places(seed: int, stays: int = STAYS) -> FloatArray:
    """Commanded angles of pick and place, (n, 3): moves of half a second, and rests."""
    rng = np.random.default_rng(seed)
    stops = rng.uniform(0.1, 0.7, (40, 3))
    share = np.linspace(0.0, 1.0, 25)
    soft = share**3 * (10.0 - 15.0 * share + 6.0 * share**2)
    moves = [
        np.concatenate([a + soft[:, None] * (b - a), np.repeat(b[None], stays, 0)])
        for a, b in pairwise(stops)
    ]
    return np.concatenate(moves)


def followed(commanded: FloatArray, hertz: float) -> FloatArray:
    """What a drive of second order makes of commands, (n,)."""
    rate = 2.0 * np.pi * hertz
    b, a, _ = cont2discrete(([rate**2], [1.0, 2.0 * DAMPING * rate, rate**2]), STEP_S)
    moved: FloatArray = commanded[0] + lfilter(np.ravel(b), a, commanded - commanded[0])
    return moved


def recorded(
    seed: int,
    warm_rad: float = 0.0,
    first_hertz: float = HERTZ,
    all_rad: float = 0.0,
    stays: int = STAYS,
) -> FlatRecording:
    """The machine; the first encoder's zero may have moved, or that of all, the first drive have
    become slower. stays: rows of rest between moves of 25.
    """
    commanded = places(seed, stays)
    hertz = (first_hertz, HERTZ, HERTZ)
    pairs = zip(commanded.T, hertz, strict=True)
    moved = np.stack([followed(own, rate) for own, rate in pairs], axis=1)
    moved[:, 0] += warm_rad
    moved += all_rad
    read = moved + NOISE_RAD * np.random.default_rng(seed + 1).standard_normal(moved.shape)
    columns = {f"command_{arm + 1}": commanded[:, arm] for arm in range(3)}
    columns |= {f"theta_{arm + 1}": read[:, arm] for arm in range(3)}
    return FlatRecording(np.arange(len(read)) * STEP_S, columns, {}, f"day {seed}")


def nominal() -> DeltaRobot:
    """The machine as its file describes it: drives that follow at once."""
    return DeltaRobot.model_validate(yaml.safe_load(ROBOT))
