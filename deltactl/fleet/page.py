"""One page about a fleet: where to look first, what grows, what comes in groups, all robots."""

from __future__ import annotations

import math
from collections import defaultdict
from collections.abc import Iterator, Sequence
from dataclasses import replace
from datetime import UTC, datetime, timedelta
from pathlib import Path

import numpy as np
import pyarrow as pa
import pyarrow.parquet as pq

from deltactl.charts.figures import LineChart
from deltactl.charts.page import heading, page, paragraph, table, unfolds
from deltactl.charts.spec import Colour, Series, Style
from deltactl.diagnosis.report.sizes import Scale, scale_of
from deltactl.fleet.task import Row
from deltactl.fleet.together import DAY_S, Course, Group, Trend, courses, groups, trends
from deltactl.foundation.plain_file import whole_file
from deltactl.foundation.printable import count

CHARTS, CHARTS_SHOWN = 12, 1
ROWS_SHOWN = 5
"""Rows shown of each table; the others open on a click: on a phone the page stays short."""
NAMES_SHOWN = 8
BAD_SHOWN = 50
NO_COLUMN = 99
LIKELY = 0.5


def fleet_html(rows: Sequence[Row], limits: dict[str, float]) -> str:
    """The page as one HTML document."""
    found = courses(rows)
    moving = trends(found, limits)
    batches = [_group_in_use(group) for group in groups(found, moving)]
    found, moving = list(map(_in_use, found)), list(map(_trend_in_use, moving))
    bad = [row for row in rows if "error" in row]
    good = [row for row in rows if "error" not in row]
    robots = {row["robot"] for row in good}
    known = count(len(robots), "robot")
    unread = f"{len(bad)} of them could not be read" if bad else "all read"
    lead = f"{count(len(rows), 'recording').capitalize()} of {known}, {unread}."
    parts = [
        heading("Where to look first"),
        *_first(moving, batches, found, robots),
        heading("What grows or drifts"),
        *_trends(moving),
        heading("What comes in groups"),
        *_groups(batches),
        *_sisters(good),
        heading("All robots"),
        *_robots(good, found),
        *_bad(bad),
    ]
    return page("Fleet", parts, lead=lead)


def _scale(unit: str, parameter: str, size: float) -> Scale:
    """How a size of the contract is shown: in degrees, mm or %, as in the answers."""
    return scale_of(unit, parameter.partition("[")[0], size)


def _in_use(course: Course) -> Course:
    """The same in the unit in which its size is shown."""
    shown = _scale(course.unit, course.key[-1], float(np.median(course.value)))
    value, low, high = (
        (sizes - shown.zero) * shown.factor for sizes in (course.value, course.low, course.high)
    )
    return replace(course, unit=shown.unit, value=value, low=low, high=high)


def _trend_in_use(trend: Trend) -> Trend:
    course = trend.course
    shown = _scale(course.unit, course.key[-1], float(np.median(course.value)))
    return replace(
        trend,
        course=_in_use(course),
        per_day=trend.per_day * shown.factor,
        low_per_day=trend.low_per_day * shown.factor,
        high_per_day=trend.high_per_day * shown.factor,
        now=shown(trend.now),
        limit=None if trend.limit is None else shown(trend.limit),
    )


def _group_in_use(group: Group) -> Group:
    shown = _scale(group.unit, group.parameter, group.median)
    members = tuple((robot, part, shown(size)) for robot, part, size in group.members)
    return replace(group, unit=shown.unit, members=members)


def until(trend: Trend) -> str:
    """When the limit will be reached, in words."""
    days = trend.days_to_limit()
    if trend.limit is None:
        return "no limit given"
    if days is None:
        return "moves away from its limit"
    if days[0] == 0.0:
        return f"past its limit of {trend.limit:.4g}{_unit(trend.course.unit)}"
    last = datetime.fromtimestamp(float(trend.course.time_s[-1]), UTC)
    best, soonest, latest = (_date(last, count) for count in days)
    return f"{trend.limit:.4g}{_unit(trend.course.unit)} about {best} ({soonest} to {latest})"


def _unit(unit: str) -> str:
    """Behind a number; a plain number has none."""
    return "" if unit in ("1", "") else f" {unit}"


def _date(last: datetime, days: float) -> str:
    if not math.isfinite(days) or days > 36_500.0:
        return "never"
    return f"{last + timedelta(days=days):%Y-%m-%d}"


