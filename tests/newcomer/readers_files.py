"""What a reader has and a test writes: a small table, a part in G-code, a corrected robot file."""

from __future__ import annotations

import json
import re
from collections.abc import Callable
from pathlib import Path

import numpy as np

from tests.rigs.documented import ROOT

AXIS = "kind: servo_axis\nname: elbow\nmotion: rotary\n"
GCODE = "G21 G90\nG0 X0 Y0 Z0\nG1 X10 Y0 F3000\nG3 X0 Y10 I-10 J0\nG4 P200\nG0 X0 Y0\n"
POINTS = "x,y,z\n0,0,-260\n20,0,-260\n20,20,-260\n"


def _motion() -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Times [s], a command and what came of it, 0.05 s later [degrees]; shape (600,) each."""
    t_s = np.arange(600) * 0.02
    noise = np.random.default_rng(1).normal(0.0, 0.02, t_s.shape)
    return t_s, 30.0 * np.sin(t_s), 30.0 * np.sin(t_s - 0.05) + noise


def _table(path: Path) -> None:
    """The columns that README names: time, angle, target."""
    t_s, target, angle = _motion()
    rows = (f"{1e3 * t:g},{a:.4f},{c:.4f}" for t, c, a in zip(t_s, target, angle, strict=True))
    path.write_text("time,angle,target\n" + "\n".join(rows) + "\n")


JOINTS = ["shoulder_pan.pos", "shoulder_lift.pos", "elbow_flex.pos"]


def _episodes(path: Path) -> None:
    """A data set as LeRobot has them: a folder, with joints of which the third moves."""
    import pyarrow as pa
    import pyarrow.parquet as pq

    t_s, target, angle = _motion()
    still = np.zeros_like(t_s)
    table = {
        "timestamp": t_s,
        "episode_index": np.zeros(len(t_s), dtype=np.int64),
        "action": [list(row) for row in np.stack([still, still, target], axis=1)],
        "observation.state": [list(row) for row in np.stack([still, still, angle], axis=1)],
    }
    features = {name: {"names": JOINTS} for name in ("action", "observation.state")}
    for folder in ("meta", "data/chunk-000"):
        (path / folder).mkdir(parents=True)
    (path / "meta/info.json").write_text(json.dumps({"fps": 50, "features": features}))
    pq.write_table(pa.table(table), path / "data/chunk-000/file-000.parquet")


def _corrected(path: Path) -> None:
    text = (ROOT / "config" / "zhao-2023.yaml").read_text(encoding="utf-8")
    text += "\neffects: [{effect: home_offset, component: motor2, parameters: {angle: 0.004}}]\n"
    path.write_text(re.sub(r"^effects: \[\]\n", "", text, flags=re.MULTILINE))


FILES: dict[str, Callable[[Path], object]] = {
    "data.csv": _table,
    "log.csv": _table,
    "so100": _episodes,
    "axis.yaml": lambda path: path.write_text(AXIS),
    "part.gcode": lambda path: path.write_text(GCODE),
    "points.csv": lambda path: path.write_text(POINTS),
    "mine.yaml": _corrected,
}
"""By name, how each is written."""
