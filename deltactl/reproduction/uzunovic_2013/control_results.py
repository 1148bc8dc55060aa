"""Section 5 in numbers and figures: tracking beside the paper's, and what the observer buys."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from deltactl.charts.figures import LineChart
from deltactl.charts.page import columns
from deltactl.charts.spec import Colour, Mark, Series
from deltactl.models.robot import FloatArray
from deltactl.models.servo_drive import ServoDrive
from deltactl.reproduction.outcome import Sheet
from deltactl.reproduction.uzunovic_2013.control_loop import (
    CONTROL_ON_S,
    Experiment,
    References,
)
from deltactl.reproduction.uzunovic_2013.control_variants import (
    OURS,
    PAPER,
    Control,
    Tracking,
    Trouble,
)


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


def tracking_table(results: Sequence[Result], drive: ServoDrive) -> Sheet:
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
    return Sheet(
        "Tracking error, % of the reference's peak to peak (largest, from 1 s after control is on)",
        (
            *("experiment", "control", "joint 1", "joint 2", "joint 3", "paper"),
            *("half of it met", "RMS", "overshoot %", "current RMS mA"),
        ),
        tuple(rows),
        2,
        floor_note([found.asked for found in results], drive),
    )


def floor_note(asked: Sequence[References], drive: ServoDrive) -> str:
    """What the encoder alone allows."""
    parts = []
    for references in {run.experiment.name: run for run in asked}.values():
        count = 100.0 * drive.rad_per_count / references.peak_to_peak_rad
        parts.append(f"{references.experiment.name}: {_joints(0.5 * count)} %")
    return (
        "Floor: half an encoder count (0.005 degrees), below which no measured error can be, is "
        + ", ".join(parts)
        + " of peak to peak (joints 1, 2, 3)."
    )


def observer_table(results: Sequence[Result]) -> Sheet:
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
            experiment,
            trouble,
            worst(experiment, trouble, PAPER, True),
            worst(experiment, trouble, PAPER, False),
            worst(experiment, trouble, OURS, True),
            worst(experiment, trouble, OURS, False),
        )
        for experiment in dict.fromkeys(found.experiment.name for found in results)
        for trouble in dict.fromkeys(found.trouble.name for found in results)
    ]
    return Sheet(
        "What the disturbance observer buys: largest tracking error of the worst joint, % of peak"
        " to peak",
        (
            "experiment",
            "what is wrong",
            "paper's law",
            "observer off",
            "slow observers",
            "observer off",
        ),
        tuple(rows),
        2,
        "slow observers: of 2000 and 1000 rad/s in place of the robot file's, and the Coulomb "
        "friction of the robot file as feedforward, with the sign of the reference's speed. "
        "Observer off: gravity alone moves the arms by more than the whole motion.",
    )


def speed_table(results: Sequence[Result]) -> Sheet:
    """How fast whole experiments were simulated."""
    cpu = [found.tracking.run.times_real for found in results]
    ran = [found.tracking.run for found in results]
    wall = [float(run.t_s[-1] - run.t_s[run.on]) / run.wall_s for run in ran]
    ticks = [1e6 * run.cpu_s / (len(run.t_s) - run.on) for run in ran]
    return Sheet(
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


EVERY = 20
"""Angles are drawn at 500 Hz."""
SLOWLY = 200
"""Disturbances are drawn as means over 20 ms: in between they are the encoder's comb."""
SHOWN_FROM_S = CONTROL_ON_S + 0.6
"""Errors are drawn once the way from the start is nearly over."""
COLOURS = (Colour.FIRST, Colour.SECOND, Colour.THIRD)


