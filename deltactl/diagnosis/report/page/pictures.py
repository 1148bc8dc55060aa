"""The mismatch as charts: by time, by place, and by regime."""

from __future__ import annotations

import math
import re
from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from deltactl.charts.figures import LineChart
from deltactl.charts.page import columns, heading, paragraph
from deltactl.charts.spec import Colour, Series
from deltactl.diagnosis.answer.picture import FloatArray
from deltactl.diagnosis.answer.records import Diagnosis, Picture
from deltactl.diagnosis.report.page.bars import Pair, pair_bars
from deltactl.diagnosis.report.page.maps import place_maps
from deltactl.diagnosis.report.page.over_time import in_order
from deltactl.diagnosis.report.page.regimes import regimes
from deltactl.diagnosis.report.page.residuals import (
    Curve,
    Mismatch,
    binned,
    explained_by,
    mismatches,
)
from deltactl.diagnosis.report.phrases import words
from deltactl.diagnosis.report.phrases.axis_units import covariate_unit
from deltactl.diagnosis.report.phrases.left_words import doubtful_floor
from deltactl.diagnosis.report.phrases.sizes import scale_of
from deltactl.models.robot import RobotModel, ServoAxis, StepperAxis

SHOWN_FIRST = 4
"""Charts by place, and by other quantities, that stand open; the rest is behind a click."""
MOST_DRIVER_CHARTS = 12
SHOWN_REGIMES = 9
FEWEST_MEANS = 4
"""A curve through fewer (of a direction: there and back) is a straight line that tells nothing; the
regimes have those figures."""
MEANS = "Mean of the readings with the same value; the clearest dependence first."
BAND = (
    "Noise alone keeps a whole curve within the grey band in 19 of 20 charts: one of many may leave"
    " it a little by chance, a curve that leaves it far shows more than noise."
)
NO_BAND = (
    "What is left is more than noise, so that no band says what chance does to a mean: hills and"
    " valleys that are no larger than what is left may come from when the readings were made."
)
_PLACE = re.compile(
    r"theta_[123]|(range|pos|position)_[xyz]|range_x, range_y|position|angle|distance|range|command"
)


def mismatch_sections(diagnosis: Diagnosis, robot: RobotModel) -> list[str]:
    """Sections by time, place and regime; one sentence where there is nothing to draw."""
    picture = diagnosis.picture
    channels = mismatches(picture, not diagnosis.findings) if picture is not None else []
    if picture is None or not channels:
        return [heading("The mismatch"), paragraph("There are no readings to draw.", "note")]
    return [
        *in_order(picture, channels, diagnosis.findings, robot),
        *_by_place(diagnosis, picture, channels, robot),
        *_by_regime(diagnosis, picture, channels),
    ]


def _by_place(
    diagnosis: Diagnosis, picture: Picture, channels: Sequence[Mismatch], robot: RobotModel
) -> list[str]:
    usable = {
        name: values
        for name, values in picture.covariates.items()
        if words.bare(name) not in ("time", "t", "t_s") and len(values) == len(picture.t_s)
    }
    place = {n: v for n, v in usable.items() if _PLACE.fullmatch(words.bare(n))}
    other = {n: v for n, v in usable.items() if n not in place}
    banded = not doubtful_floor(diagnosis.fit)
    section = _driver_section("The mismatch by place", place, channels, robot, banded)
    metric = [one for one in channels if one.source_unit == "m"]
    if section and metric:
        section.insert(1, place_maps(place, metric))
    return [
        *section,
        *_driver_section("The mismatch by speed and load", other, channels, robot, banded),
    ]


def _driver_section(
    title: str,
    covariates: dict[str, FloatArray],
    channels: Sequence[Mismatch],
    robot: RobotModel,
    banded: bool,
) -> list[str]:
    """The clearest pairs of channel and covariate; the rest behind a click.

    banded: whether what is left may be taken for noise, so that it tells what noise does to means.
    """
    charts = [chart.html() for chart in _ranked(covariates, channels, robot, banded)]
    if not charts:
        return []
    about = f"{MEANS} {BAND if banded else NO_BAND}"
    parts = [heading(title), paragraph(about), columns(charts[:SHOWN_FIRST])]
    if rest := charts[SHOWN_FIRST:MOST_DRIVER_CHARTS]:
        parts.append(f"<details><summary>{len(rest)} more</summary>{columns(rest)}</details>")
    return parts


