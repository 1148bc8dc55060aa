"""What a chart is, before it is drawn: the parts of its picture, in plain data classes."""

from __future__ import annotations

import base64
import enum
import json
from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import ArrayLike

from deltactl.charts import thin
from deltactl.charts.thin import FloatArray


class Style(enum.Enum):
    """How a series is drawn."""

    LINE = "line"
    POINTS = "points"
    STEP = "step"
    """The value holds until the next point."""
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
    kept = thin.keep(x, y)
    spec: dict[str, Any] = {
        "name": series.name,
        "colour": series.colour.value,
        "style": series.style.value,
        "dashed": series.dashed,
        "hidden": series.hidden,
        "sorted": thin.is_increasing(x),
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
    """JSON that cannot end the script element it stands in."""
    text = json.dumps(data, separators=(",", ":"), allow_nan=False)
    return text.replace("<", "\\u003c").replace("\u2028", "\\u2028").replace("\u2029", "\\u2029")
