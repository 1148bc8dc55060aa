"""A case on disk: what the diagnosis may see in one folder, the answers in another file."""

from __future__ import annotations

import json
from pathlib import Path

import numpy as np

from deltactl.foundation.plain_file import write_whole
from deltactl.proof.cases import Case
from deltactl.proof.recorded import record, record_with_truth
from deltactl.proof.robot.run import Truth
from deltactl.recording.tables.flat_files import write_flat

ROBOT = """\
# What the robot of the proof was meant to be (Zhao 2023, Tables 1 and 2).
kind: delta
name: proof-robot
geometry:
  base_radius_m: 0.325
  platform_radius_m: 0.075
  upper_arm_m: 0.25
  forearm_m: 0.5
  azimuth_deg: [0, 120, 240]
masses: {upper_arm_kg: 0.205, forearm_kg: 0.153, platform_kg: 0.653}
drive: {microsteps_per_rev: 1600, gear_ratio: 10}
sensors:
  x: {offset_m: 0.60, axis: [1, 0, 0]}
  y: {offset_m: 0.60, axis: [0, 1, 0]}
  z: {offset_m: 0.90, axis: [0, 0, 1]}
"""
RECORDING, HOLDOUT, ROBOT_FILE = "recording.csv.gz", "holdout.csv.gz", "robot.yaml"


def write_blind(case: Case, folder: Path, seed: int) -> Truth:
    """Simulate both runs and write them with the robot file; no word of what is concealed.

    Returns what really happened in the first run.
    """
    folder.mkdir(parents=True, exist_ok=True)
    rng = np.random.default_rng([seed, case.number, 1])
    recording, truth = record_with_truth(case.machine, case.train, rng)
    write_flat(recording, folder / RECORDING)
    write_flat(record(case.holdout_machine, case.holdout_train, rng), folder / HOLDOUT)
    write_whole(folder / ROBOT_FILE, ROBOT)
    return truth


def write_answers(case: Case, path: Path) -> None:
    """The truth, as JSON."""
    path.parent.mkdir(parents=True, exist_ok=True)
    write_whole(path, json.dumps(case.truth(), indent=1) + "\n")
