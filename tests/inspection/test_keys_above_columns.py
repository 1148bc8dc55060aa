"""Exports that repeat a key before each value, above columns that each have their own times."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from deltactl.recording.foreign.inspection import inspect
from deltactl.recording.foreign.mapping import load_mapping
from deltactl.recording.foreign.reading import read_mapped

N = 600
ASKED_MM = 200.0 + 150.0 * np.sin(0.01 * np.arange(N)) + 20.0 * np.sin(0.053 * np.arange(N))
SEEN_MM = np.interp(np.arange(N) - 2.0, np.arange(N), ASKED_MM)


def write(path: Path, separator: str, decimal: str) -> Path:
    """Two channels as TwinCAT Scope exports them."""
    channels = {"Axis1.SetPos": ASKED_MM, "Axis1.ActPos": SEEN_MM}
    of_each = {
        "Name": [*channels],
        "SymbolComment": ["", ""],
        "Data-Type": ["REAL64", "REAL64"],
        "SampleTime[ms]": ["2", "2"],
        "Port": ["501", "501"],
        "Unit": ["mm (Length)", "mm (Length)"],
        "Unit Offset": ["0", "0"],
    }
    lines = ["Name,Scope".replace(",", separator), "File,axis".replace(",", separator), ""]
    lines += [separator.join(f"{k}{separator}{v}" for v in vs) for k, vs in of_each.items()]
    for n, row in enumerate(zip(*channels.values(), strict=True)):
        cells = [f"{2 * n}{separator}{value:.5f}".replace(".", decimal) for value in row]
        lines.append(separator.join(cells))
    path.write_text("\n".join(lines) + "\n", encoding="utf-8")
    return path


@pytest.mark.parametrize(("separator", "decimal"), [("\t", ","), (";", ","), (",", ".")])
def test_names_units_and_times_are_found(tmp_path: Path, separator: str, decimal: str) -> None:
    path = write(tmp_path / "scope.csv", separator, decimal)
    seen = inspect(path)
    assert (seen.kind, seen.motion) == ("servo_axis", "linear")
    read = read_mapped(path, load_mapping(None, seen.options[1::2]))
    np.testing.assert_allclose(read.t_s - read.t_s[0], 0.002 * np.arange(N), atol=1e-9)
    np.testing.assert_allclose(read.column("command"), 1e-3 * ASKED_MM, atol=1e-8)
    np.testing.assert_allclose(read.column("position"), 1e-3 * SEEN_MM, atol=1e-8)
