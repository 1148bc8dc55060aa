"""Warm-up and wear over robot-years: python -m benchmarks.proofs.warm_up [--years 100].

Each robot works by its own hours for a year, at a temperature that swings over the day and since
it was switched on. Three of the effects that do so follow the temperature, by up to four times what
one run detects; chance finds something in one run of 200; the play of one motor grows. Runs
are drawn from what one run detects (80 % power at the limit, as `run_checks` measures it) and not
diagnosed; what they announce is worked out by the code of `deltactl service check-runs`. Printed:
false announcements a robot-year, and the play at its announcement in detection limits.
"""

from __future__ import annotations

import argparse
import math
from dataclasses import dataclass
from typing import Any

import numpy as np

from deltactl.fleet.checks import RunsOfARobot
from deltactl.models.effects import CARDS, with_trait
from deltactl.models.effects.card import Trait
from deltactl.models.effects.gear_backlash import EFFECT as PLAY
from deltactl.models.effects.kind import EffectKind

Row = dict[str, Any]
HOUR_S, DAY_S, DAYS = 3600.0, 86400.0, 365
FOLLOWING = [CARDS[name].kind for name in with_trait(Trait.WARMS) if CARDS[name].kind is not None]
KINDS = [card.kind for card in CARDS.values() if card.kind is not None]
BY_CHANCE = [(kind, name) for kind in KINDS for name in kind.components]
CRITICAL, AT_LIMIT = 3.3, 3.3 + 0.84
"""Standard deviations from which a run has a finding, and of one at the limit: 80 % power."""
CHANCE, AT_ONCE = 1.0 / 200.0, 3


@dataclass(frozen=True)
class Year:
    """What became of one robot."""

    false: int
    """Times at which something was announced that is no wear."""
    play_at: float
    """Play at its announcement, in detection limits; NaN where it never was."""


def run_times_s(rng: np.random.Generator) -> np.ndarray[Any, np.dtype[np.float64]]:
    """By day, in two shifts, or around the clock, every one to three hours."""
    begins, lasts = [(8.0, 9.0), (6.0, 16.0), (0.0, 24.0)][rng.integers(3)]
    every = rng.uniform(1.0, 3.0)
    hours = np.arange(begins, begins + lasts, every)
    week = [day for day in range(DAYS) if lasts == 24.0 or day % 7 < 5]
    times_s: np.ndarray[Any, np.dtype[np.float64]] = np.concatenate(
        [day * DAY_S + (hours + rng.uniform(0.0, 0.2, len(hours))) * HOUR_S for day in week]
    )
    return times_s


def warmth(rng: np.random.Generator, t_s: Any) -> Any:
    """What follows the temperature, from -1 to about 1: of the day, and since switching on."""
    share, phase = rng.uniform(0.0, 1.0), rng.normal(0.0, 0.05)
    strong = rng.uniform(0.6, 1.0, DAYS + 1)[(t_s // DAY_S).astype(int)]
    by_day = strong * np.sin(2.0 * np.pi * (t_s / DAY_S - 0.375 + phase))
    on_s = (t_s % DAY_S) - (t_s % DAY_S).min()
    by_use = 1.0 - 2.0 * np.exp(-on_s / (rng.uniform(0.5, 2.0) * HOUR_S))
    return share * by_day + (1.0 - share) * by_use


def found(rng: np.random.Generator, size: float) -> float | None:
    """What one run makes of a size in detection limits; None where it has no finding."""
    seen = AT_LIMIT * size + rng.standard_normal()
    return float(seen / AT_LIMIT) if abs(seen) > CRITICAL else None


def year(seed: int) -> Year:
    """One robot, run by run."""
    rng = np.random.default_rng([seed, 41])
    t_s = run_times_s(rng)
    follow = [FOLLOWING[place] for place in rng.permutation(len(FOLLOWING))[:AT_ONCE]]
    strengths = rng.uniform(0.5, 4.0, AT_ONCE)
    # The robot file was made at the temperature of some hour of work.
    made, warm = rng.integers(len(t_s)), warmth(rng, t_s)
    swings = [much * 0.5 * (warm - warm[made]) for much in strengths]
    begins_s, grows_s = rng.uniform(0.2, 0.5) * DAYS * DAY_S, rng.uniform(40.0, 150.0) * DAY_S
    play = np.maximum(t_s - begins_s, 0.0) / grows_s  # 1 at the detection limit
    runs = RunsOfARobot()
    false, play_at = 0, math.nan
    known: set[tuple[str, str]] = set()
    for number, time_s in enumerate(t_s.tolist()):
        sizes = [
            _size(kind, kind.components[-1], swing[number], rng)
            for kind, swing in zip(follow, swings, strict=True)
        ]
        sizes.append(_size(PLAY, PLAY.components[0], play[number], rng))
        if rng.random() < CHANCE:
            kind, component = BY_CHANCE[rng.integers(len(BY_CHANCE))]
            sizes.append(_row(kind, component, float(rng.choice([-1.0, 1.0]))))
        findings = [size for size in sizes if size is not None]
        row = {"recording": f"{number}", "robot": "r", "time_s": time_s, "verdict": "x"}
        runs.add(row | {"findings": findings})
        told = {(one.effect, one.component) for one in runs.announced()}
        for key in told - known:
            if key == (PLAY.name, PLAY.components[0]):
                play_at = play[number] if math.isnan(play_at) else play_at
            else:
                false += 1
        known = told
    return Year(false, play_at)


def _size(kind: EffectKind, component: str, size: float, rng: np.random.Generator) -> Row | None:
    value = found(rng, size)
    return None if value is None else _row(kind, component, value)


def _row(kind: EffectKind, component: str, value: float) -> Row:
    """A finding whose first parameter is so many detection limits off."""
    parameter = kind.parameters[0]
    neutral = 1.0 if parameter.name.startswith("scale") else 0.0
    size = {"unit": parameter.unit, "value": neutral + value, "probability": 0.95}
    return {"effect": kind.name, "component": component, "parameter": parameter.name} | size


def main() -> None:
    """Print how often and when something is announced."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--years", type=int, default=100)
    parser.add_argument("--seed", type=int, default=1)
    given = parser.parse_args()
    years = [year(1000 * given.seed + number) for number in range(given.years)]
    false = np.array([one.false for one in years])
    at = np.array([one.play_at for one in years])
    print(
        f"{len(years)} robot-years: {false.mean():.2f} false announcements a year, most"
        f" {false.max()}; {np.mean(false <= 1):.0%} of the years have at most one"
    )
    print(
        f"play announced in {np.isfinite(at).sum()} of {len(at)}, at {np.nanmedian(at):.2f} times"
        f" the detection limit (median), at most {np.nanmax(at):.2f}"
    )


if __name__ == "__main__":
    main()