def _ranked(
    covariates: dict[str, FloatArray], channels: Sequence[Mismatch], robot: RobotModel, banded: bool
) -> list[LineChart]:
    found = []
    for name, values in covariates.items():
        scale = scale_of(covariate_unit(name, robot))
        for one in channels:
            curve = binned(values * scale.factor, one)
            if len(curve.x) >= FEWEST_MEANS:
                found.append((explained_by(curve), name, scale.unit, one, curve))
    found.sort(key=lambda item: -item[0])
    lone = len(channels) == 1
    # The place of an axis that follows commands is the commanded one; with effort it is read.
    follows = isinstance(robot, ServoAxis | StepperAxis) and channels[0].source != "effort"
    return [
        _driver_chart(
            name, unit, one, curve, lone, banded, follows and words.bare(name) == "position"
        )
        for _, name, unit, one, curve in found
    ]


def _driver_chart(
    name: str,
    unit: str,
    one: Mismatch,
    curve: Curve,
    lone: bool,
    banded: bool,
    commanded: bool,
) -> LineChart:
    covariate = "the commanded position" if commanded else words.followed(name)
    series = [
        Series("before", curve.x, curve.before, Colour.SECOND),
        Series("after", curve.x, curve.after, Colour.FIRST),
    ]
    if one.unchanged:
        series = [replace(series[0], name="mismatch")]
    if banded:
        series.insert(0, _noise_alone(curve))
    of = f" [{unit}]" if unit else ""
    return LineChart(
        f"Against {covariate}" if lone else f"{one.name.capitalize()} against {covariate}",
        f"{covariate.removeprefix('the ')}{of}",
        f"measured - predicted [{one.unit}]",
        series,
        height_px=220,
    )


def _noise_alone(curve: Curve) -> Series:
    wide, middle = curve.band, np.zeros(len(curve.x))
    return Series("noise alone", curve.x, middle, Colour.QUIET, low=-wide, high=wide)


def _counted(channels: Sequence[Mismatch], picture: Picture) -> str:
    """Which readings the figures are of: the same as those at the top of the report."""
    left_out = sum(
        int((np.isfinite(one.observed) & ~one.counted).sum())
        for one in picture.channels
        if one.counted is not None
    )
    if left_out:
        said = "is left out here" if left_out == 1 else "are left out here"
        return f"; {words.count(left_out, 'outlier')} {said}, as in the figures at the top."
    return "; readings that lie far out count too." if any(o.far_out for o in channels) else "."


def _by_regime(
    diagnosis: Diagnosis, picture: Picture, channels: Sequence[Mismatch]
) -> list[str]:  # fmt: skip
    chosen = [one for one in channels if one.source_unit == diagnosis.fit.unit] or [channels[0]]
    covariates = {n: v for n, v in picture.covariates.items() if len(v) == len(picture.t_s)}
    found = regimes(picture.t_s, covariates, list(chosen), picture.rests)
    if len(found) < 2:
        return []
    noise = diagnosis.fit.noise_floor_m * scale_of(chosen[0].source_unit).factor
    noise = math.nan if doubtful_floor(diagnosis.fit) else noise
    found[1:] = sorted(found[1:], key=lambda one: -one.before)
    nothing = all(one.unchanged for one in chosen)
    pairs = [Pair(one.name, one.before, math.nan if nothing else one.after) for one in found]
    note = "Root mean square of measured minus predicted while the robot did this"
    note += _counted(chosen, picture)
    parts = [
        heading("The mismatch by what the robot was doing"),
        pair_bars("", pairs[:SHOWN_REGIMES], noise, chosen[0].unit, note),
    ]
    if rest := pairs[SHOWN_REGIMES:]:
        bars = pair_bars("", rest, noise, chosen[0].unit)
        parts.append(f"<details><summary>{len(rest)} more</summary>{bars}</details>")
    return parts
