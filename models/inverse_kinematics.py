"""Targets to step counts: one contract for inverse kinematics, and the way from angles to counts.

A job chooses geometry or a network; a planner sees an `InverseKinematics` either way and
asks `TargetMapper` for counts, which are checked against the arm limits.
"""

from __future__ import annotations

import math
from typing import Any, Protocol

import numpy as np

from foundation.errors import LimitExceeded
from models.chain.active import Active, at, of_entries
from models.chain.commands import Commands
from models.chain.delta import Chain
from models.effects.flow import Flow, Load
from models.effects.port import Port
from models.linkage import Linkage, inverse, inverse_one
from models.robot import ARMS, AnyDrive, DeltaRobot, FloatArray, Geometry

INVERTIBLE = frozenset(
    {
        *("gear_ratio", "transmission_error", "joint_compliance", "payload", "home_offset"),
        *("upper_arm_length", "forearm_length", "base_radius", "motor_azimuth"),
    }
)
"""Effects that give every commanded angle one true angle, and every pose one position."""
ROUNDS = 12
CLOSE_RAD = 1e-9
"""Angles are right to a ten-thousandth of a microstep and better."""

CountArray = np.ndarray[Any, np.dtype[np.int64]]


class InverseKinematics(Protocol):
    """Position to commanded arm angles; one and many give the same numbers to the last bit."""

    def angles_rad(self, x_m: float, y_m: float, z_m: float) -> tuple[float, float, float]:
        """Angles [rad] of one target [m].

        Raises UnreachablePoint where the linkage cannot go, LimitExceeded where the model
        may not be asked.
        """

    def angles_rad_many(self, position_m: FloatArray) -> FloatArray:
        """Angles [rad] of targets [m], both (n, 3). Raises at the first target that fails."""


class GeometricInverse:
    """Inverse kinematics in closed form (`models.linkage`)."""

    def __init__(self, geometry: Geometry):
        self.linkage = Linkage.of(geometry)

    def angles_rad(self, x_m: float, y_m: float, z_m: float) -> tuple[float, float, float]:
        """Commanded arm angles [rad] of one target [m]. Raises UnreachablePoint."""
        return inverse_one(self.linkage, x_m, y_m, z_m)

    def angles_rad_many(self, position_m: FloatArray) -> FloatArray:
        """Angles [rad] of targets [m], both (n, 3). Raises UnreachablePoint.

        Target by target: the vectorised form may differ in the last bit, which is enough to
        round to another count now and then.
        """
        return np.array(
            [inverse_one(self.linkage, *target) for target in _targets(position_m)],
            dtype=np.float64,
        ).reshape(-1, ARMS)


class CalibratedInverse:
    """Geometry with the robot file's known effects taken into account, turned round.

    Lengths and directions enter the closed form; what gears and arms add to an angle is taken off
    it again, round by round, until the chain answers with the angle that is wanted. Targets are
    positions of the platform itself: effects in sensors, and the frame they stand in, do not
    matter. Effects that remember (play, friction, lag) or that happen once have no inverse of
    this kind and are left out.
    """

    def __init__(self, robot: DeltaRobot):
        known = [active for active in of_entries(robot.effects) if active.kind.name in INVERTIBLE]
        plain = robot.model_copy(update={"effects": ()})
        self.effects = tuple(f"{active.kind.name} on {active.component}" for active in known)
        self.linkage = _linkage_with(Linkage.of(robot.geometry), at(known, Port.LINKAGE))
        self._chain = Chain(plain)
        self._angle_effects = [
            active for port in (Port.MOTOR, Port.GEAR, Port.ARM) for active in at(known, port)
        ]

    def angles_rad(self, x_m: float, y_m: float, z_m: float) -> tuple[float, float, float]:
        """Commanded arm angles [rad] of one target [m]. Raises UnreachablePoint."""
        wanted = inverse_one(self.linkage, x_m, y_m, z_m)
        if not self._angle_effects:
            return wanted
        first, second, third = self._commanded(np.array([wanted]))[0].tolist()
        return first, second, third

    def angles_rad_many(self, position_m: FloatArray) -> FloatArray:
        """Angles [rad] of targets [m], both (n, 3). Raises UnreachablePoint.

        Target by target, as `GeometricInverse` and for its reason.
        """
        rows = [self.angles_rad(*target) for target in _targets(position_m)]
        return np.array(rows, dtype=np.float64).reshape(-1, ARMS)

    def angles_rad_at_once(self, position_m: FloatArray) -> FloatArray:
        """The same for studies: fast, NaN where unreachable, not equal to the last bit."""
        return self._commanded(inverse(self.linkage, position_m).angles_rad)

    def _commanded(self, wanted_rad: FloatArray) -> FloatArray:
        commanded = wanted_rad
        for _ in range(ROUNDS):
            missing = wanted_rad - self._achieved(commanded)
            commanded = commanded + missing
            if not np.nanmax(np.abs(missing), initial=0.0) > CLOSE_RAD:
                break
        return commanded

    def _achieved(self, commanded_rad: FloatArray) -> FloatArray:
        """What the chain makes of commanded angles, (n, 3), before the linkage's own homes."""
        t_s = np.arange(len(commanded_rad), dtype=np.float64)
        course = self._chain.course(Commands.of_angles(t_s, commanded_rad))
        flow = Flow(
            t_s=t_s,
            fresh=np.ones(len(t_s), dtype=np.bool_),
            start_s=0.0,
            angles_rad=commanded_rad.copy(),
            load_of=course.load,
        )
        for active in self._angle_effects:
            active.act(flow)
        return flow.angles_rad


