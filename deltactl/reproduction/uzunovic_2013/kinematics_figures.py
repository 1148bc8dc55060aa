"""Figures 3 to 5 of Uzunovic 2013 for a report."""

from __future__ import annotations

import numpy as np

from deltactl.charts.figures import LineChart
from deltactl.charts.spec import Colour, Series
from deltactl.models.robot import ARMS, AXES
from deltactl.reproduction.uzunovic_2013.kinematics_stage import Validation

SHOWN_S = (600.0, 800.0)
""" "Only part of the measured results is shown in these figures for the better view"."""
_GROUP = "section 3"


def figures(found: Validation) -> list[str]:
    """HTML of all figures."""
    charts = [*_figure_3(found), *_figure_4(found), *_figure_5(found)]
    return [chart.html() for chart in charts]


def _figure_3(found: Validation) -> list[LineChart]:
    t_s, position_mm = found.measured.t_s, 1e3 * found.measured.position_m
    above = Series("stage", position_mm[:, 0], position_mm[:, 1], Colour.MEASURED)
    return [
        LineChart("Figure 3: trajectory from above", "x [mm]", "y [mm]", [above], True),
        LineChart(
            "Figure 3: height of the trajectory",
            "time [s]",
            "z [mm]",
            [Series("stage", t_s, position_mm[:, 2], Colour.MEASURED)],
        ),
    ]


def _figure_4(found: Validation) -> list[LineChart]:
    rows = _shown(found)
    t_s = found.measured.t_s[rows]
    measured_mm = 1e3 * found.measured.position_m[rows]
    calculated_mm = 1e3 * found.calculated_m[rows]
    charts = []
    for column, axis in enumerate(AXES):
        series = [
            Series("measured", t_s, measured_mm[:, column], Colour.MEASURED),
            Series("calculated", t_s, calculated_mm[:, column], Colour.COMMANDED),
        ]
        if axis != "z":
            error = calculated_mm[:, column] - measured_mm[:, column]
            series.append(Series("error", t_s, error, Colour.BAD))
        title = f"Figure 4: direct kinematics, {axis}"
        charts.append(LineChart(title, "time [s]", f"{axis} [mm]", series, group=_GROUP))
    return charts


def _figure_5(found: Validation) -> list[LineChart]:
    rows = _shown(found)
    t_s = found.measured.t_s[rows]
    curves = (
        ("measured", found.measured.angles_rad, Colour.MEASURED),
        ("mathematical model", found.angles_rad["mathematical model"], Colour.COMMANDED),
        ("network", found.angles_rad["network"], Colour.GOOD),
    )
    return [
        LineChart(
            f"Figure 5: joint {joint + 1}",
            "time [s]",
            f"alpha_{joint + 1}s [deg]",
            [
                Series(name, t_s, np.rad2deg(angles_rad[rows, joint]), colour)
                for name, angles_rad, colour in curves
            ],
            group=_GROUP,
        )
        for joint in range(ARMS)
    ]


def _shown(found: Validation) -> np.ndarray[tuple[int], np.dtype[np.bool_]]:
    t_s = found.measured.t_s
    shown: np.ndarray[tuple[int], np.dtype[np.bool_]]
    shown = (t_s >= SHOWN_S[0]) & (t_s <= SHOWN_S[1])
    return shown