def reference_figure(asked: References) -> str:
    """Figure 7 or 9: the path of the platform, from above and from the side."""
    number = asked.experiment.reference_figure
    x, y, z = (1e3 * asked.position_m[::EVERY, axis] for axis in range(3))
    from_above = f"reference of the {asked.experiment.name} experiment, from above"
    return columns(
        [
            LineChart(
                *(f"Figure {number}: {title}", "x [mm]", f"{axis} [mm]"),
                [Series("reference", x, values, Colour.ASKED)],
                equal_aspect=True,
            ).html()
            for title, axis, values in ((from_above, "y", y), ("the same from the side", "z", z))
        ]
    )


def response_figures(found: Result) -> list[str]:
    """Figure 8 or 10: each joint's angle, and below it error and estimated disturbance."""
    ran, name = found.tracking.run, found.experiment.name
    number, group = found.experiment.response_figure, f"response-{found.experiment.name}"
    on = [Mark(CONTROL_ON_S, "control on")]
    t_s = ran.t_s[::EVERY]
    asked_deg, seen_deg = (np.degrees(q[::EVERY]) for q in (ran.reference_rad, ran.measured_rad))
    parts = [
        LineChart(
            f"Figure {number}: joint {joint + 1}, {name} experiment",
            "t [s]",
            "angle [degrees]",
            [
                Series("reference", t_s, asked_deg[:, joint], Colour.ASKED, dashed=True),
                Series("measured", t_s, seen_deg[:, joint], Colour.MEASURED),
            ],
            marks=on,
            group=group,
            height_px=200,
        ).html()
        for joint in range(3)
    ]
    percent = _worst(100.0 * (ran.measured_rad - ran.reference_rad) / found.asked.peak_to_peak_rad)
    late = t_s >= SHOWN_FROM_S
    limit = found.experiment.paper_percent
    end_s = ran.t_s[-1]
    # Out above and back below, as one: two would be two of the same name in the legend.
    bounds = Series(
        f"the paper's {limit} %",
        [SHOWN_FROM_S, end_s, end_s, end_s, SHOWN_FROM_S],
        [limit, limit, np.nan, -limit, -limit],
        Colour.QUIET,
        dashed=True,
    )
    parts.append(
        LineChart(
            f"Tracking error, {name} experiment, {found.control.name}",
            "t [s]",
            "error [% of peak to peak]",
            [
                *(
                    Series(f"joint {joint + 1}", t_s[late], percent[late, joint], colour)
                    for joint, colour in enumerate(COLOURS)
                ),
                bounds,
            ],
            group=group,
            note="Spikes are reversals of a joint: Coulomb friction changes its sign. The comb in "
            "between is the encoder's step. Each point is the largest error of 2 ms.",
        ).html()
    )
    parts.append(
        LineChart(
            f"Disturbance estimate, {name} experiment, {found.control.name}",
            "t [s]",
            "current [mA]",
            [
                Series(
                    f"joint {joint + 1}",
                    ran.t_s[::SLOWLY],
                    1e3 * _mean(ran.disturbance_a[:, joint]),
                    colour,
                )
                for joint, colour in enumerate(COLOURS)
            ],
            marks=on,
            group=group,
            note="Means over 20 ms. Level: gravity. Jumps: Coulomb friction at reversals.",
        ).html()
    )
    return parts


def _mean(values: FloatArray) -> FloatArray:
    """Means of SLOWLY values each; (n,) to as many as `[::SLOWLY]` gives."""
    padded = np.pad(values, (0, -len(values) % SLOWLY), mode="edge")
    means: FloatArray = padded.reshape(-1, SLOWLY).mean(axis=1)
    return means


def _worst(values: FloatArray) -> FloatArray:
    """For EVERY rows each, the value furthest from 0; (n, 3) to as many as `[::EVERY]`."""
    padded = np.pad(values, ((0, -len(values) % EVERY), (0, 0)), mode="edge")
    blocks = padded.reshape(-1, EVERY, values.shape[1])
    at = np.abs(blocks).argmax(axis=1)[:, None, :]
    worst: FloatArray = np.take_along_axis(blocks, at, axis=1)[:, 0, :]
    return worst
