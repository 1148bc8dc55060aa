"""The charts a report is made of; each becomes a piece of HTML for `deltactl.charts.page.page`."""

from __future__ import annotations

import html
import json
import warnings
from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import ArrayLike

from deltactl.charts.spec import (
    MAXIMUM_POINTS,
    Colour,
    FloatArray,
    Mark,
    Series,
    Span,
    Style,
    column_names,
    pack,
    script_json,
    series_spec,
    spoken,
)
from deltactl.foundation.printable import count

LINE_HEIGHT_PX = 260
EQUAL_HEIGHT_PX = 460
HIDDEN = "<small>(hidden; click to show)</small>"
"""Beside the name of a curve that is not shown at first; gone once it is."""
HEAT_ROW_PX = 26
HEAT_AROUND_PX = 84
"""Tools above a strip, and its axis below."""


@dataclass(frozen=True)
class LineChart:
    """Curves over a common x axis, or in a plane (`equal_aspect`).

    Charts of one `group` zoom and point together. `note` is a sentence below the chart.
    """

    title: str
    x_label: str
    y_label: str
    series: Sequence[Series]
    equal_aspect: bool = False
    spans: Sequence[Span] = ()
    marks: Sequence[Mark] = ()
    group: str = ""
    note: str = ""
    height_px: int | None = None

    def html(self) -> str:
        """The chart as HTML. Raises ValueError when a series' arrays differ in length."""
        found = [series_spec(series) for series in self.series]
        left_out = sum(number for _, number in found)
        note = self.note
        if left_out:
            verb = "is" if left_out == 1 else "are"
            left = f"{count(left_out, 'point').capitalize()} {verb} left out of the picture"
            note = f"{note} {left}; peaks are kept.".strip()
        spec = {
            "kind": "line",
            "title": self.title,
            "xLabel": self.x_label,
            "yLabel": self.y_label,
            "equal": self.equal_aspect,
            "group": self.group,
            "series": [spec for spec, _ in found],
            "spans": [_span(span) for span in self.spans],
            "marks": [_mark(mark) for mark in self.marks],
        }
        height_px = self.height_px or (EQUAL_HEIGHT_PX if self.equal_aspect else LINE_HEIGHT_PX)
        return figure(self.title, spec, height_px, note)


def histogram(
    title: str,
    x_label: str,
    values: ArrayLike,
    bins: int = 40,
    colour: Colour = Colour.FIRST,
    marks: Sequence[Mark] = (),
    note: str = "",
) -> LineChart:
    """How often values occur; NaN is left out."""
    numbers = np.asarray(values, dtype=np.float64).ravel()
    counts, edges = np.histogram(numbers[np.isfinite(numbers)], bins=bins)
    middles = (edges[:-1] + edges[1:]) / 2
    series = Series("count", middles, counts, colour, Style.BARS)
    return LineChart(title, x_label, "count", [series], marks=marks, note=note)


@dataclass(frozen=True)
class HeatStrip:
    """Rows of coloured cells over the x axis: a quantity, or one of a few named states.

    x: shape (n,), start of each cell. values: shape (rows, n), NaN = nothing. With `states`
    a value is an index into it, each (name, colour), the best first; without, colours run from
    `low` to `high` (the smallest and largest value if not given). More than 20 000 cells a row
    are joined: the worst state, or the mean.
    """

    title: str
    x_label: str
    x: ArrayLike
    rows: Sequence[str]
    values: ArrayLike
    states: Sequence[tuple[str, Colour]] = ()
    unit: str = ""
    low: float | None = None
    high: float | None = None
    group: str = ""
    note: str = ""

    def html(self) -> str:
        """The strip as HTML. Raises ValueError when shapes do not fit."""
        x = np.asarray(self.x, dtype=np.float64)
        values = np.asarray(self.values, dtype=np.float64)
        if values.shape != (len(self.rows), len(x)):
            raise ValueError(
                f"heat strip '{self.title}': values have shape {values.shape}, "
                f"not ({len(self.rows)}, {len(x)})"
            )
        finite = values[np.isfinite(values)]
        low, high = (float(finite.min()), float(finite.max())) if len(finite) else (0.0, 1.0)
        x, values, note = _joined(x, values, bool(self.states), self.note)
        cells = [_runs(x, row) for row in values]
        spec = {
            "kind": "heat",
            "title": self.title,
            "xLabel": self.x_label,
            "group": self.group,
            "rows": list(self.rows),
            "unit": self.unit,
            "states": [{"name": name, "colour": colour.value} for name, colour in self.states],
            "low": low if self.low is None else self.low,
            "high": high if self.high is None else self.high,
            "cells": cells,
        }
        return figure(self.title, spec, HEAT_ROW_PX * len(self.rows) + HEAT_AROUND_PX, note)