def _linkage_with(linkage: Linkage, effects: list[Active]) -> Linkage:
    names = ("radius_m", "upper_arm_m", "forearm_m", "azimuth_rad", "home_offset_rad")
    nowhere = np.zeros((1, ARMS))
    flow = Flow(np.zeros(1), np.ones(1, dtype=np.bool_), 0.0, nowhere, _no_load)
    flow.linkage = {name: np.array(getattr(linkage, name)) for name in names}
    for active in effects:
        active.act(flow)
    return linkage.with_(**flow.linkage)


def _no_load() -> Load:
    return Load(np.zeros((1, ARMS)), np.zeros((1, ARMS)))


class TargetMapper:
    """Turns targets into step counts that respect the arm limits.

    Count 0 is commanded angle 0. A limit falls on the nearest whole microstep, so an arm
    stays within half a microstep of it.
    """

    def __init__(
        self, kinematics: InverseKinematics, drive: AnyDrive, arm_limits_deg: tuple[float, float]
    ):
        self.kinematics = kinematics
        self.rad_per_step = drive.rad_per_step
        self.arm_limits_deg = arm_limits_deg
        low_deg, high_deg = arm_limits_deg
        self.low_steps = round(math.radians(low_deg) / self.rad_per_step)
        self.high_steps = round(math.radians(high_deg) / self.rad_per_step)
        self._angles_rad = kinematics.angles_rad

    def counts(self, x_m: float, y_m: float, z_m: float) -> tuple[int, int, int]:
        """Step counts of one target [m]. Raises UnreachablePoint or LimitExceeded."""
        first_rad, second_rad, third_rad = self._angles_rad(x_m, y_m, z_m)
        step_rad = self.rad_per_step
        first, second, third = (
            round(first_rad / step_rad),
            round(second_rad / step_rad),
            round(third_rad / step_rad),
        )
        low, high = self.low_steps, self.high_steps
        if not (low <= first <= high and low <= second <= high and low <= third <= high):
            raise self._beyond((x_m, y_m, z_m), (first, second, third))
        return first, second, third

    def counts_many(self, position_m: FloatArray) -> CountArray:
        """Step counts of targets [m], both (n, 3): the same numbers as `counts` gives.

        Raises UnreachablePoint or LimitExceeded at the first target that fails.
        """
        rows = [self.counts(*target) for target in _targets(position_m)]
        return np.array(rows, dtype=np.int64).reshape(-1, ARMS)

    def angles_to_counts(self, angles_rad: FloatArray) -> CountArray:
        """Counts (n, 3) of commanded arm angles [rad] (n, 3), e.g. of a path in joint space.

        Raises LimitExceeded at the first row that breaks an arm limit.
        """
        angles = np.asarray(angles_rad, dtype=np.float64).reshape(-1, ARMS)
        counts = np.rint(angles / self.rad_per_step)
        # Asked this way round, NaN is outside too.
        inside = ((counts >= self.low_steps) & (counts <= self.high_steps)).all(axis=1)
        if not inside.all():
            raise self._beyond(None, tuple(counts[int(np.argmin(inside))].tolist()))
        whole: CountArray = counts.astype(np.int64)
        return whole

    def counts_to_angles(self, counts: CountArray) -> FloatArray:
        """Commanded arm angles [rad] of counts, same shape."""
        return np.asarray(counts, dtype=np.float64) * self.rad_per_step

    def _beyond(
        self, target_m: tuple[float, float, float] | None, counts: tuple[float, ...]
    ) -> LimitExceeded:
        low_deg, high_deg = self.arm_limits_deg
        arm, count = next(
            (arm, count)
            for arm, count in enumerate(counts, start=1)
            if not self.low_steps <= count <= self.high_steps
        )
        angle_deg = math.degrees(count * self.rad_per_step)
        where = "" if target_m is None else "target ({:.4f}, {:.4f}, {:.4f}) m: ".format(*target_m)
        return LimitExceeded(
            f"{where}arm {arm} would be at {angle_deg:.2f} deg, outside its limits of "
            f"{low_deg:g} to {high_deg:g} deg; move the path or make it smaller"
        )


def _targets(position_m: FloatArray) -> list[tuple[float, float, float]]:
    """Rows as plain floats: arithmetic on numpy scalars is several times slower."""
    rows: list[tuple[float, float, float]]
    rows = np.asarray(position_m, dtype=np.float64).reshape(-1, ARMS).tolist()
    return rows
