"""The mismatch over time; of a table without an order of time, over distance."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from deltactl.charts.figures import LineChart
from deltactl.charts.page import HINT, heading, paragraph
from deltactl.charts.spec import Colour, Series, Span, Style, keep
from deltactl.diagnosis.answer.records import Finding, Picture
from deltactl.diagnosis.report.drawing.scene import hue
from deltactl.diagnosis.report.page.residuals import Mismatch, rms, smoothed
from deltactl.diagnosis.report.phrases import words
from deltactl.diagnosis.report.phrases.sizes import scale_of
from deltactl.diagnosis.report.sentences.finding_words import stretches
from deltactl.models.robot import RangeSensor, RobotModel

POINTS = 60_000
"""Single readings shown over all charts together; keeps the file small."""
MOST_PER_CHART = 12_000
FAINT = 0.5
"""A smoothed mismatch below this share of the noise would vanish among single readings."""
FINDING_COLOURS = (Colour.BAD, Colour.SECOND, Colour.COMMANDED, Colour.FIRST, Colour.THIRD)
"""As report.css has them for findings 1 to 5."""
TIME_GROUP = "time"
LATE_S = 1e6
"""Times that begin later are those of a clock, not of the recording."""
ABOUT = "Measured minus predicted. A perfect model leaves a flat line at zero."


def in_order(
    picture: Picture, channels: Sequence[Mismatch], findings: Sequence[Finding], robot: RobotModel
) -> list[str]:
    """The section by time; of a sensor's table that is sorted by distance, by distance."""
    names = picture.covariates.keys()
    if isinstance(robot, RangeSensor) and "distance" in names and "time" not in names:
        chart = _distance_chart(picture, channels[0])
        return [heading("The mismatch over distance"), paragraph(ABOUT), chart.html()]
    return _by_time(picture, channels, findings)


def _distance_chart(picture: Picture, one: Mismatch) -> LineChart:
    """Every reading, before and after, from near to far."""
    order = np.argsort(picture.covariates["distance"], kind="stable")
    scale = scale_of("m")
    at = picture.covariates["distance"][order] * scale.factor
    series = [Series("before", at, one.all_before[order], Colour.SECOND, Style.POINTS)]
    if not one.unchanged:
        series.append(Series("after", at, one.all_after[order], Colour.FIRST, Style.POINTS))
    return LineChart(
        one.name.capitalize(), f"distance [{scale.unit}]", f"measured - predicted [{one.unit}]",
        series, height_px=230,
    )  # fmt: skip


def _by_time(
    picture: Picture, channels: Sequence[Mismatch], findings: Sequence[Finding]
) -> list[str]:
    parts = [
        heading("The mismatch over time"),
        paragraph(ABOUT),
        paragraph(HINT, "note howto"),
    ]
    each = min(MOST_PER_CHART, POINTS // (2 * len(channels)))
    charts = (
        _time_chart(picture, one, _spans(picture, findings, one.source), each) for one in channels
    )
    return parts + [chart.html() for chart in charts]


def _time_chart(
    picture: Picture, one: Mismatch, spans: Sequence[Span], most: int
) -> LineChart:  # fmt: skip
    rows = np.flatnonzero(np.isfinite(one.readings))
    rows = rows[keep(picture.t_s[rows], one.readings[rows], most)]
    curve = smoothed(picture.t_s, one)
    everywhere = np.ones(len(curve.x), dtype=np.bool_)
    faint = max(rms(curve.before, everywhere), rms(curve.after, everywhere)) < FAINT * one.noise
    series = [
        Series("single readings, before", picture.t_s[rows], one.readings[rows], Colour.QUIET,
               Style.POINTS, hidden=faint),
        Series("before, smoothed", curve.x, curve.before, Colour.SECOND),
        Series("after, smoothed", curve.x, curve.after, Colour.FIRST),
    ]  # fmt: skip
    if one.unchanged:
        series = [replace(series[0], name="single readings"), replace(series[1], name="smoothed")]
    began_s, time = _clock(picture)
    series = [replace(drawn, x=np.asarray(drawn.x) - began_s) for drawn in series]
    note = f"{_lie_far_out(one.far_out)} not drawn." if one.far_out else ""
    return LineChart(
        f"{one.name.capitalize()}",
        time,
        f"measured - predicted [{one.unit}]",
        series,
        spans=[replace(one, start=one.start - began_s, end=one.end - began_s) for one in spans],
        group=TIME_GROUP,
        note=note,
        height_px=230,
    )


def _clock(picture: Picture) -> tuple[float, str]:
    """What is taken off all times, and how the axis is called: the time of day has many digits."""
    known = picture.t_s[np.isfinite(picture.t_s)]
    first = math.floor(known.min()) if len(known) else 0
    if first < LATE_S:
        return 0.0, "time [s]"
    return float(first), f"time - {first} [s]"


def _spans(picture: Picture, findings: Sequence[Finding], source: str) -> list[Span]:
    """When findings show in a channel, where that is not all the time."""
    start_s, end_s = float(picture.t_s[0]), float(picture.t_s[-1])
    return [
        Span(
            begin + picture.shift_of(finding.where), end + picture.shift_of(finding.where),
            f"finding {number}", FINDING_COLOURS[hue(number) - 1],
        )
        for number, finding in enumerate(findings, 1)
        if not finding.where.axes or source in finding.where.axes
        for begin, end in stretches(finding.where, start_s, end_s)[:20]
    ]  # fmt: skip


def _lie_far_out(number: int) -> str:
    verbs = ("lies", "is") if number == 1 else ("lie", "are")
    return f"{words.count(number, 'reading')} that {verbs[0]} far out {verbs[1]}"
