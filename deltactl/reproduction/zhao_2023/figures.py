"""Figures 4, 5 and 7 to 15 of the paper over again, and error against samples."""

from __future__ import annotations

import numpy as np

from deltactl.charts.figures import LineChart
from deltactl.charts.spec import Colour, Series, Style
from deltactl.models.robot import FloatArray
from deltactl.reproduction.zhao_2023.beyond import apart_by_samples, by_samples
from deltactl.reproduction.zhao_2023.study import GEOMETRY, LIMIT, TRUSTING, Study
from deltactl.reproduction.zhao_2023.tracking import TITLES, slow_m

MM = 1e3
LOOKS = {
    "zhao": ("Zhao's network", Colour.SECOND),
    "uzunovic": ("Uzunovic's network", Colour.COMMANDED),
    "ours": ("ours", Colour.THIRD),
    "calibrated": ("calibrated", Colour.FIRST),
    GEOMETRY: ("geometry", Colour.BAD),
    LIMIT: ("limit", Colour.QUIET),
    TRUSTING: ("ours, trusting the sensors", Colour.FIRST),
}


def counts_charts(study: Study) -> list[LineChart]:
    """Figure 4: the random counts."""
    counts = study.data.first(study.scale.main).counts
    number = np.arange(1, len(counts) + 1)
    return [
        LineChart(
            f"Figure 4: joint count of motor {motor + 1}",
            "sample",
            "steps",
            [Series(f"motor {motor + 1}", number, counts[:, motor], Colour.FIRST, Style.POINTS)],
            height_px=180,
        )
        for motor in range(3)
    ]


def position_charts(study: Study) -> list[LineChart]:
    """Figure 5: measured positions, from above and from the side."""
    seen_mm = MM * study.data.first(study.scale.main).position_m
    return [
        LineChart(
            f"Figure 5: measured positions, {view}",
            "x [mm]",
            f"{'xyz'[up]} [mm]",
            [Series("measured", seen_mm[:, 0], seen_mm[:, up], Colour.MEASURED, Style.POINTS)],
            equal_aspect=True,
        )
        for view, up in (("from above", 1), ("from the side", 2))
    ]


def path_charts(study: Study, figure: int, curve: str) -> list[LineChart]:
    """Figures 7 to 9: the curve as each model follows it, from above and from the side."""
    zhao = study.track(f"zhao-{study.scale.main}", curve)
    geometry = study.track(GEOMETRY, curve)
    ours = study.track(f"ours-{study.scale.main}", curve)
    charts = []
    for view, up in (("from above", 1), ("from the side", 2)):
        target_mm = MM * zhao.target_m
        series = [
            Series("target", target_mm[:, 0], target_mm[:, up], Colour.ASKED, dashed=True),
            Series(
                "network, by the sensors",
                MM * zhao.seen_m[:, 0],
                MM * zhao.seen_m[:, up],
                Colour.MEASURED,
                Style.POINTS,
            ),
        ]
        for track, name in ((geometry, GEOMETRY), (zhao, "zhao"), (ours, "ours")):
            words, colour = LOOKS[name]
            true_mm = MM * track.true_m
            series.append(Series(f"{words}, true", true_mm[:, 0], true_mm[:, up], colour))
        charts.append(
            LineChart(
                f"Figure {figure}: {TITLES[curve].lower()}, {view}",
                "x [mm]",
                f"{'xyz'[up]} [mm]",
                series,
                equal_aspect=True,
            )
        )
    return charts


def error_charts(study: Study, figure: int, curve: str, model: str) -> list[LineChart]:
    """Figures 10 to 15: errors along x, y, z over time."""
    track = study.track(model, curve)
    words = LOOKS[model.partition("-")[0]][0]
    smooth_m = slow_m(track.seen_error_m)
    charts = []
    for axis, name in enumerate("xyz"):
        seen_mm, at_s = MM * track.seen_error_m[:, axis], track.seen_s
        series = [
            Series("reading", at_s, seen_mm, Colour.MEASURED, Style.POINTS, hidden=False),
            Series("mean of 25 readings", at_s, MM * smooth_m[:, axis], Colour.COMMANDED),
            Series("true", track.t_s, MM * track.true_error_m[:, axis], Colour.TRUE),
        ]
        charts.append(
            LineChart(
                f"Figure {figure}: {TITLES[curve].lower()}, {words}, e_{name}",
                "time [s]",
                f"e_{name} [mm]",
                series,
                group=f"figure {figure}",
                height_px=170,
            )
        )
    return charts


def samples_charts(study: Study) -> list[LineChart]:
    """Error against number of samples, both on logarithmic axes."""
    return [
        _by_samples(study, "Error against the truth", by_samples(study)),
        _by_samples(study, "Distance from the limit's own run", apart_by_samples(study)),
    ]


def _by_samples(study: Study, title: str, found: dict[str, FloatArray]) -> LineChart:
    counts = np.log10(np.array(study.scale.samples, dtype=np.float64))
    series = []
    for model, values in found.items():
        words, colour = LOOKS[model]
        flat = model in (GEOMETRY, LIMIT)
        series.append(Series(words, counts, np.log10(MM * values), colour, dashed=flat))
    sizes = ", ".join(f"{count} = {np.log10(count):.2f}" for count in study.scale.samples)
    return LineChart(
        f"{title} by number of samples",
        "log10 of samples",
        "log10 of RMS distance [mm]",
        series,
        height_px=360,
        note=f"Mean of the three curves at T_PWM 0.006 s. Samples: {sizes}. 0 is 1 mm, 1 is 10 mm.",
    )
