"""One run of a robot as a flat recording of the contract."""

from __future__ import annotations

from dataclasses import dataclass, field

import numpy as np

from deltactl.proof.ranging import Noise, Sensors, read
from deltactl.proof.robot.as_built import AsBuilt, FloatArray, StepTrain
from deltactl.proof.robot.run import Truth, run
from deltactl.recording.tables.flat import AnyArray, FlatRecording, from_columns

RATE_HZ = 50.0
FIRST_S = 0.04


@dataclass
class Machine:
    """A robot and its sensors."""

    robot: AsBuilt = field(default_factory=AsBuilt)
    sensors: Sensors = field(default_factory=Sensors)
    noise: Noise = field(default_factory=Noise)


def sample_times(train: StepTrain) -> FloatArray:
    """50 Hz, half-way between two ticks, so that counts are neither ahead nor late on average."""
    last = train.seconds - 2.0 / RATE_HZ
    return np.arange(FIRST_S, last, 1.0 / RATE_HZ) + 0.5 * train.t_pwm_s


def record(machine: Machine, train: StepTrain, rng: np.random.Generator) -> FlatRecording:
    """Run and write down. Raises UnreachablePoint when the robot cannot be assembled."""
    return record_with_truth(machine, train, rng)[0]


def record_with_truth(
    machine: Machine, train: StepTrain, rng: np.random.Generator
) -> tuple[FlatRecording, Truth]:
    """The same, and what really happened."""
    truth = run(machine.robot, train, rng.uniform(-1.0, 1.0, 3))
    t_s = sample_times(train)
    ranges, status = read(machine.sensors, machine.noise, truth, t_s, rng)
    return table(t_s, train, ranges, status), truth


def table(
    t_s: FloatArray, train: StepTrain, ranges_m: FloatArray, status: AnyArray
) -> FlatRecording:
    """The contract's columns."""
    counts = train.at(t_s)
    columns: dict[str, AnyArray] = {"t": np.round(t_s, 6)}
    columns |= {f"steps_{motor + 1}": counts[:, motor] for motor in range(3)}
    columns |= {f"range_{axis}": ranges_m[:, i] for i, axis in enumerate("xyz")}
    columns |= {f"status_{axis}": status[:, i] for i, axis in enumerate("xyz")}
    columns["t_pwm"] = np.full(len(t_s), train.t_pwm_s)
    return from_columns(columns, "proof")
