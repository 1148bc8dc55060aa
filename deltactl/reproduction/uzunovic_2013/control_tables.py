"""Section 5 in numbers: tracking beside the paper's, and what the observer buys."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from deltactl.models.robot import FloatArray
from deltactl.models.servo_drive import ServoDrive
from deltactl.reproduction.uzunovic_2013.control_references import Experiment, References
from deltactl.reproduction.uzunovic_2013.control_variants import (
    OURS,
    PAPER,
    Control,
    Tracking,
    Trouble,
)

Row = tuple[str, ...]


@dataclass(frozen=True, slots=True)
class TextTable:
    """A table as text, for the console and for HTML alike. The first `names` columns are words."""

    title: str
    head: Row
    rows: tuple[Row, ...]
    note: str = ""
    names: int = 1


@dataclass(frozen=True, slots=True, eq=False)
class Result:
    """One run and what was asked of it."""

    asked: References
    control: Control
    trouble: Trouble
    observed: bool
    tracking: Tracking

    @property
    def experiment(self) -> Experiment:
        """The experiment it belongs to."""
        return self.asked.experiment


def tracking_table(results: Sequence[Result], drive: ServoDrive) -> TextTable:
    """Experiments as published: per joint, beside the paper's figure and half of it."""
    rows = []
    for found in results:
        seen, paper = found.tracking, found.experiment.paper_percent
        worst = float(seen.most_percent.max())
        rows.append(
            (
                found.experiment.name,
                found.control.name,
                *(f"{value:.2f}" for value in seen.most_percent),
                f"{paper:g}",
                "yes" if worst <= 0.5 * paper else "no",
                f"{seen.rms_percent.max():.2f}",
                f"{seen.overshoot_percent.max():.1f}",
                f"{1e3 * seen.current_rms_a.max():.0f}",
            )
        )
    return TextTable(
        "Tracking error, % of the reference's peak to peak (largest, from 1 s after control is on)",
        (
            "experiment", "control", "joint 1", "joint 2", "joint 3", "paper", "half of it met",
            "RMS", "overshoot %", "current RMS mA",
        ),
        tuple(rows),
        floor_note([found.asked for found in results], drive),
        names=2,
    )  # fmt: skip


def floor_note(asked: Sequence[References], drive: ServoDrive) -> str:
    """What the encoder alone allows."""
    parts = []
    for references in {one.experiment.name: one for one in asked}.values():
        count = 100.0 * drive.rad_per_count / references.peak_to_peak_rad
        parts.append(f"{references.experiment.name}: {_joints(0.5 * count)} %")
    return (
        "Floor: half an encoder count (0.005 degrees), below which no measured error can be, is "
        + ", ".join(parts)
        + " of peak to peak (joints 1, 2, 3)."
    )


def observer_table(results: Sequence[Result]) -> TextTable:
    """Worst joint with the observer on and off, row by row what is wrong."""

    def worst(experiment: str, trouble: str, control: Control, observed: bool) -> str:
        for found in results:
            same = found.trouble.name == trouble and found.control.name == control.name
            if same and found.observed == observed and found.experiment.name == experiment:
                value = float(found.tracking.most_percent.max())
                return f"{value:.2f}" if value < 10.0 else f"{value:.0f}"
        return "-"

    rows = [
        (
            experiment, trouble,
            worst(experiment, trouble, PAPER, True), worst(experiment, trouble, PAPER, False),
            worst(experiment, trouble, OURS, True), worst(experiment, trouble, OURS, False),
        )
        for experiment in dict.fromkeys(found.experiment.name for found in results)
        for trouble in dict.fromkeys(found.trouble.name for found in results)
    ]  # fmt: skip
    return TextTable(
        "What the disturbance observer buys: largest tracking error of the worst joint, % of peak"
        " to peak",
        (
            "experiment", "what is wrong", "paper's law", "observer off", "slow observers",
            "observer off",
        ),
        tuple(rows),
        "slow observers: of 2000 and 1000 rad/s in place of the robot file's, and the Coulomb "
        "friction of the robot file as feedforward, with the sign of the reference's speed. "
        "Observer off: gravity alone moves the arms by more than the whole motion.",
        names=2,
    )  # fmt: skip


def speed_table(results: Sequence[Result]) -> TextTable:
    """How fast whole experiments were simulated."""
    cpu = [found.tracking.run.times_real for found in results]
    ran = [found.tracking.run for found in results]
    wall = [float(run.t_s[-1] - run.t_s[run.on]) / run.wall_s for run in ran]
    ticks = [1e6 * run.cpu_s / (len(run.t_s) - run.on) for run in ran]
    return TextTable(
        "Speed: whole experiments, law and MuJoCo together",
        ("", "median", "worst"),
        (
            ("times real time, process CPU", f"{np.median(cpu):.1f}", f"{min(cpu):.1f}"),
            ("times real time, wall clock", f"{np.median(wall):.1f}", f"{min(wall):.1f}"),
            ("a tick of all, CPU us", f"{np.median(ticks):.1f}", f"{max(ticks):.1f}"),
        ),
    )


def _joints(values: FloatArray) -> str:
    return ", ".join(f"{value:.2f}" for value in values)
