"""One complete round: hide a fault, draw, record, diagnose, correct, draw again, compare."""

from __future__ import annotations

import html
import warnings
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import NamedTuple

import numpy as np

from deltactl.charts.figures import LineChart
from deltactl.charts.page import columns, heading, page, paragraph, table
from deltactl.charts.spec import Colour, Series
from deltactl.diagnosis.answer.corrected_robot import save_corrected
from deltactl.diagnosis.answer.records import Channel, Diagnosis, Finding
from deltactl.diagnosis.answer.tables import Tables
from deltactl.diagnosis.api import diagnose
from deltactl.diagnosis.report.machines import machine_drawing
from deltactl.diagnosis.report.page import style
from deltactl.diagnosis.report.sizes import quantity
from deltactl.firmware_py.planner.plan import plan_of
from deltactl.firmware_py.program.coverage import Coverage, coverage_of
from deltactl.firmware_py.robot_file import load_robot
from deltactl.foundation.plain_file import said_of_output, write_whole
from deltactl.models.robot import FloatArray
from deltactl.models.robot_files import load_with_effects
from deltactl.proof.hidden.hidden import Hidden
from deltactl.recording.tables.flat_files import write_flat
from deltactl.repair.correct import held_back
from deltactl.repair.limit import Limit, limit_of
from deltactl.repair.machine import faulty_robot
from deltactl.repair.played import Drawn, played

Progress = Callable[[str], None]
RECORDING, CORRECTED = "survey.csv.gz", "corrected.yaml"


class HiddenFaults(NamedTuple):
    """The hidden faults: effects by name, drawn with a seed, and something without a name."""

    effects: Sequence[str]
    seed: int
    unknown: bool = False


@dataclass(frozen=True, eq=False)
class Demonstration:
    """One robot, before and after; `possible` is the same robot without the hidden faults."""

    answers: Sequence[Hidden]
    before: Drawn
    after: Drawn
    possible: Drawn
    diagnosis: Diagnosis
    coverage: Coverage
    held_back: Sequence[tuple[Finding, str]]
    """Findings that were not written into the corrected file, and why."""
    limit: Limit | None
    """What the corrected robot file says is possible."""
    robot_file: Path
    corrected: Path
    recording: Path
    survey_s: float

    @property
    def gain(self) -> float:
        """Share of what is above the possible that is gone; 1 where nothing was."""
        above = self.before.rms_m - self.possible.rms_m
        return 1.0 if above <= 0.0 else (self.before.rms_m - self.after.rms_m) / above


def demonstrate(
    job: Path,
    robot_file: Path,
    folder: Path,
    hidden: HiddenFaults,
    survey_s: float = 120.0,
    progress: Progress = lambda _: None,
) -> Demonstration:
    """Run it all and leave recording and corrected robot file in `folder`.

    Raises ConfigError for an effect that cannot be hidden, or any error of the steps.
    """
    machine = faulty_robot(list(hidden.effects), hidden.seed, hidden.unknown)
    progress("drawing with the robot as it was built")
    accepted = load_robot(robot_file)
    path = played(plan_of(job, accepted))
    before = machine.draw(path)
    possible = faulty_robot([], hidden.seed).draw(path)
    progress(f"recording a survey of {survey_s:.0f} s")
    recording = folder / RECORDING
    write_flat(machine.survey(survey_s), recording)

    def show(text: str) -> None:
        progress(f"diagnosing: {text}")

    answer = diagnose([recording], robot_file, progress=show)
    corrected = folder / CORRECTED
    corrected.unlink(missing_ok=True)
    save_corrected(robot_file, answer, corrected)
    progress("drawing with the corrected robot")
    plan, covered = plan_of(job, load_robot(corrected)), coverage_of(job, corrected)
    new = played(plan)
    after = before if new.is_same_as(path) else machine.draw(new)
    return Demonstration(
        answers=machine.answers,
        before=before,
        after=after,
        possible=possible,
        diagnosis=answer,
        coverage=covered,
        held_back=held_back(answer, accepted, False, Tables.NONE),
        limit=limit_of(plan, covered),
        robot_file=robot_file,
        corrected=corrected,
        recording=recording,
        survey_s=survey_s,
    )


MM = 1e3
MAGNIFIED = (1, 2, 5, 10, 20, 50)
SEEN_M = 0.012
SMOOTHED = 25
"""Readings in one median of the error: half a second, so that outliers do not hide it."""
STYLE = """
.figures { display: flex; flex-wrap: wrap; gap: 1rem 2.5rem; margin: 1rem 0 1.5rem; }
.figures div { min-width: 9rem; }
.figures b { display: block; font-size: 2rem; font-weight: 600; line-height: 1.2; }
"""


def write_page(demo: Demonstration, out: Path) -> None:
    """Write the page; an earlier one is replaced whole or not at all. Raises RecordingError."""
    with said_of_output(out):
        write_whole(out, page_html(demo))


