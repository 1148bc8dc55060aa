"""The mismatch as charts: by time, by place, and by regime."""

from __future__ import annotations

import re
from collections.abc import Sequence

import numpy as np

from charts.figures import LineChart
from charts.page import HINT, columns, heading, paragraph
from charts.spec import Colour, Series, Span, Style
from charts.thin import keep
from diagnosis.report import words
from diagnosis.report.bars import Pair, pair_bars
from diagnosis.report.drawing.scene import hue
from diagnosis.report.regimes import regimes
from diagnosis.report.residuals import Mismatch, binned, explained_by, mismatches, smoothed
from diagnosis.report.sizes import quantity, scale_of
from diagnosis.report.summary import stretches
from diagnosis.result import Diagnosis, Finding, FloatArray, Picture

POINTS = 60_000
"""Single readings shown over all charts together; keeps the file small."""
MOST_PER_CHART = 12_000
SHOWN_FIRST = 4
"""Charts by place, and by other quantities, that stand open; the rest is behind a click."""
HUES = (Colour.FIRST, Colour.SECOND, Colour.THIRD, Colour.COMMANDED, Colour.BAD)
FINDING_COLOURS = (Colour.BAD, Colour.SECOND, Colour.COMMANDED, Colour.FIRST, Colour.THIRD)
"""As report.css has them for findings 1 to 5."""
TIME_GROUP = "time"

_PLACE = re.compile(r"theta_[123]|(range|pos|position)_[xyz]|position|angle|distance|range|command")
_DRIVER_UNITS: tuple[tuple[str, str], ...] = (
    (r"theta_[123]", "rad"),
    (r"(range|pos|position)_[xyz]|distance", "m"),
    (r"(speed|velocity)_[123]", "rad/s"),
    (r"(torque|load)_[123]", "N m"),
    (r"current_[123]", "A"),
    (r"temp_c", "\u00b0C"),
)


def mismatch_sections(diagnosis: Diagnosis) -> list[str]:
    """Sections by time, place and regime; one sentence where there is nothing to draw."""
    picture = diagnosis.picture
    channels = mismatches(picture) if picture is not None else []
    if picture is None or not channels:
        return [heading("The mismatch"), paragraph("There are no readings to draw.", "note")]
    return [
        *_by_time(picture, channels, diagnosis.findings),
        *_by_place(picture, channels),
        *_by_regime(diagnosis, picture, channels),
    ]


