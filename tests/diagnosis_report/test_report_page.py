"""The report as one HTML file."""

from __future__ import annotations

import math
import re
from html.parser import HTMLParser
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from deltactl.charts.document import library
from deltactl.diagnosis.answer.records import (
    Alternative,
    Evidence,
    Fit,
    NextExperiment,
    ParameterResult,
    Picture,
)
from deltactl.diagnosis.report.fit import pair_bars
from deltactl.diagnosis.report.page import report_html, write_report
from deltactl.foundation.errors import RecordingError
from tests.rigs.charts import charts_of

VERDICTS = ("nothing_missing", "explained", "partly_explained", "unexplained")
VOID = {"meta", "br", "img", "input", "hr", "link"}
LARGEST = 2_000_000
NAN = math.nan


class Structure(HTMLParser):
    """Open and close tags as they nest; scripts are text."""

    def __init__(self, text: str):
        super().__init__(convert_charrefs=True)
        self.open: list[str] = []
        self.wrong: list[str] = []
        self.ids: list[str] = []
        self.tags: list[str] = []
        self.links: list[str] = []
        self.text: list[str] = []
        self.feed(text)
        self.close()

    def handle_starttag(self, tag: str, attrs: list[tuple[str, str | None]]) -> None:
        self.tags.append(tag)
        found = dict(attrs)
        self.ids += [found["id"] or ""] if "id" in found else []
        self.links += [value or "" for name, value in attrs if name in ("src", "href")]
        self.wrong += [f"{tag} {name}" for name, _ in attrs if name.startswith("on")]
        if tag not in VOID:
            self.open.append(tag)

    def handle_startendtag(self, tag: str, attrs: list[tuple[str, str | None]]) -> None:
        self.tags.append(tag)

    def handle_endtag(self, tag: str) -> None:
        if not self.open or self.open.pop() != tag:
            self.wrong.append(f"</{tag}>")

    def handle_data(self, data: str) -> None:
        self.text.append(data)


def checked(page: str) -> Structure:
    found = Structure(page)
    assert found.wrong == []
    assert found.open == []
    assert len(found.ids) == len(set(found.ids))
    assert found.tags.count("h1") == 1
    targets = {link.removeprefix("#") for link in found.links}
    assert all(link.startswith("#") for link in found.links)
    assert targets <= set(found.ids)
    assert len(page) < LARGEST
    return found


@pytest.mark.parametrize("verdict", VERDICTS)
def test_every_verdict_gives_a_whole_page(make: Any, parts: Any, verdict: str) -> None:
    page = report_html(make(verdict), parts["delta"]())
    found = checked(page)
    assert f'class="verdict {verdict}"' in page
    assert found.tags.count("section") == 1
    findings = [f"finding-{number}" for number, _ in enumerate(make(verdict).findings, 1)]
    assert [name for name in found.ids if name.startswith("finding")] == findings
    assert "http" not in page.replace(library(), "").replace("http-equiv", "")
    assert ("Does it help?" in page) == bool(make(verdict).findings)
    drawn = charts_of(lambda: report_html(make(verdict), parts["delta"]()))
    series = {one["name"] for spec in drawn.values() for one in spec["series"]}
    assert ("single readings" in series) == (not make(verdict).findings)
    for title in ("The error over time", "The error by place"):
        assert title in page


def test_what_comes_from_outside_is_text_everywhere(make: Any, parts: Any) -> None:
    evil = "<script>alert(1)</script>\"'><img src=x onerror=alert(1)>"
    bad = parts["backlash"](
        effect=evil, component=evil, says=evil, depends_on=[evil],
        parameters={evil: ParameterResult(value=1.0, ci95=[0.5, 1.5], unit=evil)},
        alternatives=[Alternative(effect=evil, component=evil, delta_chi2=1.0)],
    )  # fmt: skip
    bad.where.regime = evil
    bad.where.axes = [evil]
    plan = NextExperiment(job={evil: evil}, tells_apart=[evil], expected_delta_chi2=1, minutes=1)
    picture = parts["picture"](600, names=(evil, "range_y"))
    picture.covariates[evil] = picture.covariates["theta_1"]
    answer = make(
        "partly_explained", findings=[bad], next_experiment=plan, recordings=[evil],
        picture=picture, says=[f"Besides {evil}"],
    )  # fmt: skip
    page = report_html(answer, parts["delta"]("<b>&robot"))
    found = checked(page)
    assert "img" not in found.tags
    assert "<script>alert" not in page
    assert "Diagnosis of <b>&robot" in "".join(found.text)
    assert any("onerror" in text for text in found.text)


@pytest.mark.parametrize("kind", range(4))
def test_lone_axes_and_sensors_have_their_drawing(make: Any, parts: Any, kind: int) -> None:
    robot = parts["lone"]()[kind]
    finding = parts["backlash"](component="axis")
    if robot.kind == "range_sensor":
        finding = parts["backlash"](effect="sensor_offset", component="axis")
    names = ("position",) if robot.kind == "servo_axis" else ("theta_1",)
    answer = make("explained", findings=[finding], picture=parts["picture"](800, names=names))
    page = report_html(answer, robot)
    checked(page)
    where = "sensor" if robot.kind == "range_sensor" else "gear"
    assert re.search(rf'class="part solid hit hue1" data-part="{where}"', page)


