"""Charts and pages: the data arrives, nothing is fetched, no text can break out."""

from __future__ import annotations

import json
import re
from html.parser import HTMLParser
from typing import Any

import numpy as np
import pytest

from deltactl.charts import drawing
from deltactl.charts.document import library
from deltactl.charts.figures import HeatStrip, LineChart, histogram
from deltactl.charts.page import (
    THINNED,
    columns,
    facts,
    folded,
    heading,
    page,
    paragraph,
    table,
)
from deltactl.charts.spec import Colour, Mark, Series, Span, Style, pack, unpack

NASTY = "</script><script>alert('x')</script> & \"quoted\" \u2028"
VOID = {"meta", "br"}


class Reader(HTMLParser):
    """Collects tags, texts of scripts, and whether everything is closed in order."""

    def __init__(self) -> None:
        super().__init__()
        self.open: list[str] = []
        self.tags: list[tuple[str, dict[str, str | None]]] = []
        self.data: list[dict[str, Any]] = []

    def handle_starttag(self, tag: str, attrs: list[tuple[str, str | None]]) -> None:
        self.tags.append((tag, dict(attrs)))
        if tag not in VOID:
            self.open.append(tag)

    def handle_endtag(self, tag: str) -> None:
        assert self.open.pop() == tag

    def handle_data(self, data: str) -> None:
        is_data = self.tags and self.tags[-1] == ("script", {"type": "application/json"})
        if is_data and self.open[-1] == "script":
            self.data.append(json.loads(data))


def read(text: str) -> Reader:
    reader = Reader()
    reader.feed(text)
    reader.close()
    assert reader.open == []
    return reader


def chart(**changes: Any) -> LineChart:
    settings: dict[str, Any] = {
        "title": NASTY,
        "x_label": "t [s]",
        "y_label": "e [mm]",
        "series": [Series(NASTY, [0.0, 1.0, 2.0], [1.0, np.nan, 3.0])],
        "marks": [Mark(1.0, NASTY)],
        "spans": [Span(0.0, 1.0, NASTY)],
        "note": NASTY,
    }
    return LineChart(**(settings | changes))


def test_data_arrives_as_given() -> None:
    [spec] = read(chart().html()).data
    [series] = spec["series"]
    np.testing.assert_array_equal(unpack(series["x"]), [0.0, 1.0, 2.0])
    np.testing.assert_array_equal(unpack(series["y"]), [1.0, np.nan, 3.0])
    assert series["name"] == NASTY
    assert spec["marks"][0] == {"x": 1.0, "label": NASTY, "colour": "quiet"}


def test_texts_stay_texts() -> None:
    parts = [
        heading(NASTY),
        paragraph(NASTY, "warn"),
        table([NASTY], [[NASTY, NASTY]], caption=NASTY),
        facts([(NASTY, NASTY)]),
        folded(NASTY, NASTY),
        columns([chart().html()]),
    ]
    reader = read(page(NASTY, parts, lead=NASTY))
    scripts = [attributes for tag, attributes in reader.tags if tag == "script"]
    assert scripts == [{"type": "application/json", "id": "drawn"}, {}, {}]


def test_a_page_loads_nothing() -> None:
    text = page("Report", [chart().html()])
    reader = read(text)
    ours = text.replace(library(), "")
    assert not re.search(r"(?:https?:)?//[a-z]+\.|@import|url\(", ours)
    assert not [tag for tag, _ in reader.tags if tag in {"link", "img", "iframe", "base"}]
    assert not [1 for _, attributes in reader.tags if {"src", "href"} & set(attributes)]
    policy = [a["content"] for _, a in reader.tags if a.get("http-equiv")]
    assert policy[0] is not None
    assert policy[0].startswith("default-src 'none'")


@pytest.mark.study
def test_a_page_with_many_long_curves_stays_below_two_megabytes_and_says_so() -> None:
    rng = np.random.default_rng(1)
    series = [Series(f"{k}", np.arange(50_000), rng.normal(size=50_000)) for k in range(12)]
    text = page("", [chart(series=series).html()])
    assert len(text.encode()) < 2_000_000
    assert THINNED in text
    assert THINNED not in page("", [chart().html()])


def test_a_page_without_charts_carries_no_library() -> None:
    text = page("", [table(["a"], [["1"]])])
    assert "<script" not in text
    assert len(text) < 20_000


