"""A chart in words, for those who do not see it, and the names of its columns."""

from __future__ import annotations

from typing import Any

import numpy as np

from deltactl.charts.spec import unpack


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
