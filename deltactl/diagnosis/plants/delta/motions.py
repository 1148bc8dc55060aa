"""Candidate motions: a small table of paths in arm angles, each kept inside the safe poses.

All are closed and given as arm angles, straight in joint space, so that a job repeats them
exactly and what was checked here is what the planner drives.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass

import numpy as np

from deltactl.diagnosis.observations.readings import FloatArray
from deltactl.diagnosis.plants.delta.options import NEXT_RUNS
from deltactl.diagnosis.plants.delta.safe_poses import MotionLimits, is_safe
from deltactl.models.linkage import Linkage, Status, forward, inverse


@dataclass(frozen=True, slots=True, eq=False)
class Motion:
    """A closed path: arm angles (k, 3) [deg], a rest at each, and the step period."""

    name: str
    says: str
    angles_deg: FloatArray
    dwell_s: float
    t_pwm_s: float

    @property
    def angles_rad(self) -> FloatArray:
        """The same in radians."""
        return np.deg2rad(self.angles_deg)


@dataclass(frozen=True, slots=True, eq=False)
class Space:
    """Where motions may go: linkage, limits, and the span of angles that is used."""

    linkage: Linkage
    limits: MotionLimits

    @property
    def span_deg(self) -> tuple[float, float]:
        """Lowest and highest angle used [deg]."""
        low, high = self.limits.arm_deg
        edge = NEXT_RUNS.off_limits * (high - low)
        return max(low + edge, NEXT_RUNS.lowest_deg), min(high - edge, NEXT_RUNS.highest_deg)

    def angle(self, share: float) -> float:
        """Angle at a share of the span [deg]."""
        low, high = self.span_deg
        return low + share * (high - low)

    def safe(self, angles_deg: FloatArray) -> bool:
        """Whether a path may be driven."""
        return is_safe(self.linkage, self.limits, np.deg2rad(angles_deg))


Path = FloatArray
Maker = Callable[[Space, float], Path | None]


def _survey(space: Space, size: float) -> Path:
    """Random angles, each reached safely from the one before, and back."""
    rng = np.random.default_rng(NEXT_RUNS.survey_seed)
    low, high = space.angle(0.5 - 0.5 * size), space.angle(0.5 + 0.5 * size)
    start = np.full(3, space.angle(0.4))
    path = [start]
    for _ in range(NEXT_RUNS.survey_tries * NEXT_RUNS.survey_poses):
        pose = np.round(rng.uniform(low, high, 3), 1)
        if space.safe(np.array([path[-1], pose])) and space.safe(np.array([pose, start])):
            path.append(pose)
        if len(path) > NEXT_RUNS.survey_poses:
            break
    return np.array([*path, start])


def _circle(way: tuple[int, ...], heights: tuple[float, ...] = NEXT_RUNS.heights) -> Maker:
    """Level circles, one turn for each way (+1 counter-clockwise) at each height."""

    def make(space: Space, size: float) -> Path | None:
        laps = []
        for height in heights:
            middle = np.deg2rad(np.full(3, space.angle(height)))
            centre = forward(space.linkage, middle).position_m
            turn = 2.0 * np.pi * np.arange(NEXT_RUNS.corners + 1) / NEXT_RUNS.corners
            radius = NEXT_RUNS.circle_share * size * float(np.min(space.linkage.forearm_m))
            flat = radius * np.stack([np.cos(turn), np.sin(turn), 0.0 * turn], axis=1)
            arms = inverse(space.linkage, centre + flat)
            if (arms.status != Status.OK).any():
                return None
            lap = np.round(np.rad2deg(arms.angles_rad), 2)
            laps += [lap if sign > 0 else lap[::-1] for sign in way]
        path: Path = np.concatenate([*laps, laps[0][:1]])
        return path

    return make


def _one_by_one(motors: Sequence[int], shares: Sequence[float]) -> Maker:
    """Each motor goes to these shares of its span, the others resting."""

    def make(space: Space, size: float) -> Path:
        rest = np.full(3, space.angle(0.4))
        path = [rest]
        for motor in motors:
            for share in shares:
                pose = rest.copy()
                pose[motor] = space.angle(0.5 + size * (share - 0.5))
                path.append(pose)
            path.append(rest)
        return np.round(np.array(path), 2)

    return make


def _up_and_down(space: Space, size: float) -> Path:
    """All arms alike: straight up and down, with stops on the way."""
    shares = [0.5, 0.25, 0.0, 0.25, 0.5, 0.75, 1.0, 0.75, 0.5]
    return np.round(np.array([[space.angle(0.5 + size * (s - 0.5))] * 3 for s in shares]), 2)


def _corners(space: Space, size: float) -> Path:
    """The far poses: each arm at either end with the others at either end."""
    ends = [space.angle(0.5 - 0.5 * size), space.angle(0.5 + 0.5 * size)]
    middle = np.full(3, space.angle(0.4))
    far = [[ends[code >> arm & 1] for arm in range(3)] for code in (1, 3, 2, 6, 4, 5)]
    return np.round(np.array([middle, *far, middle]), 2)


def motions(
    linkage: Linkage, limits: MotionLimits, rad_per_step: float, top_radps: float, motors: set[int]
) -> Iterator[Motion]:
    """Every motion of the table at the sizes and speeds that are safe.

    top_radps: highest joint speed of the recording. motors: those (from 0) the tie is about.
    """
    space = Space(linkage, limits)
    fast = min(max(top_radps, NEXT_RUNS.fast_radps), limits.joint_speed_radps)
    own = sorted(motors) or [0, 1, 2]
    each = f"motor {' and '.join(str(m + 1) for m in own)}"
    both_sides = [share + away for share in NEXT_RUNS.approached for away in NEXT_RUNS.from_beside]
    sweep = _one_by_one(own, NEXT_RUNS.sweep)
    table: list[tuple[str, str, Maker, float, tuple[float, ...]]] = [
        ("survey", "random poses", _survey, 0.0, (fast, 0.25 * fast)),
        ("survey-rests", "random poses with rests", _survey, 1.0, (fast,)),
        ("circle", "a level circle, one way", _circle((1,), NEXT_RUNS.heights[:1]), 0.0, (fast,)),
        (
            "circles-both-ways", "circles both ways round at two heights",
            _circle((1, -1)), 0.0, (0.4 * fast, 0.1 * fast),
        ),
        (
            "both-sides", f"rests of {each} approached from both sides",
            _one_by_one(own, both_sides), 0.5, (fast, 0.2 * fast),
        ),
        ("sweep", f"long sweeps of {each} with reversals", sweep, 0.2, (fast, 0.25 * fast)),
        ("up-and-down", "straight up and down with stops", _up_and_down, 0.5, (fast, 0.25 * fast)),
        ("far-poses", "rests at poses far apart", _corners, 1.0, (fast,)),
    ]  # fmt: skip
    for name, says, maker, dwell_s, speeds in table:
        path = _largest(space, maker)
        if path is None:
            continue
        for speed in speeds:
            period = float(np.round(max(rad_per_step / speed, limits.shortest_period_s), 5))
            pace = "" if speed == speeds[0] else "-slow"
            yield Motion(name + pace, says, path, dwell_s, period)


def _largest(space: Space, maker: Maker) -> Path | None:
    """The path at the largest size that is safe."""
    for size in NEXT_RUNS.sizes:
        path = maker(space, size)
        if path is not None and len(path) > 2 and space.safe(path):
            return path
    return None
