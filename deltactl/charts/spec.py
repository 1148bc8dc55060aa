"""Fewer points for the same picture: peaks stay where they are."""

from __future__ import annotations

import base64
import enum
import json
from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import ArrayLike

FloatArray = np.ndarray[Any, np.dtype[np.float64]]
Index = np.ndarray[Any, np.dtype[np.intp]]

MAXIMUM_POINTS = 20_000
"""More than any screen has columns; zooming in still finds the peaks of every bucket."""


def keep(x: FloatArray, y: FloatArray, maximum: int = MAXIMUM_POINTS) -> Index:
    """Indices of at most about `maximum` points, in order.

    A curve over increasing `x` keeps the lowest and highest point (and the first gap) of every
    bucket; any other curve keeps every k-th point.
    """
    n = len(x)
    if n <= maximum:
        return np.arange(n)
    if not is_increasing(x):
        return np.append(np.arange(0, n - 1, -(-n // maximum)), n - 1)
    starts = np.linspace(0, n, max(1, maximum // 3) + 1).astype(np.intp)[:-1]
    kept: Index = np.unique(np.concatenate([[0, n - 1], *_extremes(y, starts)]))
    return kept


def is_increasing(x: FloatArray) -> bool:
    """Whether `x` never goes back (and holds no NaN)."""
    return bool(np.all(np.diff(x) >= 0.0)) and not bool(np.isnan(x).any())


def _extremes(y: FloatArray, starts: Index) -> list[Index]:
    """Per bucket the index of its lowest, highest and first missing value."""
    found: list[list[int]] = [[], [], []]
    missing = np.isnan(y)
    low, high = np.where(missing, np.inf, y), np.where(missing, -np.inf, y)
    for start, end in zip(starts, [*starts[1:], len(y)], strict=True):
        found[0].append(start + int(np.argmin(low[start:end])))
        found[1].append(start + int(np.argmax(high[start:end])))
        found[2].append(start + int(np.argmax(missing[start:end])))
    return [np.array(part, dtype=np.intp) for part in found]


class Style(enum.Enum):
    """How a series is drawn."""

    LINE = "line"
    POINTS = "points"
    BARS = "bars"
    """Columns from zero, one a point, as wide as the points are apart."""


class Colour(enum.Enum):
    """Colours by meaning; readable on light and dark, and apart for the colour-blind."""

    ASKED = "asked"
    COMMANDED = "commanded"
    MEASURED = "measured"
    TRUE = "true"
    FIRST = "first"
    SECOND = "second"
    THIRD = "third"
    GOOD = "good"
    BAD = "bad"
    QUIET = "quiet"


@dataclass(frozen=True)
class Series:
    """A curve. x, y: shape (n,), NaN = gap. low, high: shape (n,), a band around it."""

    name: str
    x: ArrayLike
    y: ArrayLike
    colour: Colour = Colour.FIRST
    style: Style = Style.LINE
    dashed: bool = False
    hidden: bool = False
    """Shown only when the reader switches it on."""
    low: ArrayLike | None = None
    high: ArrayLike | None = None


@dataclass(frozen=True)
class Span:
    """A stretch of the x axis with a tint behind the curves."""

    start: float
    end: float
    label: str = ""
    colour: Colour = Colour.QUIET


@dataclass(frozen=True)
class Mark:
    """A vertical line with a word at its top."""

    x: float
    label: str
    colour: Colour = Colour.QUIET


def pack(values: FloatArray) -> dict[str, Any]:
    """Numbers as base64 of 32-bit floats from an offset; half the size of text."""
    finite = values[np.isfinite(values)]
    offset = float(finite[0]) if len(finite) else 0.0
    data = (values - offset).astype("<f4").tobytes()
    return {"offset": offset, "f32": base64.b64encode(data).decode()}


def unpack(packed: Mapping[str, Any]) -> FloatArray:
    """What `pack` was given, to 24 bits."""
    data = np.frombuffer(base64.b64decode(packed["f32"]), dtype="<f4")
    return data.astype(np.float64) + float(packed["offset"])


def series_spec(series: Series) -> tuple[dict[str, Any], int]:
    """The series as the script wants it, and how many of its points were left out.

    Raises ValueError when its arrays differ in length.
    """
    x, y = _column(series, series.x), _column(series, series.y)
    kept = keep(x, y)
    spec: dict[str, Any] = {
        "name": series.name,
        "colour": series.colour.value,
        "style": series.style.value,
        "dashed": series.dashed,
        "hidden": series.hidden,
        "sorted": is_increasing(x),
        "x": pack(x[kept]),
        "y": pack(y[kept]),
    }
    for name, values in (("low", series.low), ("high", series.high)):
        if values is not None:
            spec[name] = pack(_column(series, values)[kept])
    return spec, len(x) - len(kept)


def _column(series: Series, values: ArrayLike) -> FloatArray:
    column = np.asarray(values, dtype=np.float64)
    if column.shape != np.shape(series.x) or column.ndim != 1:
        raise ValueError(f"series '{series.name}': x, y, low and high must be equally long")
    return np.where(np.isfinite(column), column, np.nan)


def script_json(data: Any) -> str:
    """JSON that cannot end the script element that contains it."""
    text = json.dumps(data, separators=(",", ":"), allow_nan=False)
    return text.replace("<", "\\u003c").replace("\u2028", "\\u2028").replace("\u2029", "\\u2029")


def spoken(spec: dict[str, Any]) -> str:
    """Axes, and where each curve lies: read out instead of the picture."""
    if spec["kind"] == "heat":
        names = ", ".join(spec["rows"])
        states = ", ".join(state["name"] for state in spec["states"]) or spec["unit"]
        return f"Rows {names} over {spec['xLabel']}; colours: {states}."
    said = [f"{spec['yLabel']} over {spec['xLabel']}."]
    for series in spec["series"]:
        x, y = unpack(series["x"]), unpack(series["y"])
        known = np.isfinite(x) & np.isfinite(y)
        if not known.any():
            said.append(f"{series['name']}: empty.")
            continue
        x, y = x[known], y[known]
        said.append(
            f"{series['name']}: {len(y)} points from {y.min():.4g} to {y.max():.4g}, mean "
            f"{y.mean():.4g}, between {x.min():.4g} and {x.max():.4g}{_band(series)}."
        )
    said += [f"Mark at {mark['x']:.4g}: {mark['label']}." for mark in spec["marks"]]
    return " ".join(said)


def _band(series: dict[str, Any]) -> str:
    """How far the band around a curve reaches; empty without one."""
    if "low" not in series or "high" not in series:
        return ""
    low, high = unpack(series["low"]), unpack(series["high"])
    if not (np.isfinite(low).any() and np.isfinite(high).any()):
        return ""
    return f", in a band from {np.nanmin(low):.4g} to {np.nanmax(high):.4g}"


def column_names(spec: dict[str, Any]) -> dict[str, str]:
    """Heads of the columns of a saved table, by their names in the drawing."""
    if spec["kind"] == "heat":
        value = f"value [{spec['unit']}]" if spec["unit"] else "value"
        return {"left": f"from {spec['xLabel']}", "right": f"to {spec['xLabel']}", "value": value}
    names = {"x": spec["xLabel"]}
    for number, series in enumerate(spec["series"]):
        for column, suffix in (("y", ""), ("low", ", low"), ("high", ", high")):
            names[f"{column}{number}"] = f"{series['name']}{suffix}"
    return names
