"""Readings of the proof's robot without noise, rounding, dropouts or repeated values."""

from __future__ import annotations

from deltactl.proof.ranging import ideal_ranges
from deltactl.proof.recorded import Machine, sample_times
from deltactl.proof.robot.as_built import FloatArray, StepTrain
from deltactl.proof.robot.run import run


def clean_ranges(machine: Machine, train: StepTrain) -> FloatArray:
    """Shape (n, 3), at `sample_times`."""
    return ideal_ranges(machine.sensors, run(machine.robot, train), sample_times(train))
