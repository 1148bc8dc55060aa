"""What is run: the paper's law, ours with feedforward of friction, and both with something wrong.

Feedforward: at a reversal Coulomb friction changes by twice its size at once, and the observer
needs a few of its time constants to see it: that is nearly all of the tracking error. The reference
says when a joint will turn, and the robot file how large the friction is, so the current that it
takes can be given at that moment. The observer then sees only what the file has wrong.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, replace

import numpy as np

from deltactl.firmware_py.servo.law import LawSettings
from deltactl.models.robot import FloatArray
from deltactl.models.servo_drive import ServoDrive
from deltactl.proof.micro.as_built import Drives, MicroDelta, Three
from deltactl.reproduction.uzunovic_2013.control_loop import CONTROL_ON_S, References, Run, run

FULL_AT_RADPS = 0.003
"""Speed of the arm's reference at which the whole friction is given. Slower, a part in proportion:
0.003 rad/s are 17 encoder counts a second."""


def friction_current_a(drive: ServoDrive, reference_rad: FloatArray) -> FloatArray:
    """Currents (n, 3) against the Coulomb friction of the robot file, for references (n, 3)."""
    speed_radps = np.gradient(reference_rad, drive.period_s, axis=0)
    whole_a = drive.coulomb_nm / drive.torque_constant_nmpa
    current: FloatArray = whole_a * np.clip(speed_radps / FULL_AT_RADPS, -1.0, 1.0)
    return current


SETTLED_S = 1.0
"""So long after control comes on tracking is judged: 11 time constants of eq. 5's slow pole."""
CALM_VELOCITY_RADPS, CALM_DISTURBANCE_RADPS = 2000.0, 1000.0
"""56 degrees of phase margin (docs/decisions/acceleration-control.md), a quarter of the ripple."""
PAYLOAD_KG = 0.006
"""As much as the platform itself."""


@dataclass(frozen=True, slots=True)
class Control:
    """A way to control: the paper's law, its observer's state, and what is given beside it."""

    name: str
    change: Callable[[LawSettings], LawSettings] = lambda settings: settings
    friction_ahead: bool = False

    def without_observer(self) -> Control:
        """The same with the disturbance estimate left out of the current."""
        return Control(
            f"{self.name}, observer off",
            lambda settings: replace(self.change(settings), disturbance_observer=False),
            self.friction_ahead,
        )


PAPER = Control("paper's law")
OURS = Control(
    "slow observers, friction feedforward",
    lambda settings: replace(
        settings,
        velocity_bandwidth_radps=CALM_VELOCITY_RADPS,
        disturbance_bandwidth_radps=CALM_DISTURBANCE_RADPS,
    ),
    friction_ahead=True,
)
"""Observers slow enough for the encoder, and the friction that is known need not be observed."""


def _coulomb_doubled(robot: MicroDelta) -> MicroDelta:
    drives = robot.drives
    return replace(
        robot,
        drives=replace(
            drives,
            rotor_coulomb_nm=_twice(drives.rotor_coulomb_nm),
            bearing_coulomb_nm=_twice(drives.bearing_coulomb_nm),
        ),
    )


def _twice(values: Three) -> Three:
    first, second, third = values
    return 2.0 * first, 2.0 * second, 2.0 * third


def _loaded(robot: MicroDelta) -> MicroDelta:
    return replace(robot, body=replace(robot.body, payload_kg=PAYLOAD_KG))


def _inertia(scale: float) -> Callable[[LawSettings], LawSettings]:
    return lambda settings: replace(
        settings, nominal_inertia_kgm2=scale * settings.nominal_inertia_kgm2
    )


@dataclass(frozen=True, slots=True)
class Trouble:
    """What differs from the parameters of the law."""

    name: str
    robot: Callable[[MicroDelta], MicroDelta] = lambda robot: robot
    change: Callable[[LawSettings], LawSettings] = lambda settings: settings


NOTHING = Trouble("nothing wrong")
TROUBLES = (
    NOTHING,
    Trouble("inertia in the law 50 % too small", change=_inertia(0.5)),
    Trouble("inertia in the law 50 % too large", change=_inertia(1.5)),
    Trouble("Coulomb friction doubled", _coulomb_doubled),
    Trouble("payload of 6 g", _loaded),
)


@dataclass(frozen=True, slots=True, eq=False)
class Tracking:
    """How well a run followed, from SETTLED_S after control came on; arrays (3,)."""

    run: Run
    most_percent: FloatArray
    """Largest |measured - reference| as per cent of the reference's peak to peak."""
    rms_percent: FloatArray
    overshoot_percent: FloatArray
    """Overshoot beyond the reference, as a part of the way from the start."""
    current_rms_a: FloatArray


def simulate(
    drive: ServoDrive, asked: References, control: Control, trouble: Trouble = NOTHING
) -> Tracking:
    """One experiment under one control with one thing wrong."""
    settings = trouble.change(control.change(LawSettings.of(drive)))
    ahead = friction_current_a(drive, asked.angle_rad) if control.friction_ahead else None
    robot = trouble.robot(MicroDelta(drives=Drives()))
    return judged(asked, run(settings, robot, asked.t_s, asked.angle_rad, ahead))


def judged(asked: References, ran: Run) -> Tracking:
    """Errors of a run as the paper gives them."""
    late = ran.t_s >= CONTROL_ON_S + SETTLED_S - 1e-9
    percent = 100.0 / asked.peak_to_peak_rad
    error = ran.measured_rad - ran.reference_rad
    way = error[ran.on]
    beyond = np.max(-np.sign(way) * error[ran.on :][: round(SETTLED_S / ran.period_s)], axis=0)
    return Tracking(
        ran,
        np.abs(error[late]).max(axis=0) * percent,
        np.sqrt(np.mean(error[late] ** 2, axis=0)) * percent,
        100.0 * np.maximum(beyond, 0.0) / np.abs(way),
        np.sqrt(np.mean(ran.current_a[ran.on :] ** 2, axis=0)),
    )
