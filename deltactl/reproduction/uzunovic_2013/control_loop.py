"""The references of both experiments, the control law on the simulated robot, and its recording."""

from __future__ import annotations

from dataclasses import dataclass
from time import perf_counter, process_time

import numpy as np

from deltactl.firmware_py.servo.law import AccelerationControl, LawSettings
from deltactl.foundation.process import PACKAGE
from deltactl.models.inverse_kinematics import InverseKinematics
from deltactl.models.network.inverse import InverseNetwork
from deltactl.models.robot import DeltaRobot, FloatArray
from deltactl.models.robot_files import load_delta
from deltactl.models.servo_drive import ServoDrive
from deltactl.proof.micro.as_built import MicroDelta, Three
from deltactl.proof.micro.bodies import PERIOD_S
from deltactl.proof.micro.plant import MicroPlant
from deltactl.recording.tables.flat import FlatRecording

ROBOT_FILE = PACKAGE / "config" / "uzunovic-2013.yaml"
NETWORK_FILE = PACKAGE / "models" / "trained" / "uzunovic-2013.tflite"
FREQUENCY_HZ = 0.2
CONTROL_ON_S = 1.0
"""Section 5: "control is activated at time instant t = 1 (s)"."""
PERIODS = 2
WHOLE_S = CONTROL_ON_S + PERIODS / FREQUENCY_HZ
"""How long an experiment is simulated: until control is on, and whole periods of it."""


@dataclass(frozen=True, slots=True)
class Experiment:
    """One experiment: its curve, the figures that show it, and what the paper reached."""

    name: str
    x_m: float
    y_m: float
    z_m: float
    y_turns: float
    """How many times as fast as x the curve's y goes round."""
    reference_figure: int
    response_figure: int
    paper_percent: float
    """Largest tracking error as per cent of peak to peak, "for all joints"."""

    def position_m(self, t_s: FloatArray) -> FloatArray:
        """Reference of the platform, (n, 3)."""
        turn = 2.0 * np.pi * FREQUENCY_HZ * t_s
        return np.stack(
            [
                self.x_m * np.sin(turn),
                self.y_m * np.cos(self.y_turns * turn),
                -0.075 + self.z_m * np.sin(turn),
            ],
            axis=1,
        )


EXPERIMENTS = (
    Experiment("first", 0.0045, 0.003, 0.002, 1.0, 7, 8, 1.1),
    # The second one's z is cut off in print ("-0.075 +"): taken as constant.
    Experiment("second", 0.003, 0.003, 0.0, 2.0, 9, 10, 0.7),
)


@dataclass(frozen=True, slots=True, eq=False)
class References:
    """One experiment at every tick: times (n,), platform (n, 3), arm angles (n, 3)."""

    experiment: Experiment
    t_s: FloatArray
    position_m: FloatArray
    angle_rad: FloatArray

    @property
    def peak_to_peak_rad(self) -> FloatArray:
        """Peak to peak of each joint's reference, (3,)."""
        ranges: FloatArray = np.ptp(self.angle_rad, axis=0)
        return ranges


def micro_delta() -> tuple[DeltaRobot, ServoDrive]:
    """The shipped robot file, and its drive."""
    robot = load_delta(ROBOT_FILE)
    assert isinstance(robot.drive, ServoDrive)
    return robot, robot.drive


def shipped_network() -> InverseNetwork:
    """The network inverse kinematics that comes with the robot file."""
    return InverseNetwork.open(NETWORK_FILE, micro_delta()[0])


def references(
    experiment: Experiment, inverse: InverseKinematics, period_s: float, seconds: float
) -> References:
    """Cartesian reference -> network -> arm angles, from t = 0. Raises what the network does."""
    t_s = np.arange(round(seconds / period_s)) * period_s
    position_m = experiment.position_m(t_s)
    return References(experiment, t_s, position_m, inverse.angles_rad_many(position_m))


START_RAD: Three = (np.pi / 6.0, np.pi / 6.0, np.pi / 6.0)
"""Section 3.1: "all joint angles were equal 30 (degrees)"; taken for section 5 too."""


