"""The mismatch as charts: over time, over place, and by the state of the machine."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import replace

import numpy as np

from deltactl.charts.cell_maps import cell_map
from deltactl.charts.cells import grid_of
from deltactl.charts.figures import LineChart
from deltactl.charts.means import Curve, Mismatch, binned, explained_by, far_out, rms, smoothed
from deltactl.charts.page import HINT, columns, heading, paragraph, unfolds
from deltactl.charts.scenes import hue
from deltactl.charts.spec import Colour, Series, Span, Style, keep
from deltactl.diagnosis.answer.picture import FloatArray, bare
from deltactl.diagnosis.answer.records import Channel, Diagnosis, Finding, Picture
from deltactl.diagnosis.answer.regimes import AFTER_REVERSAL_S, FEWEST_ROWS, Regime, regimes
from deltactl.diagnosis.answer.what_is_left import doubtful_floor
from deltactl.diagnosis.report.finding import stretches
from deltactl.diagnosis.report.fit import Pair, pair_bars
from deltactl.diagnosis.report.names import channel as channel_name
from deltactl.diagnosis.report.names import count, followed, part
from deltactl.diagnosis.report.sizes import covariate_unit, in_its_units, scale_of
from deltactl.diagnosis.report.templates import say
from deltactl.models.robot import RangeSensor, RobotModel, ServoAxis, StepperAxis

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
QUIET_SIGMAS = 2.0
"""The darkest colour means at least so many standard deviations of a reading."""
SHOWN_FIRST = 4
"""Charts by place, and by other quantities, that are open; the rest is behind a click."""
MOST_DRIVER_CHARTS = 12
SHOWN_REGIMES = 9
FEWEST_MEANS = 4
"""A curve through fewer (of a direction: there and back) is a straight line that tells nothing; the
regimes have those figures."""
PLACES = frozenset(
    {
        *(f"theta_{arm}" for arm in "123"),
        *(f"{stem}_{axis}" for stem in ("range", "pos", "position") for axis in "xyz"),
        *("range_x, range_y", "position", "angle", "distance", "range", "command"),
    }
)
"""Covariates that say where the machine is."""


def mismatch_sections(diagnosis: Diagnosis, robot: RobotModel) -> list[str]:
    """Sections by time, place and regime; one sentence where there is nothing to draw."""
    picture = diagnosis.picture
    channels = drawn(diagnosis)
    if picture is None or not channels:
        return [heading(say("chart.mismatch")), paragraph(say("chart.nothing"), "note")]
    return [
        *in_order(picture, channels, diagnosis.findings, robot),
        *_by_place(diagnosis, picture, channels, robot),
        *_by_regime(diagnosis, picture, channels),
    ]


@in_its_units
def drawn(diagnosis: Diagnosis) -> list[Mismatch]:
    """The channels of an answer that are drawn, in its units; none without a picture."""
    picture = diagnosis.picture
    return [] if picture is None else mismatches(picture, not diagnosis.findings)


def mismatches(picture: Picture, found_nothing: bool = False) -> list[Mismatch]:
    """All channels with at least one valid reading; after is before where nothing was found."""
    found = [_mismatch(channel) for channel in picture.channels]
    if found_nothing:
        found = [replace(one, after=one.before, all_after=one.all_before) for one in found]
    return [one for one in found if np.isfinite(one.before).any()]


def _mismatch(channel: Channel) -> Mismatch:
    """What was measured minus what was predicted, in people's units."""
    scale = scale_of(channel.unit)
    before = (channel.observed - channel.before) * scale.factor
    after = (channel.observed - channel.after) * scale.factor
    far = far_out(before) & far_out(after)
    share = np.isfinite(before) * 1.0 if channel.counted is None else channel.counted
    counted = share > 0.0
    return Mismatch(
        name=channel_name(channel.name),
        unit=scale.unit,
        source=channel.name,
        source_unit=channel.unit,
        before=np.where(far | ~counted | ~np.isfinite(before), np.nan, before),
        after=np.where(far | ~counted | ~np.isfinite(after), np.nan, after),
        noise=channel.noise * scale.factor,
        readings=np.where(far | ~np.isfinite(before), np.nan, before),
        far_out=int(far.sum()),
        all_before=np.where(counted, before, np.nan),
        all_after=np.where(counted, after, np.nan),
        share=share,
    )