def page_html(demo: Demonstration) -> str:
    """The page as one HTML document."""
    robot = load_with_effects(demo.robot_file)
    parts = [
        _headline(demo),
        _picture(demo),
        columns([machine_drawing(robot, demo.diagnosis.findings), _error_chart(demo)]),
        *_mismatch(demo),
        heading("Hidden faults and findings"),
        _found(demo),
        heading("What is done about it"),
        *_covered(demo.coverage),
        paragraph(
            "The robot is a MuJoCo model with its own bodies, contacts and friction; the diagnosis "
            "had only the readings of three distance sensors and the commanded counts.",
            "note",
        ),
    ]
    lead = (
        f"A robot with hidden faults drew a heart, was recorded for "
        f"{demo.survey_s / 60.0:.0f} minutes, diagnosed and corrected, and drew it again."
    )
    return page("From a hidden fault to better tracking", parts, lead, _style())


def _style() -> str:
    # The drawing of the robot is the diagnosis report's.
    return style() + STYLE


def _headline(demo: Demonstration) -> str:
    cells = [
        ("before", demo.before.rms_m),
        ("after", demo.after.rms_m),
        ("healthy robot", demo.possible.rms_m),
    ]
    if demo.limit is not None:
        cells.append(("limit", demo.limit.rms_m))
    shown = "".join(
        f"<div>{html.escape(name)}<b>{MM * rms_m:.2f} mm</b></div>" for name, rms_m in cells
    )
    about = paragraph(
        "Distance of the platform from its target while it drew, root mean square. Healthy robot: "
        "the same without a hidden fault. Limit: what the corrected robot file leaves uncorrected.",
        "note",
    )
    return f'<div class="figures">{shown}</div>{about}'


def _picture(demo: Demonstration) -> str:
    target, times = demo.before.target_m, _magnified(demo.before)

    def shown(run: Drawn) -> tuple[FloatArray, FloatArray]:
        return _plane(run.target_m + times * (run.true_m - run.target_m))

    curves = [
        Series("before", *shown(demo.before), Colour.BAD),
        Series("after", *shown(demo.after), Colour.FIRST),
        Series("target", *_plane(target), Colour.ASKED, dashed=True),
    ]
    note = "Where the platform truly was, seen from above"
    note += f"; what it is off by is drawn {times} times as large." if times > 1 else "."
    chart = LineChart("The heart", "x [mm]", "y [mm]", curves, equal_aspect=True, note=note)
    return chart.html()


def _magnified(before: Drawn) -> int:
    """So many times larger are errors drawn, for the worst to be well seen."""
    worst_m = max(before.worst_m, 1e-6)
    return next((times for times in MAGNIFIED if times * worst_m >= SEEN_M), MAGNIFIED[-1])


def _error_chart(demo: Demonstration) -> str:
    def over_time(name: str, run: Drawn, colour: Colour) -> Series:
        return Series(name, run.t_s - run.t_s[0], MM * run.error_m, colour)

    curves = [
        over_time("before", demo.before, Colour.BAD),
        over_time("after", demo.after, Colour.FIRST),
        over_time("possible", demo.possible, Colour.QUIET),
    ]
    return LineChart("Distance from the target", "time [s]", "distance [mm]", curves).html()


def _mismatch(demo: Demonstration) -> list[str]:
    """Readings of the survey minus prediction, before and after."""
    picture = demo.diagnosis.picture
    if picture is None:
        return []
    charts = []
    for channel in picture.channels:
        left = [
            Series("before", picture.t_s, _median(channel, channel.before), Colour.BAD),
            Series("after", picture.t_s, _median(channel, channel.after), Colour.FIRST),
        ]
        title = f"{channel.name} in the survey, measured minus predicted, smoothed over 0.5 s"
        charts.append(
            LineChart(title, "time [s]", "measured - predicted [mm]", left, group="survey").html()
        )
    return [heading("Measured minus predicted"), *charts]


def _median(channel: Channel, predicted: FloatArray) -> FloatArray:
    left_mm = MM * (channel.observed - predicted)
    if len(left_mm) < SMOOTHED:
        return left_mm
    half = SMOOTHED // 2
    windows = np.lib.stride_tricks.sliding_window_view(left_mm, SMOOTHED)
    with warnings.catch_warnings():
        warnings.simplefilter("ignore", RuntimeWarning)  # a stretch without any good reading
        smooth: FloatArray = np.full(len(left_mm), np.nan)
        smooth[half : len(left_mm) - half] = np.nanmedian(windows, axis=1)
    return smooth


def _found(demo: Demonstration) -> str:
    hidden = [(f"{one.effect} on {one.where}", "hidden", _size(one)) for one in demo.answers]
    found = [
        (f"{finding.effect} on {finding.component}", "found", finding.says)
        for finding in demo.diagnosis.findings
    ]
    return table(("effect", "", "size"), [*hidden, *found], numbers_from=9)


def _size(hidden: Hidden) -> str:
    """In the units in which the finding is reported."""
    parts = np.ravel(hidden.parameters[hidden.main])
    return ", ".join(quantity(float(part), hidden.unit, hidden.main, 3) for part in parts)


def _covered(coverage: Coverage) -> list[str]:
    if not coverage.effects:
        return [paragraph("Nothing was found that could be corrected: nothing is changed.")]
    rows = [
        (
            f"{effect.effect} on {effect.component}",
            effect.how or f"not compensated: {effect.why_not}",
        )
        for effect in coverage.effects
    ]
    return [table(("effect", "compensation"), rows, numbers_from=9)]


def _plane(position_m: FloatArray) -> tuple[FloatArray, FloatArray]:
    return MM * position_m[:, 0], MM * position_m[:, 1]