@pytest.mark.study
def test_long_recordings_stay_small(make: Any, parts: Any) -> None:
    names = (*(f"range_{a}" for a in "xyz"), *(f"pos_{a}" for a in "xyz"), "theta_1", "theta_2")
    big = report_html(make("explained", picture=parts["picture"](12_000, names)), parts["delta"]())
    assert len(big) < LARGEST
    huge = report_html(make("explained", picture=parts["picture"](60_000)), parts["delta"]())
    assert len(huge) < LARGEST


def hollow(n: int) -> Picture:
    return Picture(t_s=np.arange(float(n)), channels=[])


def test_a_page_without_readings_says_so(make: Any, parts: Any) -> None:
    nothing = parts["picture"](50)
    for channel in nothing.channels:
        channel.observed[:] = NAN
    for picture in (None, hollow(0), hollow(5), nothing):
        page = report_html(make("explained", picture=picture), parts["delta"]())
        checked(page)
        assert "no readings to draw" in page


@pytest.mark.parametrize("samples", [1, 2, 3, 17])
def test_a_few_samples_are_drawn_too(make: Any, parts: Any, samples: int) -> None:
    picture = parts["picture"](max(samples, 2))
    if samples == 1:
        picture = Picture(t_s=np.zeros(1), channels=[], covariates={})
    checked(report_html(make("explained", picture=picture), parts["delta"]()))


def test_unknown_figures_do_not_break_the_page(make: Any, parts: Any) -> None:
    empty = parts["backlash"](
        parameters={
            "width": ParameterResult(value=NAN, ci95=[NAN, NAN], unit="rad"),
            "other": ParameterResult(value=1.0, ci95=[], unit=""),
            "list": ParameterResult(value=[1.0, 2.0], ci95=[[0.0, 2.0]], unit="s"),
        },
        evidence=Evidence(delta_chi2=NAN, p=NAN),
        share_of_mismatch=NAN,
    )
    fit = Fit(
        rms_before_m=NAN, rms_after_m=0.0, noise_floor_m=0.0,
        holdout_rms_before_m=NAN, holdout_rms_after_m=NAN,
    )  # fmt: skip
    picture = parts["picture"](400)
    picture.channels[0].before[:] = NAN
    picture.channels[1].after[100:200] = math.inf
    picture.covariates["theta_1"][:] = NAN
    picture.covariates["speed_1"][:] = 0.0
    page = report_html(
        make("explained", findings=[empty], fit=fit, picture=picture), parts["delta"]()
    )
    checked(page)
    visible = re.sub(r"<(script|style).*?</\1>", "", page, flags=re.S)
    assert not re.search(r"\b(nan|inf)\b", visible, re.I)


def test_many_findings_and_long_texts(make: Any, parts: Any) -> None:
    long = "a very long sentence that goes on and on " * 60
    many = [parts["backlash"](says=long, component=f"motor{k % 3 + 1}") for k in range(20)]
    many.append(parts["lost_steps"](says="x" * 3000))
    page = report_html(make("partly_explained", findings=many), parts["delta"]("n" * 100))
    found = checked(page)
    findings = [name for name in found.ids if name.startswith("finding-")]
    assert findings == [f"finding-{k}" for k in range(1, 22)]


def test_the_next_experiment_is_a_job_to_save(make: Any, parts: Any) -> None:
    page = report_html(make("explained"), parts["delta"]())
    assert "radius_m: 0.1" in page
    assert "deltactl run job.yaml" in page
    assert "The run proposed below is made to distinguish them." in page
    alone = report_html(make("explained", next_experiment=None), parts["delta"]())
    assert "deltactl run job.yaml" not in alone


def test_play_against_friction_gets_the_hint_from_the_reference(make: Any, parts: Any) -> None:
    other = Alternative(effect="joint_friction", component="motor2", delta_chi2=1.2)
    finding = parts["backlash"](alternatives=[other])
    page = report_html(
        make("explained", findings=[finding], next_experiment=None), parts["delta"]()
    )
    assert "approaching from both sides" in page
    assert "bearing friction in motor 2" in page


def test_spans_stand_on_the_channels_that_show_the_finding(make: Any, parts: Any) -> None:
    answer = make("explained", findings=[parts["lost_steps"]()])
    specs = charts_of(lambda: report_html(answer, parts["delta"]()))
    spans = {
        name: bool(spec["spans"])
        for name, spec in specs.items()
        if re.fullmatch("Distance .", name)
    }
    assert spans == {"Distance x": True, "Distance y": False, "Distance z": False}


def test_the_file_is_written_whole_or_not_at_all(make: Any, parts: Any, tmp_path: Path) -> None:
    out = tmp_path / "report.html"
    out.write_text("old")
    write_report(make("explained"), parts["delta"](), out)
    assert out.read_text(encoding="utf-8").startswith("<!doctype html>")
    assert list(tmp_path.iterdir()) == [out]
    with pytest.raises(RecordingError, match="cannot be written"):
        write_report(make("explained"), parts["delta"](), tmp_path / "none" / "report.html")


def test_the_same_answer_gives_the_same_page(make: Any, parts: Any) -> None:
    assert report_html(make(), parts["delta"]()) == report_html(make(), parts["delta"]())


def test_bars_are_as_long_as_their_values() -> None:
    from deltactl.diagnosis.report.fit import Pair

    bars = pair_bars("t", [Pair("one", 4.0, 1.0), Pair("two", NAN, 2.0)], 0.5, "mm")
    assert re.findall(r"width:([\d.]+)%", bars) == ["100.00", "25.00", "0.00", "50.00"]
    assert bars.count("left:12.50%") == 2
    assert "4.00 \u2192 1.00 mm" in bars
