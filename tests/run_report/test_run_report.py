"""The report of a run: complete, self-contained, and honest about what is missing."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from deltactl.charts.document import library
from deltactl.charts.spec import unpack
from deltactl.firmware_py.run_report.report import report_html, write_report
from deltactl.firmware_py.run_report.sections import STATES, health_strip, sensor_health
from deltactl.firmware_py.run_report.tracking import robot_of
from deltactl.foundation.errors import RecordingError
from deltactl.recording.reading.run import Run
from tests.rigs.charts import charts_of

MakeRun = Callable[..., Run]


def report_of(run: Run) -> str:
    return report_html(run, robot_of(run))


def test_it_shows_what_the_papers_figures_show(recorded_run: MakeRun) -> None:
    run = recorded_run(truth_error_m=(0.001, 0.0, 0.0))
    charts = charts_of(lambda: report_of(run))
    path = charts["The path from above"]
    assert path["equal"]
    assert [series["name"] for series in path["series"]] == [
        "measured",
        "commanded",
        "simulated truth",
        "target",
    ]
    for axis in "xyz":
        errors = charts[f"Error along {axis}"]
        assert errors["yLabel"] == f"e_{axis} [mm]"
        assert errors["group"] == charts["Readings"]["group"]
    [_, truth] = charts["Error along x"]["series"]
    np.testing.assert_allclose(unpack(truth["y"]), 1.0, atol=1e-5)


@pytest.mark.study
def test_it_says_what_ran_and_how_well(recorded_run: MakeRun) -> None:
    html = report_of(recorded_run(truth_error_m=(0.001, 0.0, 0.0)))
    for text in ("arc on zhao-2023", "0.006 s", "2023-11-14", "drawn.mcap", "name: arc"):
        assert text in html
    assert '<td class="number">1.000</td><td class="number">0.000</td>' in html
    assert "contains the sensors&#x27; noise" in html


def test_it_is_one_small_file_that_loads_nothing(recorded_run: MakeRun) -> None:
    html = report_of(recorded_run())
    assert len(html) < 2_000_000
    ours = html.replace(library(), "")
    assert len(ours) < 200_000
    assert "http://" not in ours
    assert "https://" not in ours


@pytest.mark.parametrize(
    ("changes", "says"),
    [
        ({"closed": False}, "The recording is cut off at byte"),
        ({"events": ()}, "The path was never begun"),
        ({"with_readings": False}, "No readings were recorded"),
    ],
)
def test_what_is_missing_is_said(recorded_run: MakeRun, changes: dict[str, Any], says: str) -> None:
    assert f'<p class="warn">{says}' in report_of(recorded_run(**changes))


def test_a_run_without_anything_is_still_a_report(recorded_run: MakeRun) -> None:
    run = recorded_run(with_readings=False, with_truth=False, events=())
    drawn = charts_of(lambda: report_of(run))
    assert drawn
    assert "Error along x" not in drawn


def test_sensor_health_counts(recorded_run: MakeRun) -> None:
    run = recorded_run(
        weak=frozenset({("x", 30), ("x", 31)}), silent=frozenset({("y", n) for n in range(40, 50)})
    )
    x, y, z = sensor_health(run)
    assert (x.samples, x.gated, x.good_share) == (100, {"signal": 2}, pytest.approx(0.98))
    assert y.samples == 90
    assert y.longest_silence_s == pytest.approx(0.22)
    assert (z.rate_hz, z.stale) == (pytest.approx(50.0), 0)


def test_health_strip_shows_every_round(recorded_run: MakeRun) -> None:
    run = recorded_run(weak=frozenset({("x", 30)}), silent=frozenset({("y", 40)}))
    strip = health_strip(run, "time")
    assert [name for name, _ in strip.states] == ["good", "signal", "nothing new"]
    values = np.asarray(strip.values)
    assert np.flatnonzero(values[0]).tolist() == [30]
    assert np.flatnonzero(values[1]).tolist() == [40]
    assert values[0, 30] == 1
    assert values[1, 40] == 2
    assert STATES[0][0] == "good"


def test_it_replaces_an_earlier_report_whole(recorded_run: MakeRun, tmp_path: Path) -> None:
    run = recorded_run()
    out = tmp_path / "report.html"
    out.write_text("earlier")
    write_report(run.path, out)
    assert out.read_text(encoding="utf-8") == report_of(run)
    assert sorted(path.name for path in tmp_path.iterdir()) == ["drawn.mcap", "report.html"]


@pytest.mark.study
def test_a_place_that_cannot_be_written(recorded_run: MakeRun, tmp_path: Path) -> None:
    with pytest.raises(RecordingError, match=r"no/report\.html: cannot be written"):
        write_report(recorded_run().path, tmp_path / "no" / "report.html")