def _first(
    moving: list[Trend], batches: list[Group], found: list[Course], robots: set[str]
) -> list[str]:
    rows = [
        (trend.course.key[0], f"{_effect(trend.course)} changes by {_rate(trend)}", until(trend))
        for trend in sorted(moving, key=_soonest)
    ]
    rows += [
        (_few(group.robots), _alike(group, len(robots)), "one cause: a batch, or the robot file")
        for group in batches
    ]
    named = {trend.course.key for trend in moving}
    named |= {
        (robot, group.effect, component, group.parameter)
        for group in batches
        for robot, component, _ in group.members
    }
    alone = [course for course in found if course.lasts and course.key not in named]
    rows += [
        (
            course.key[0],
            f"{_effect(course)}, {_sized(float(np.median(course.value)), course)}",
            f"steady, in {course.found_in:.0%} of its recordings",
        )
        for course in alone
    ]
    if not rows:
        return [paragraph("Nowhere: no finding lasts, none grows, none is shared.")]
    return _rows(("robot", "what", "when, or why"), rows)


def _alike(group: Group, robots: int) -> str:
    return f"{group.effect.replace('_', ' ')} alike on {len(group.robots)} of {robots} robots"


def _soonest(trend: Trend) -> float:
    """Days until its limit may be reached; what has none comes last."""
    days = trend.days_to_limit()
    return math.inf if days is None else days[1]


def _rows(head: Sequence[str], rows: Sequence[Sequence[str]]) -> list[str]:
    """A table whose first rows are seen at once."""
    few, more = rows[:ROWS_SHOWN], rows[ROWS_SHOWN:]
    if len(more) <= 1:
        few, more = rows, []
    shown = [table(head, few, numbers_from=NO_COLUMN)]
    if more:
        shown.append(unfolds(f"{len(more)} more", [table(head, more, numbers_from=NO_COLUMN)]))
    return shown


def _trends(moving: list[Trend]) -> list[str]:
    if not moving:
        return [paragraph("No trend beyond the scatter.")]
    rows = [
        (trend.course.key[0], _effect(trend.course), _rate(trend), _sized(trend.now, trend.course))
        for trend in sorted(moving, key=_soonest)
    ]
    about = (
        "Straight lines through what was found; recordings in which it was too small to be found "
        "do not count. With a probability of 0.99 none of these is chance."
    )
    head = ("robot", "what", "change a week (95 %)", "now")
    charts = [_chart(trend).html() for trend in sorted(moving, key=_soonest)[:CHARTS]]
    more = charts[CHARTS_SHOWN:]
    return [
        *_rows(head, rows),
        paragraph(about, "note"),
        *charts[:CHARTS_SHOWN],
        *([unfolds(f"{len(more)} more charts", more)] if more else []),
    ]


def _chart(trend: Trend) -> LineChart:
    course = trend.course
    days = (course.time_s - course.time_s[-1]) / DAY_S
    rates = (trend.per_day, trend.low_per_day, trend.high_per_day)
    line, low, high = (trend.now + rate * days for rate in rates)
    points = (Colour.MEASURED, Style.POINTS)
    series = [
        Series("found", days, course.value, *points, low=course.low, high=course.high),
        Series("trend", days, line, Colour.BAD, low=low, high=high),
    ]
    if trend.limit is not None:
        ends = np.array([days[0], 0.0])
        series.append(Series("limit", ends, np.full(2, trend.limit), Colour.QUIET, dashed=True))
    size = f"size [{course.unit}]" if _unit(course.unit) else "size"
    return LineChart(course.name, "time before the last recording [days]", size, series)


def _groups(batches: list[Group]) -> list[str]:
    if not batches:
        return [paragraph("No finding is shared by three robots or more.")]
    rows = [
        (
            f"{group.effect.replace('_', ' ')}, {group.parameter}",
            f"{group.median:.4g} ± {group.spread:.2g}{_unit(group.unit)}",
            _members(group),
        )
        for group in batches
    ]
    return _rows(("what", "size", "robots"), rows)


def _members(group: Group) -> str:
    """Its robots, by the component that has it."""
    by_component: dict[str, list[str]] = defaultdict(list)
    for robot, component, _ in sorted(group.members):
        by_component[component].append(robot)
    return "; ".join(f"{component} of {_few(its)}" for component, its in by_component.items())


def _few(names: Sequence[str]) -> str:
    """The first of them; the others are in the list of all robots."""
    more = len(names) - NAMES_SHOWN
    return ", ".join(names) if more <= 1 else f"{', '.join(names[:NAMES_SHOWN])} and {more} more"