def in_order(
    picture: Picture, channels: Sequence[Mismatch], findings: Sequence[Finding], robot: RobotModel
) -> list[str]:
    """The section by time; of a sensor's table that is sorted by distance, by distance."""
    names, about = picture.covariates.keys(), paragraph(say("chart.about"))
    if isinstance(robot, RangeSensor) and "distance" in names and "time" not in names:
        chart = _distance_chart(picture, channels[0])
        return [heading(say("chart.over_distance")), about, chart.html()]
    most = min(MOST_PER_CHART, POINTS // (2 * len(channels)))
    charts = (
        _time_chart(picture, one, _spans(picture, findings, one.source), most) for one in channels
    )
    head = [heading(say("chart.over_time")), about, paragraph(HINT, "note howto")]
    return [*head, *(chart.html() for chart in charts)]


def _distance_chart(picture: Picture, one: Mismatch) -> LineChart:
    """Every reading, before and after, from near to far."""
    order = np.argsort(picture.covariates["distance"], kind="stable")
    scale = scale_of("m")
    at = picture.covariates["distance"][order] * scale.factor
    before, after = say("chart.before"), say("chart.after")
    series = [Series(before, at, one.all_before[order], Colour.SECOND, Style.POINTS)]
    if not one.unchanged:
        series.append(Series(after, at, one.all_after[order], Colour.FIRST, Style.POINTS))
    x_label = say("chart.distance", unit=scale.unit)
    name, y_label = one.name.capitalize(), say("chart.measured", unit=one.unit)
    return LineChart(name, x_label, y_label, series, height_px=230)


def _time_chart(picture: Picture, one: Mismatch, spans: Sequence[Span], most: int) -> LineChart:
    rows = np.flatnonzero(np.isfinite(one.readings))
    rows = rows[keep(picture.t_s[rows], one.readings[rows], most)]
    curve = smoothed(picture.t_s, one)
    everywhere = np.ones(len(curve.x), dtype=np.bool_)
    faint = max(rms(curve.before, everywhere), rms(curve.after, everywhere)) < FAINT * one.noise
    began_s, time = _clock(picture)
    x, at = curve.x - began_s, picture.t_s[rows] - began_s
    readings, quiet = one.readings[rows], Colour.QUIET
    when = None if one.unchanged else "before"
    names = [_named("chart.readings", when), _named("chart.smoothed", when)]
    series = [
        Series(names[0], at, readings, quiet, Style.POINTS, hidden=faint),
        Series(names[1], x, curve.before, Colour.SECOND),
    ]
    if not one.unchanged:
        series.append(Series(_named("chart.smoothed", "after"), x, curve.after, Colour.FIRST))
    return LineChart(
        one.name.capitalize(),
        time,
        say("chart.measured", unit=one.unit),
        series,
        spans=[replace(span, start=span.start - began_s, end=span.end - began_s) for span in spans],
        group=TIME_GROUP,
        note=say("chart.far_out", readings=count(one.far_out, "reading")) if one.far_out else "",
        height_px=230,
    )


def _named(what: str, when: str | None) -> str:
    name = say(what)
    return name if when is None else say("chart.when", what=name, when=say(f"chart.{when}"))


def _clock(picture: Picture) -> tuple[float, str]:
    """What is taken off all times, and how the axis is called: the time of day has many digits."""
    known = picture.t_s[np.isfinite(picture.t_s)]
    first = math.floor(known.min()) if len(known) else 0
    late = not first < LATE_S
    return float(first) if late else 0.0, say("chart.late" if late else "chart.time", first=first)


def _spans(picture: Picture, findings: Sequence[Finding], source: str) -> list[Span]:
    """When findings show in a channel, where that is not all the time."""
    start_s, end_s = float(picture.t_s[0]), float(picture.t_s[-1])
    spans = []
    for row, finding in enumerate(findings, 1):
        if finding.where.axes and source not in finding.where.axes:
            continue
        name, shift_s = say("chart.finding", number=row), picture.shift_of(finding.where)
        for begin, end in stretches(finding.where, start_s, end_s)[:20]:
            colour = FINDING_COLOURS[hue(row) - 1]
            spans.append(Span(begin + shift_s, end + shift_s, name, colour))
    return spans


def _by_place(
    diagnosis: Diagnosis, picture: Picture, channels: Sequence[Mismatch], robot: RobotModel
) -> list[str]:
    usable = {
        name: values
        for name, values in picture.covariates.items()
        if bare(name) not in ("time", "t", "t_s") and len(values) == len(picture.t_s)
    }
    place = {name: values for name, values in usable.items() if bare(name) in PLACES}
    other = {name: values for name, values in usable.items() if name not in place}
    # Only what may be taken for noise tells what noise does to means.
    banded = not doubtful_floor(diagnosis.fit)
    section = _driver_section("by_place", ranked(place, channels, robot, banded), banded)
    metric = [one for one in channels if one.source_unit == "m"]
    if section and metric:
        section.insert(1, place_maps(place, metric))
    return [*section, *_driver_section("by_speed", ranked(other, channels, robot, banded), banded)]


def place_maps(covariates: Mapping[str, FloatArray], channels: Sequence[Mismatch]) -> str:
    """From above and from the side, as HTML; empty where the positions are not known."""
    known = {bare(name): values for name, values in covariates.items()}
    place = {axis: known.get(f"range_{axis}", known.get(f"pos_{axis}")) for axis in "xyz"}
    unchanged = all(one.unchanged for one in channels)
    # What is much smaller than the noise shall not look loud.
    loudest = max([one.noise for one in channels if np.isfinite(one.noise)], default=0.0)
    least = QUIET_SIGMAS * loudest or 1e-3
    parts = []
    for key, across, up in (("above", "x", "y"), ("side", "x", "z")):
        first, second = place[across], place[up]
        if first is None or second is None:
            continue
        grid = grid_of(first * 1e3, second * 1e3, channels)
        if grid is None:
            continue
        maps: dict[str | None, FloatArray] = {"before": grid.before, "after": grid.after}
        for when, values in ({None: grid.before} if unchanged else maps).items():
            caption = _named(f"map.{key}", when)
            labels = f"{across} [mm]", f"{up} [mm]"
            parts.append(cell_map(caption, grid, values, least, labels))
    if not parts:
        return ""
    return paragraph(say("map.about")) + f'<div class="maps">{columns(parts)}</div>'


def _driver_section(title: str, charts: Sequence[LineChart], banded: bool) -> list[str]:
    """The clearest pairs of channel and covariate; the rest behind a click.

    banded: whether what is left may be taken for noise, so that it tells what noise does to means.
    """
    if not charts:
        return []
    shown = [chart.html() for chart in charts]
    about = say("chart.means", band=say("chart.band" if banded else "chart.no_band"))
    parts = [heading(say(f"chart.{title}")), paragraph(about), columns(shown[:SHOWN_FIRST])]
    if rest := shown[SHOWN_FIRST:MOST_DRIVER_CHARTS]:
        parts.append(unfolds(say("chart.more", number=len(rest)), [columns(rest)]))
    return parts


def ranked(
    covariates: Mapping[str, FloatArray],
    channels: Sequence[Mismatch],
    robot: RobotModel,
    banded: bool,
) -> list[LineChart]:
    """Charts of the mean mismatch over each covariate, the clearest dependence first."""
    found = []
    # The place of an axis that follows commands is the commanded one; with effort it is read.
    follows = isinstance(robot, ServoAxis | StepperAxis) and channels[0].source != "effort"
    for name, values in covariates.items():
        scale = scale_of(covariate_unit(name, robot))
        commanded = follows and bare(name) == "position"
        what = say("chart.commanded") if commanded else followed(name)
        for one in channels:
            curve = binned(values * scale.factor, one)
            if len(curve.x) >= FEWEST_MEANS:
                x_label = what.removeprefix("the ") + (f" [{scale.unit}]" if scale.unit else "")
                case = "chart.against" if len(channels) == 1 else "chart.channel_against"
                title = say(case, channel=one.name.capitalize(), covariate=what)
                chart = _driver_chart(title, x_label, one, curve, banded)
                found.append((explained_by(curve), chart))
    return [chart for _, chart in sorted(found, key=lambda pair: -pair[0])]


def _driver_chart(title: str, x_label: str, one: Mismatch, curve: Curve, banded: bool) -> LineChart:
    series = [Series(say("chart.before"), curve.x, curve.before, Colour.SECOND)]
    if one.unchanged:
        series = [replace(series[0], name=say("chart.one_mismatch"))]
    else:
        series.append(Series(say("chart.after"), curve.x, curve.after, Colour.FIRST))
    if banded:
        wide, middle, name = curve.band, np.zeros(len(curve.x)), say("chart.noise_alone")
        series.insert(0, Series(name, curve.x, middle, Colour.QUIET, low=-wide, high=wide))
    y_label = say("chart.measured", unit=one.unit)
    return LineChart(title, x_label, y_label, series, height_px=220)


def _by_regime(diagnosis: Diagnosis, picture: Picture, channels: Sequence[Mismatch]) -> list[str]:
    chosen = [one for one in channels if one.source_unit == diagnosis.fit.unit] or [channels[0]]
    pairs = by_regime(picture, chosen)
    if len(pairs) < 2:
        return []
    noise = diagnosis.fit.noise_floor_m * scale_of(chosen[0].source_unit).factor
    noise = math.nan if doubtful_floor(diagnosis.fit) else noise
    pairs[1:] = sorted(pairs[1:], key=lambda one: -one.before)
    unit = chosen[0].unit
    parts = [
        heading(say("chart.by_regime")),
        pair_bars("", pairs[:SHOWN_REGIMES], noise, unit, say("chart.about_regimes")),
    ]
    if rest := pairs[SHOWN_REGIMES:]:
        bars = pair_bars("", rest, noise, unit)
        parts.append(unfolds(say("chart.more", number=len(rest)), [bars]))
    return parts


def by_regime(picture: Picture, channels: Sequence[Mismatch]) -> list[Pair]:
    """RMS over the given channels (all in one unit) in every regime that occurs.

    Over all readings, also those that lie too far out to be drawn: as the figures of the fit.
    """
    covariates = {n: v for n, v in picture.covariates.items() if len(v) == len(picture.t_s)}
    before, after, share = (
        np.concatenate([getattr(one, values) for one in channels])
        for values in ("all_before", "all_after", "share")
    )
    nothing = all(one.unchanged for one in channels)
    found = []
    for regime in regimes(picture.t_s, covariates, picture.rests):
        rows = np.tile(regime.rows, len(channels))
        if np.count_nonzero(rows & np.isfinite(before)) >= FEWEST_ROWS:
            left = math.nan if nothing else rms(after, rows, share)
            found.append(Pair(_regime_name(regime), rms(before, rows, share), left))
    return found


def _regime_name(regime: Regime) -> str:
    which = regime.which
    who = part(f"motor{which}" if which else "axis")
    if which and which in "xyz":
        who = say("regime.platform", which=which)
    return say(f"regime.{regime.case}", who=who, seconds=f"{AFTER_REVERSAL_S:.0f}")