@dataclass(frozen=True, slots=True, eq=False)
class Run:
    """One simulated experiment at every tick; arrays (n,) or (n, 3)."""

    t_s: FloatArray
    reference_rad: FloatArray
    measured_rad: FloatArray
    """By the encoders."""
    true_rad: FloatArray
    current_a: FloatArray
    disturbance_a: FloatArray
    """The observer's estimate."""
    on: int
    """First tick with control."""
    cpu_s: float
    wall_s: float

    @property
    def period_s(self) -> float:
        """One tick."""
        return float(self.t_s[1] - self.t_s[0])

    @property
    def times_real(self) -> float:
        """How many times faster than real time it ran, by process CPU time."""
        return float(self.t_s[-1]) / self.cpu_s


def run(
    settings: LawSettings,
    robot: MicroDelta,
    t_s: FloatArray,
    reference_rad: FloatArray,
    ahead_a: FloatArray | None = None,
    on_s: float = CONTROL_ON_S,
    start_rad: Three = START_RAD,
) -> Run:
    """Hold the arms until `on_s`, then control them along the references (n, 3).

    Before that the arms rest: held by brakes (friction alone would let them sink).
    ahead_a: currents (n, 3) that are given beside the law's, which knows nothing of them.
    Raises UnreachablePoint for a robot that cannot be put together, ValueError when the law's
    period is not the simulation's.
    """
    if abs(settings.period_s - PERIOD_S) > 1e-9:
        raise ValueError(f"the law runs every {settings.period_s} s, the robot every {PERIOD_S} s")
    plant = MicroPlant(robot, start_rad)
    law = AccelerationControl(settings)
    on = int(np.searchsorted(t_s, on_s - 1e-9))
    first, second, third = reference_rad[on].tolist()
    law.reset((first, second, third), plant.counts())
    given_a = np.zeros_like(reference_rad) if ahead_a is None else ahead_a
    given = np.concatenate([reference_rad, given_a], axis=1)[on:].tolist()
    rows, cpu_s, wall_s = _loop(law, plant, given)
    still = np.tile([*plant.counts_at(start_rad), *start_rad, *[0.0] * 6], (on, 1))
    table = np.concatenate([still, np.array(rows)])
    measured_rad = table[:, 0:3] * settings.rad_per_count
    others = table[:, 3:6], table[:, 6:9], table[:, 9:12]
    return Run(t_s, reference_rad, measured_rad, *others, on, cpu_s, wall_s)


def _loop(
    law: AccelerationControl, plant: MicroPlant, given: list[list[float]]
) -> tuple[list[tuple[float, ...]], float, float]:
    """Read, law, set, step; a row of (counts, true angles, currents, disturbances) each."""
    rows: list[tuple[float, ...]] = []
    note, read, true, advance = rows.append, plant.counts, plant.angles_rad, plant.advance
    first, second, third = law.joints
    one, two, three = first.tick, second.tick, third.tick
    cpu_s, wall_s = process_time(), perf_counter()
    for r1, r2, r3, f1, f2, f3 in given:
        c1, c2, c3 = read()
        a1, a2, a3 = true()
        i1, i2, i3 = one(r1, c1), two(r2, c2), three(r3, c3)
        i1, i2, i3 = i1 + f1, i2 + f2, i3 + f3
        advance(i1, i2, i3)
        d1, d2, d3 = first.disturbance_a, second.disturbance_a, third.disturbance_a
        note((c1, c2, c3, a1, a2, a3, i1, i2, i3, d1, d2, d3))
    return rows, process_time() - cpu_s, perf_counter() - wall_s


def recorded(ran: Run, drive: ServoDrive, source: str = "") -> FlatRecording:
    """Columns t, command_i, theta_i, current_i, disturbance_i, from the tick control came on."""
    ticks = max(1, drive.loop_rate_hz // drive.record_rate_hz)
    whole = (len(ran.t_s) - ran.on) // ticks * ticks
    rows = slice(ran.on, ran.on + whole)

    def mean(values: FloatArray) -> FloatArray:
        means: FloatArray = values[rows].reshape(-1, ticks, *values.shape[1:]).mean(axis=1)
        return means

    columns = {
        f"{stem}_{joint + 1}": mean(values)[:, joint]
        for stem, values in (
            ("command", ran.reference_rad),
            ("theta", ran.measured_rad),
            ("current", ran.current_a),
            ("disturbance", ran.disturbance_a),
        )
        for joint in range(3)
    }
    return FlatRecording(np.asarray(mean(ran.t_s)), columns, {}, source)