def test_without_the_library_the_page_says_what_to_type(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("deltactl.charts.page.find_spec", lambda _: None)
    text = page("", [table(["a"], [["1"]]), chart().html()])
    assert "extras WITH=charts" in text
    assert "<script" not in text


def roots(*charts: LineChart | HeatStrip) -> list[dict[str, Any]]:
    """What the page gives Bokeh for each chart."""
    text = page("", [one.html() for one in charts])
    [drawn] = re.findall(r'id="drawn">(.*?)</script>', text)
    return [root["attributes"] for root in json.loads(drawn)["docs"]["charts"]["roots"]]


def test_the_same_charts_give_the_same_page() -> None:
    assert page("", [chart().html()]) == page("", [chart().html()])


def test_every_chart_has_its_place_in_the_page() -> None:
    """A root that the page does not name is not drawn, and nothing says so."""
    text = page("", [chart().html(), chart().html()])
    [found] = re.findall(r'id="drawn">(.*?)</script>', text)
    drawn = json.loads(found)
    [item] = drawn["items"]
    ids = [root["id"] for root in drawn["docs"]["charts"]["roots"]]
    assert item["root_ids"] == ids == list(item["roots"])
    for place in item["roots"].values():
        assert f'<div class="plot" id="{place}"' in text


def test_charts_of_a_group_share_one_axis_that_shows_all_of_both() -> None:
    short = chart(group="time", series=[Series("a", [2.0, 3.0], [0.0, 1.0])])
    long = chart(group="time", series=[Series("b", [0.0, 9.0], [0.0, 1.0])])
    first, second = roots(short, long)
    axis = first["x_range"]
    assert (axis["attributes"]["reset_start"], axis["attributes"]["reset_end"]) == (0.0, 9.0)
    assert second["x_range"] == {"id": axis["id"]}


@pytest.mark.parametrize(("size", "decimals"), [(20.0, 4), (2e-3, 5), (3e-5, 7), (0.0, 4)])
def test_small_numbers_are_written_out(size: float, decimals: int) -> None:
    [plot] = roots(chart(series=[Series("a", [0.0, 1.0], [-size, size / 2])]))
    for side in ("left", "below"):
        [axis] = plot[side]
        assert 10.0 ** axis["attributes"]["formatter"]["attributes"]["power_limit_low"] < 3e-5
    text = json.dumps(plot)
    assert f"@y0{{0.[{'0' * decimals}]}}" in text


def test_what_is_not_seen_can_be_read_and_pressed() -> None:
    text = chart(title="Error", series=[Series("a", [0.0, 1.0], [2.0, 4.0]), Series("b", [], [])])
    reader = read(text.html())
    [[_, figure]] = [tag for tag in reader.tags if tag[0] == "figure"]
    assert figure["aria-label"] == "Error"
    buttons = [attributes for tag, attributes in reader.tags if tag == "button"]
    assert [b["data-save"] for b in buttons if "data-save" in b] == ["png", "svg", "csv"]
    assert [b["aria-pressed"] for b in buttons if "data-series" in b] == ["true", "true"]
    assert "a: 2 points from 2 to 4, mean 3" in text.html()

    band = Series("flat", [0.0, 1.0], [0.0, 0.0], low=[-2.0, -1.0], high=[1.0, 3.0])
    assert "in a band from -2 to 3." in chart(series=[band]).html()


def test_precision_far_from_zero() -> None:
    """Run times of days, to the microsecond: 32 bits from an offset, not from zero."""
    x = 1e6 + np.arange(5) * 1e-4
    [spec] = read(chart(series=[Series("a", x, x)]).html()).data
    np.testing.assert_allclose(unpack(spec["series"][0]["x"]), x, rtol=0, atol=1e-9)


def test_infinite_values_are_gaps() -> None:
    [spec] = read(chart(series=[Series("a", [0.0, 1.0], [np.inf, 1.0])]).html()).data
    assert np.isnan(unpack(spec["series"][0]["y"])[0])


def test_long_curves_keep_their_peaks_and_say_so() -> None:
    n = 200_000
    y = np.sin(np.arange(n) * 0.01)
    y[123_456], y[77_777] = 50.0, -40.0
    html = chart(series=[Series("a", np.arange(n), y)], note="").html()
    [spec] = read(html).data
    kept = unpack(spec["series"][0]["y"])
    assert len(kept) <= 20_002
    assert kept.max() == 50.0
    assert kept.min() == -40.0
    assert f"{n - len(kept)} points are left out" in html


def test_long_loops_keep_their_ends_and_order() -> None:
    turn = np.linspace(0, 20 * np.pi, 90_001)
    [spec] = read(chart(series=[Series("a", np.cos(turn), np.sin(turn))]).html()).data
    x = unpack(spec["series"][0]["x"])
    assert len(x) <= 20_002
    assert x[0] == pytest.approx(1.0)
    assert x[-1] == pytest.approx(1.0)
    assert not spec["series"][0]["sorted"]


def test_gaps_survive_thinning() -> None:
    y = np.ones(100_000)
    y[50_000] = np.nan
    [spec] = read(chart(series=[Series("a", np.arange(100_000), y)]).html()).data
    assert np.isnan(unpack(spec["series"][0]["y"])).sum() == 1


def test_series_of_unequal_length_are_refused() -> None:
    with pytest.raises(ValueError, match="equally long"):
        chart(series=[Series("a", [0.0, 1.0], [0.0])]).html()
    with pytest.raises(ValueError, match="equally long"):
        chart(series=[Series("a", [0.0], [0.0], low=[0.0, 1.0])]).html()


def test_an_empty_series_is_a_chart_all_the_same() -> None:
    [spec] = read(chart(series=[Series("a", [], [])]).html()).data
    assert len(unpack(spec["series"][0]["x"])) == 0


def test_histogram_counts_everything_once() -> None:
    values = np.append(np.random.default_rng(1).normal(size=999), np.nan)
    [spec] = read(histogram("h", "mm", values).html()).data
    [series] = spec["series"]
    assert series["style"] == Style.BARS.value
    assert unpack(series["y"]).sum() == 999


def test_heat_strip_joins_equal_neighbours() -> None:
    strip = HeatStrip("h", "t", [0, 1, 2, 3, 4], ["a"], [[0, 0, np.nan, np.nan, 2]])
    [spec] = read(strip.html()).data
    [cells] = spec["cells"]
    np.testing.assert_array_equal(unpack(cells["start"]), [0, 2, 4])
    np.testing.assert_array_equal(unpack(cells["end"]), [2, 4, 5])
    np.testing.assert_array_equal(unpack(cells["value"]), [0, np.nan, 2])
    assert (spec["low"], spec["high"]) == (0.0, 2.0)


def test_long_heat_strips_keep_the_worst_state_and_the_mean_of_a_quantity() -> None:
    values = np.zeros((2, 100_000))
    values[1, 54_321] = 3.0
    states = [(name, Colour.GOOD) for name in ("fine", "so so", "poor", "bad")]
    for found_max, kind in ((3.0, states), (3.0 / 5, [])):
        html = HeatStrip("h", "t", np.arange(100_000), ["a", "b"], values, states=kind).html()
        [spec] = read(html).data
        assert unpack(spec["cells"][1]["value"]).max() == pytest.approx(found_max)
        assert "of 5 samples" in html


def test_heat_strips_of_the_wrong_shape_are_refused() -> None:
    with pytest.raises(ValueError, match=r"shape \(1, 2\), not \(1, 3\)"):
        HeatStrip("h", "t", [0, 1, 2], ["a"], [[0, 1]]).html()


def test_the_first_and_the_last_point_lie_within_the_axis_as_drawn() -> None:
    x = np.array([0.1, 0.7, 180.0 + 1.0 / 3.0])
    spec = {"series": [{"x": pack(x), "style": "line"}]}
    low, high = drawing.home(spec)
    drawn = drawing.numbers(pack(x)).astype(np.float64)
    assert low <= drawn.min()
    assert drawn.max() <= high


def test_a_curve_that_is_hidden_at_first_says_so_at_the_legend() -> None:
    x = np.arange(3.0)
    series = [Series("target", x, x), Series("commanded", x, x, hidden=True)]
    legend = LineChart("plane", "x", "y", series).html().split("</div>")[0]
    assert "commanded<small>(hidden; click to show)</small></button>" in legend
    assert legend.count("click to show") == 1