def _by_time(
    picture: Picture, channels: Sequence[Mismatch], findings: Sequence[Finding]
) -> list[str]:
    parts = [
        heading("The mismatch over time"),
        paragraph("Measured minus predicted. A perfect model leaves a flat line at zero."),
        paragraph(HINT, "note"),
    ]
    each = min(MOST_PER_CHART, POINTS // (2 * len(channels)))
    charts = (
        _time_chart(picture, one, _spans(picture, findings, one.source), each) for one in channels
    )
    return parts + [chart.html() for chart in charts]


def _time_chart(
    picture: Picture, one: Mismatch, spans: Sequence[Span], most: int
) -> LineChart:  # fmt: skip
    rows = np.flatnonzero(np.isfinite(one.before))
    rows = rows[keep(picture.t_s[rows], one.before[rows], most)]
    curve = smoothed(picture.t_s, one)
    series = [
        Series("single readings, before", picture.t_s[rows], one.before[rows], Colour.QUIET,
               Style.POINTS),
        Series("before, smoothed", curve.x, curve.before, Colour.SECOND),
        Series("after, smoothed", curve.x, curve.after, Colour.FIRST),
    ]  # fmt: skip
    note = f"Single readings scatter by {quantity(one.noise, one.unit)} of noise."
    if one.far_out:
        note += f" {one.far_out} readings that lie far out are not drawn."
    return LineChart(
        f"{one.name.capitalize()}",
        "time [s]",
        f"measured \u2212 predicted [{one.unit}]",
        series,
        spans=spans,
        group=TIME_GROUP,
        note=note,
        height_px=230,
    )


def _spans(picture: Picture, findings: Sequence[Finding], source: str) -> list[Span]:
    """When findings show in a channel, where that is not all the time."""
    start_s, end_s = float(picture.t_s[0]), float(picture.t_s[-1])
    return [
        Span(begin, end, f"finding {number}", FINDING_COLOURS[hue(number) - 1])
        for number, finding in enumerate(findings, 1)
        if not finding.where.axes or source in finding.where.axes
        for begin, end in stretches(finding.where.times_s, start_s, end_s)[:20]
    ]


def _by_place(picture: Picture, channels: Sequence[Mismatch]) -> list[str]:
    usable = {
        name: values
        for name, values in picture.drivers.items()
        if words.bare(name) not in ("time", "t", "t_s") and len(values) == len(picture.t_s)
    }
    place = {n: v for n, v in usable.items() if _PLACE.fullmatch(words.bare(n))}
    other = {n: v for n, v in usable.items() if n not in place}
    parts = []
    for title, drivers in (("by place", place), ("by speed, load and the like", other)):
        charts = _ranked(drivers, channels)
        if not charts:
            continue
        parts += [
            heading(f"The mismatch {title}"),
            paragraph("Mean over all readings at the same place; the clearest dependence first.")
            if title == "by place"
            else paragraph("Mean over all readings with the same value."),
            columns(chart.html() for chart in charts[:SHOWN_FIRST]),
        ]
        if rest := charts[SHOWN_FIRST:]:
            inside = columns(chart.html() for chart in rest)
            parts.append(f"<details><summary>{len(rest)} more</summary>{inside}</details>")
    return parts


def _ranked(drivers: dict[str, FloatArray], channels: Sequence[Mismatch]) -> list[LineChart]:
    strength = {
        name: max(explained_by(values, one) for one in channels) for name, values in drivers.items()
    }
    order = sorted(drivers, key=lambda name: -strength[name])
    charts = (_driver_chart(name, drivers[name], channels) for name in order)
    return [chart for chart in charts if chart.series]


def _driver_chart(name: str, values: FloatArray, channels: Sequence[Mismatch]) -> LineChart:
    """One curve a channel before, and a dashed one after; channels of the commonest unit."""
    bare = words.bare(name)
    unit = _driver_unit(name)
    scale = scale_of(unit)
    main = channels[0].unit
    shown = [one for one in channels if one.unit == main]
    series = []
    for colour, one in zip(HUES, shown, strict=False):
        curve = binned(values * scale.factor, one)
        if not np.isfinite(curve.before).any():
            continue
        only = len(shown) == 1
        label = "" if only else f"{one.name}, "
        after = Colour.FIRST if only else colour
        before = Colour.SECOND if only else colour
        series.append(Series(f"{label}before", curve.x, curve.before, before))
        series.append(Series(f"{label}after", curve.x, curve.after, after, dashed=True))
    of = f" [{scale.unit}]" if scale.unit else ""
    return LineChart(
        f"Against {words.followed(bare)}",
        f"{words.followed(bare).removeprefix('the ')}{of}",
        f"measured \u2212 predicted [{main}]",
        series,
        height_px=220,
    )


def _driver_unit(name: str) -> str:
    """The unit in the name's brackets, or what the contract says."""
    if found := re.search(r"[\[(]([^\])]*)[\])]\s*$", name):
        return found[1]
    for pattern, unit in _DRIVER_UNITS:
        if re.fullmatch(pattern, name):
            return unit
    return ""


def _by_regime(
    diagnosis: Diagnosis, picture: Picture, channels: Sequence[Mismatch]
) -> list[str]:  # fmt: skip
    chosen = [one for one in channels if one.source_unit == diagnosis.fit.unit] or [channels[0]]
    drivers = {n: v for n, v in picture.drivers.items() if len(v) == len(picture.t_s)}
    found = regimes(picture.t_s, drivers, list(chosen))
    if len(found) < 2:
        return []
    noise = float(np.sqrt(np.mean([one.noise**2 for one in chosen])))
    pairs = [Pair(one.name, one.before, one.after) for one in found]
    note = "Root mean square of measured minus predicted while the robot did this."
    return [
        heading("The mismatch by what the robot was doing"),
        pair_bars("", pairs, noise, chosen[0].unit, note),
    ]
