"""Geometry with what is known of a robot taken into account: from targets to angles, and back."""

from __future__ import annotations

import numpy as np

from deltactl.models.chain.active import Active, at, of_entries
from deltactl.models.chain.commands import Commands
from deltactl.models.chain.delta import Chain
from deltactl.models.effects import Compensated, compensated
from deltactl.models.effects.flow import Flow, Load
from deltactl.models.effects.kind import Port
from deltactl.models.effects.tables import shifted
from deltactl.models.inverse_kinematics import targets_of
from deltactl.models.linkage import Linkage, forward, inverse, inverse_one
from deltactl.models.linkage.scalar import forward_one
from deltactl.models.linkage.vectors import Vector
from deltactl.models.robot import ARMS, DeltaRobot, EffectEntry, FloatArray

ROUNDS = 30
CLOSE_RAD = 1e-9
"""Angles are right to a ten-thousandth of a microstep and better."""


def corrections_of(robot: DeltaRobot) -> tuple[EffectEntry, ...]:
    """What of a robot's effects an inverse can take into account; where it comes from left out."""
    known = compensated(Compensated.INVERSE)
    return tuple(
        entry.model_copy(update={"found": None}) for entry in robot.effects if entry.effect in known
    )


class CalibratedInverse:
    """Geometry with the robot file's known effects taken into account, turned round.

    Lengths and directions enter the closed form; what gears and arms add to an angle is taken off
    it again, round by round, until the chain answers with the angle that is wanted. Targets are
    positions of the platform itself: effects in sensors, and their frame, do not
    matter. Effects that remember (play, friction, lag) or that happen once have no inverse of
    this kind and are left out.
    """

    def __init__(self, robot: DeltaRobot):
        known = of_entries(corrections_of(robot))
        plain = robot.model_copy(update={"effects": ()})
        self.effects = tuple(f"{active.kind.name} on {active.component}" for active in known)
        self.linkage = _linkage_with(Linkage.of(robot.geometry), at(known, Port.LINKAGE))
        self._chain = Chain(plain)
        self._angle_effects = [
            active for port in (Port.MOTOR, Port.GEAR, Port.ARM) for active in at(known, port)
        ]
        self._place_effects = at(known, Port.PLATFORM)

    def angles_rad(self, x_m: float, y_m: float, z_m: float) -> tuple[float, float, float]:
        """Commanded arm angles [rad] of one target [m]. Raises UnreachablePoint."""
        if self._place_effects:
            x_m, y_m, z_m = self._assembled_m(np.array([[x_m, y_m, z_m]]))[0].tolist()
        wanted = inverse_one(self.linkage, x_m, y_m, z_m)
        if not self._angle_effects:
            return wanted
        first, second, third = self._commanded(np.array([wanted]))[0].tolist()
        return first, second, third

    def angles_rad_many(self, position_m: FloatArray) -> FloatArray:
        """Angles [rad] of targets [m], both (n, 3). Raises UnreachablePoint.

        Target by target, as `GeometricInverse` and for its reason.
        """
        rows = [self.angles_rad(*target) for target in targets_of(position_m)]
        return np.array(rows, dtype=np.float64).reshape(-1, ARMS)

    def angles_rad_at_once(self, position_m: FloatArray) -> FloatArray:
        """The same for studies: fast, NaN where unreachable, not equal to the last bit."""
        assembled_m = self._assembled_m(np.asarray(position_m, dtype=np.float64))
        return self._commanded(inverse(self.linkage, assembled_m).angles_rad)

    def position_m(self, commanded_rad: FloatArray) -> FloatArray:
        """Where the platform is [m] when arms are commanded to angles [rad], both (n, 3)."""
        commanded_rad = np.asarray(commanded_rad, dtype=np.float64)
        return self.place_m(self.achieved_rad(commanded_rad))

    def position_of_one_m(self, commanded_rad: Vector) -> Vector:
        """`position_m` of one pose; NaN where the linkage cannot be assembled."""
        if self._angle_effects or self._place_effects:
            x_m, y_m, z_m = self.position_m(np.array([commanded_rad]))[0].tolist()
            return x_m, y_m, z_m
        return forward_one(self.linkage, commanded_rad)

    def place_m(self, true_rad: FloatArray) -> FloatArray:
        """Where the platform is [m] when arms are at angles [rad], both (..., 3)."""
        position_m = forward(self.linkage, true_rad).position_m
        if not self._place_effects:
            return position_m
        rows_m = position_m.reshape(-1, 3)
        for active in self._place_effects:
            rows_m = shifted(active.values, rows_m)
        return rows_m.reshape(position_m.shape)

    def _assembled_m(self, wanted_m: FloatArray) -> FloatArray:
        """Where the linkage is to put the platform, (n, 3), so that tables bring it to targets."""
        assembled_m = wanted_m
        for _ in range(ROUNDS if self._place_effects else 0):
            reached_m = assembled_m
            for active in self._place_effects:
                reached_m = shifted(active.values, reached_m)
            assembled_m = assembled_m + wanted_m - reached_m
        return assembled_m

    def _commanded(self, wanted_rad: FloatArray) -> FloatArray:
        commanded = wanted_rad
        for _ in range(ROUNDS):
            missing = wanted_rad - self.achieved_rad(commanded)
            commanded = commanded + missing
            if not np.nanmax(np.abs(missing), initial=0.0) > CLOSE_RAD:
                break
        return commanded

    def achieved_rad(self, commanded_rad: FloatArray) -> FloatArray:
        """What the chain makes of commanded angles, (n, 3), before the linkage's own homes."""
        if not self._angle_effects:
            return commanded_rad
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