def _sisters(good: list[Row]) -> list[str]:
    """Findings whose probability the other machines moved across a half, or to another cause."""
    moved = [
        (
            row["robot"],
            row["recording"].rsplit("/", 1)[-1],
            f"{size['effect'].replace('_', ' ')} of {size['component']}",
            f"{size['alone']:.0%} alone, {size['probability']:.0%} with the fleet:"
            f" {size['sisters']}",
            (size["rather"] or "-").replace("_", " "),
        )
        for row in good
        for size in row["findings"]
        if "alone" in size
        and (_other(size) or (size["alone"] < LIKELY) != (size["probability"] < LIKELY))
    ]
    moved = list(dict.fromkeys(moved))  # a finding has as many rows as sizes
    if not any("alone" in size for row in good for size in row["findings"]):
        return []
    about = (
        "What lasts on the other machines counts in every probability of the table (column alone: "
        "without them; --no-sisters leaves them out)."
    )
    head = ("robot", "recording", "what", "how probable", "rather")
    shown = _rows(head, moved[:BAD_SHOWN]) if moved else []
    said = f"They change what is likely in {len(moved)} findings."
    return [heading("What sister machines change"), paragraph(f"{about} {said}"), *shown]


def _other(size: Row) -> bool:
    """Whether the sisters name another cause than the finding itself."""
    return size["rather"] not in (None, f"{size['effect']} at {size['component']}")


def _robots(good: list[Row], found: list[Course]) -> list[str]:
    by_robot: dict[str, list[Row]] = defaultdict(list)
    for row in good:
        by_robot[row["robot"]].append(row)
    lasting: dict[str, list[str]] = defaultdict(list)
    for course in found:
        if course.lasts:
            lasting[course.key[0]].append(_effect(course))
    rows = []
    for robot, its in sorted(by_robot.items()):
        clean = sum(row["verdict"] == "nothing_missing" for row in its)
        last = datetime.fromtimestamp(its[-1]["time_s"], UTC)
        what = ", ".join(sorted(set(lasting[robot]))) or "nothing that lasts"
        rows.append((robot, what, f"{clean / len(its):.0%}", str(len(its)), f"{last:%Y-%m-%d}"))
    head = ("robot", "what lasts", "nothing missing", "recordings", "last")
    return _rows(head, rows)


def _bad(bad: list[Row]) -> list[str]:
    if not bad:
        return []
    rows = [(row["recording"], row["error"]) for row in bad[:BAD_SHOWN]]
    more = [paragraph(f"{len(bad) - BAD_SHOWN} more are in the table.")]
    return [
        heading("What could not be read"),
        *_rows(("recording", "why"), rows),
        *(more if len(bad) > BAD_SHOWN else []),
    ]


def _sized(value: float, course: Course) -> str:
    return f"{value:.4g}{_unit(course.unit)}"


def _effect(course: Course) -> str:
    _, effect, component, parameter = course.key
    return f"{effect.replace('_', ' ')} ({parameter}) of {component}"


def _rate(trend: Trend) -> str:
    week = [7.0 * rate for rate in (trend.per_day, trend.low_per_day, trend.high_per_day)]
    unit = _unit(trend.course.unit)
    return f"{week[0]:+.3g}{unit} a week ({week[1]:+.3g} to {week[2]:+.3g})"


NUMBERS = (
    *("false_alarm_p", "rms_before", "rms_after", "noise_floor", "seconds", "value", "low", "high"),
    *("probability", "alone", "share"),
)
TEXTS = (
    *("recording", "robot", "verdict", "error", "effect", "named", "component", "parameter"),
    *("unit", "sisters", "rather"),
)
SCHEMA = pa.schema(
    [("time", pa.timestamp("ms", tz="UTC"))]
    + [(name, pa.string()) for name in TEXTS]
    + [(name, pa.float64()) for name in NUMBERS]
)


def flat_rows(rows: list[Row]) -> Iterator[Row]:
    """One row a size found; one of a recording where nothing was found, or that is bad."""
    for row in rows:
        head = {name: row.get(name) for name in (*TEXTS, *NUMBERS)}
        head["time"] = int(row["time_s"] * 1e3) if "time_s" in row else None
        for finding in row.get("findings") or [{}]:
            yield head | {name: finding.get(name) for name in (*TEXTS, *NUMBERS) if name in finding}


def write_table(rows: list[Row], path: Path) -> None:
    """Write the table; an earlier one is replaced whole."""
    table = pa.Table.from_pylist(list(flat_rows(rows)), schema=SCHEMA)
    with whole_file(path) as out:
        pq.write_table(table, out, compression="zstd")