def figure(title: str, spec: dict[str, Any], height_px: int, note: str) -> str:
    """A figure with its data; `deltactl.charts.page.page` draws those of a page together."""
    name = html.escape(title, quote=True)
    columns = html.escape(json.dumps(column_names(spec)), quote=True)
    spec = spec | {"height": height_px}
    return (
        f'<figure class="chart" role="figure" aria-label="{name}" data-title="{name}" '
        f'data-columns="{columns}">'
        f"<figcaption>{html.escape(title)}{_tools(name)}</figcaption>{_legend(spec)}"
        f'<p class="for-readers">{html.escape(spoken(spec))}</p>'
        f'<script type="application/json">{script_json(spec)}</script>{_note(note)}</figure>'
    )


def _tools(name: str) -> str:
    kinds = (("png", "a picture"), ("svg", "a drawing"), ("csv", "numbers"))
    return (
        '<span class="tools">'
        + "".join(
            f'<button type="button" data-save="{kind}" title="save as {what} ({kind.upper()})" '
            f'aria-label="save {name} as {what}, {kind.upper()}">{kind.upper()}</button>'
            for kind, what in kinds
        )
        + "</span>"
    )


def _legend(spec: dict[str, Any]) -> str:
    """Names beside their colours; curves can be switched off."""
    entries = spec["states"] if spec["kind"] == "heat" else spec["series"]
    if len(entries) < 2:
        return ""
    rows = []
    for number, entry in enumerate(entries):
        kind = "dashed" if entry.get("dashed") else entry.get("style", "cell")
        text = (
            f'<i class="{kind}" style="background:var(--{entry["colour"]})"></i>'
            f"{html.escape(entry['name'])}"
        )
        pressed = "false" if entry.get("hidden") else "true"
        text += HIDDEN if entry.get("hidden") else ""
        rows.append(
            f'<button type="button" data-series="{number}" aria-pressed="{pressed}">{text}</button>'
        )
    return f'<div class="legend">{"".join(rows)}</div>'


def _note(note: str) -> str:
    return f'<p class="note">{html.escape(note)}</p>' if note else ""


def _span(span: Span) -> dict[str, Any]:
    return {
        "start": float(span.start),
        "end": float(span.end),
        "label": span.label,
        "colour": span.colour.value,
    }


def _mark(mark: Mark) -> dict[str, Any]:
    return {"x": float(mark.x), "label": mark.label, "colour": mark.colour.value}


def _joined(
    x: FloatArray, values: FloatArray, worst: bool, note: str
) -> tuple[FloatArray, FloatArray, str]:
    """At most `thin.MAXIMUM_POINTS` cells a row."""
    each = -(-len(x) // MAXIMUM_POINTS)
    if each <= 1:
        return x, values, note
    whole = len(x) // each * each
    parts = values[:, :whole].reshape(len(values), -1, each)
    with warnings.catch_warnings():
        warnings.simplefilter("ignore", RuntimeWarning)  # a cell of nothing but NaN stays NaN
        joined = np.nanmax(parts, axis=2) if worst else np.nanmean(parts, axis=2)
    how = "the worst" if worst else "the mean"
    return x[:whole:each], joined, f"{note} Each cell is {how} of {each} samples.".strip()


def _runs(x: FloatArray, row: FloatArray) -> dict[str, Any]:
    """Neighbouring cells of the same value as one: start, end and value of each run."""
    if not len(x):
        empty = np.zeros(0)
        return {"start": pack(empty), "end": pack(empty), "value": pack(empty)}
    last = 2 * x[-1] - x[-2] if len(x) > 1 else x[-1] + 1.0
    same = (row[1:] == row[:-1]) | (np.isnan(row[1:]) & np.isnan(row[:-1]))
    starts = np.concatenate([[0], np.flatnonzero(~same) + 1])
    ends = np.append(x[starts[1:]], last)
    return {"start": pack(x[starts]), "end": pack(ends), "value": pack(row[starts])}
