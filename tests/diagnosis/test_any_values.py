"""Recordings with any values in them: an answer that keeps the contract, or one line."""

from __future__ import annotations

import json
from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest
from hypothesis import HealthCheck, Phase, given, seed, settings
from hypothesis import strategies as st

from benchmarks.proofs.contradictions import contradictions
from deltactl.diagnosis.answer.records import Diagnosis
from deltactl.diagnosis.api import diagnose
from deltactl.foundation.errors import DeltactlError
from deltactl.recording.tables.flat import FlatRecording
from deltactl.recording.tables.flat_files import write_flat

ZHAO = Path(__file__).parents[2] / "config" / "zhao-2023.yaml"
AXIS = "kind: servo_axis\nname: any\nmotion: rotary\ninertia: 1.0\n"
SENSOR = "kind: range_sensor\nname: any\n"
NUMBERS = st.one_of(
    st.floats(allow_nan=True, allow_infinity=False),
    st.sampled_from([0.0, -0.0, 1e-320, 1e300, -1e300, 2.0**53, 1e9, np.pi, 90.0, 0.5, -1.0]),
)
ROWS = 120
Spoil = Callable[[np.ndarray], np.ndarray]


def spoils() -> st.SearchStrategy[Spoil]:
    """Ways to spoil a column: single cells, a stretch, all of it, its scale, or its holes."""
    cells = st.tuples(st.lists(st.integers(0, ROWS - 1), max_size=8), NUMBERS)
    return st.one_of(
        cells.map(lambda c: lambda x: _set(x, c[0], c[1])),
        st.tuples(st.integers(0, ROWS - 2), st.integers(1, ROWS), NUMBERS).map(
            lambda c: lambda x: _set(x, list(range(c[0], min(c[0] + c[1], ROWS))), c[2])
        ),
        NUMBERS.map(lambda v: lambda x: np.full_like(x, v)),
        st.sampled_from([1e-12, 1e-3, -1.0, 57.3, 1e3, 1e6, 1e200]).map(lambda k: lambda x: k * x),
        st.integers(2, 9).map(lambda k: lambda x: np.where(np.arange(len(x)) % k, x, np.nan)),
        st.sampled_from([np.sort, np.flip, np.cumsum, np.round]).map(lambda f: lambda x: f(x)),
    )


def _set(values: np.ndarray, rows: list[int], number: float) -> np.ndarray:
    changed = values.copy()
    changed[rows] = number
    return changed


def delta_table() -> dict[str, np.ndarray]:
    t_s = 0.02 * np.arange(ROWS)
    wave = [np.round(700.0 + 300.0 * np.sin(1.3 * t_s + k)) for k in range(3)]
    table = {"t": t_s} | {f"steps_{k + 1}": wave[k] for k in range(3)}
    return table | {f"range_{a}": 0.5 + 1e-4 * wave[k] for k, a in enumerate("xyz")}


def axis_table() -> dict[str, np.ndarray]:
    t_s = 0.02 * np.arange(ROWS)
    return {"t": t_s, "position": np.sin(t_s), "effort": -np.sin(t_s), "command": np.sin(t_s)}


def sensor_table() -> dict[str, np.ndarray]:
    t_s = 0.02 * np.arange(ROWS)
    return {"t": t_s, "distance": 0.3 + 0.1 * np.sin(t_s), "range": 0.31 + 0.1 * np.sin(t_s)}


@pytest.mark.study
@pytest.mark.parametrize(("kind", "spoiled"), [("delta", 2), ("axis", 1), ("sensor", 1)])
@pytest.mark.filterwarnings("ignore::RuntimeWarning")
@seed(20)
@settings(
    max_examples=6, deadline=None, phases=[Phase.generate],
    suppress_health_check=[HealthCheck.function_scoped_fixture, HealthCheck.too_slow],
)  # fmt: skip
@given(st.data())
def test_an_answer_that_keeps_the_contract_or_one_line(
    tmp_path: Path, kind: str, spoiled: int, data: st.DataObject
) -> None:
    robot = ZHAO
    if kind != "delta":
        robot = tmp_path / "robot.yaml"
        robot.write_text(AXIS if kind == "axis" else SENSOR)
    table = {"delta": delta_table, "axis": axis_table, "sensor": sensor_table}[kind]()
    for name in data.draw(st.lists(st.sampled_from(sorted(table)), min_size=spoiled, max_size=3)):
        table[name] = data.draw(spoils())(table[name])
    path = tmp_path / "any.csv"
    t_s = table.pop("t")
    write_flat(FlatRecording(t_s, table, {}, "any"), path)
    refused = ""
    try:
        answer = diagnose([path], robot)
    except DeltactlError as error:
        refused = str(error)
    if refused:
        assert "\n" not in refused
        assert len(refused) < 600
        return
    assert contradictions(answer) == []
    said = json.loads(json.dumps(answer.to_json(), allow_nan=False))
    assert Diagnosis.model_validate(said).verdict == answer.verdict
