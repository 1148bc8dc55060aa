"""Figures 7 to 10 of the paper, and what it does not show: errors, currents, estimates."""

from __future__ import annotations

import numpy as np

from deltactl.charts.figures import LineChart
from deltactl.charts.page import columns
from deltactl.charts.spec import Colour, Mark, Series
from deltactl.models.robot import FloatArray
from deltactl.reproduction.uzunovic_2013.control_references import CONTROL_ON_S, References
from deltactl.reproduction.uzunovic_2013.control_tables import Result

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
    return columns(
        [
            LineChart(
                f"Figure {number}: reference of the {asked.experiment.name} experiment, from above",
                "x [mm]", "y [mm]", [Series("reference", x, y, Colour.ASKED)], equal_aspect=True,
            ).html(),
            LineChart(
                f"Figure {number}: the same from the side",
                "x [mm]", "z [mm]", [Series("reference", x, z, Colour.ASKED)], equal_aspect=True,
            ).html(),
        ]
    )  # fmt: skip


def response_figures(found: Result) -> list[str]:
    """Figure 8 or 10: each joint's angle, and below it error and estimated disturbance."""
    ran, name = found.tracking.run, found.experiment.name
    number, group = found.experiment.response_figure, f"response-{found.experiment.name}"
    on = [Mark(CONTROL_ON_S, "control on")]
    t_s = ran.t_s[::EVERY]
    parts = [
        LineChart(
            f"Figure {number}: joint {joint + 1}, {name} experiment",
            "t [s]", "angle [degrees]",
            [
                Series("reference", t_s, np.degrees(ran.reference_rad[::EVERY, joint]),
                       Colour.ASKED, dashed=True),
                Series("measured", t_s, np.degrees(ran.measured_rad[::EVERY, joint]),
                       Colour.MEASURED),
            ],
            marks=on, group=group, height_px=200,
        ).html()
        for joint in range(3)
    ]  # fmt: skip
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
            "t [s]", "error [% of peak to peak]",
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
    )  # fmt: skip
    parts.append(
        LineChart(
            f"Disturbance estimate, {name} experiment, {found.control.name}",
            "t [s]", "current [mA]",
            [
                Series(
                    f"joint {joint + 1}", ran.t_s[::SLOWLY],
                    1e3 * _mean(ran.disturbance_a[:, joint]), colour,
                )
                for joint, colour in enumerate(COLOURS)
            ],
            marks=on, group=group,
            note="Means over 20 ms. Level: gravity. Jumps: Coulomb friction at reversals.",
        ).html()
    )  # fmt: skip
    return parts


def _mean(values: FloatArray) -> FloatArray:
    """Means of SLOWLY values each; (n,) to as many as `[::SLOWLY]` gives."""
    padded = np.pad(values, (0, -len(values) % SLOWLY), mode="edge")
    means: FloatArray = padded.reshape(-1, SLOWLY).mean(axis=1)
    return means


def _worst(values: FloatArray) -> FloatArray:
    """Of EVERY rows each the value that is furthest from 0; (n, 3) to as many as `[::EVERY]`."""
    padded = np.pad(values, ((0, -len(values) % EVERY), (0, 0)), mode="edge")
    blocks = padded.reshape(-1, EVERY, values.shape[1])
    at = np.abs(blocks).argmax(axis=1)[:, None, :]
    worst: FloatArray = np.take_along_axis(blocks, at, axis=1)[:, 0, :]
    return worst
