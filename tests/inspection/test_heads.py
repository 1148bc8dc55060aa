"""Logs with the real column names of forty programs are read as their owners mean them, and the
command that is printed for them runs.
"""

from __future__ import annotations

import json
import shlex
from pathlib import Path

import numpy as np
import pytest
import yaml
from typer.testing import CliRunner

from deltactl.cli.main import app
from deltactl.recording.foreign.inspection import inspect
from deltactl.recording.foreign.mapping import load_mapping
from deltactl.recording.foreign.reading import read_mapped
from tests.inspection.heads import GEOMETRY, Head, heads, truth, write
from tests.inspection.test_printed_commands import put
from tests.rigs.owners_words import owner_says

HEADS = {
    head.program: head
    for file in ("heads.yaml", "heads_further.yaml")
    for head in heads(Path(__file__).with_name(file))
}
NO_SIZES = ("kind", "t", "effort", "velocity")


@pytest.fixture(params=HEADS)
def head(request: pytest.FixtureRequest) -> Head:
    return HEADS[request.param]


def test_columns_are_what_their_owners_mean(head: Head, tmp_path: Path) -> None:
    """And the options that are printed read them, in the right size."""
    path = tmp_path / "log.csv"
    write(head, path)
    found = inspect(path)
    taken = {"kind": found.kind} | {one.name: one.source for one in found.guesses.values()}
    wrong = {n: taken.get(n) for n, right in head.right.items() if taken.get(n) not in right}
    assert not wrong
    if found.kind is None:
        assert not {"command", "distance", "effort"} & taken.keys()
        return
    read = read_mapped(path, load_mapping(None, owner_says(found)))
    if "t" in head.right:
        assert read.period_s() == pytest.approx(1.0 / head.rate_hz, rel=0.01)
    elif found.kind != "range_sensor":
        assert any(option.startswith("rate_hz=") for option in found.options)
    moving = [name for name in head.right if name not in NO_SIZES]
    if head.unsaid:
        asked = [one for one in found.warnings if any(str(taken[n]) in one for n in moving)]
        assert asked, "nothing says the unit, and nobody is asked for it"
        return
    for name in moving:
        far = np.ptp(truth(head, str(taken[name])))
        assert np.ptp(read.columns[name]) == pytest.approx(far, rel=0.05), name


def run(*words: str) -> str:
    done = CliRunner().invoke(app, list(words))
    assert done.exit_code == 0, done.output
    return done.stdout


@pytest.mark.study
@pytest.mark.parametrize(
    "program", ["SimpleFOCStudio", "Arduino serial plotter", "Zaber oscilloscope"]
)
def test_the_commands_that_are_printed_run_as_they_are(
    program: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Without times, with labels, with spaces and brackets in names."""
    monkeypatch.chdir(tmp_path)
    write(HEADS[program], tmp_path / "the log.csv")
    printed = run("inspect", "the log.csv")
    typed = [line.partition(":")[2] for line in printed.splitlines() if ": " in line]
    commands = [shlex.split(one) for one in typed if one.strip().startswith("deltactl ")]
    assert len(commands) == 2
    for command in commands:
        run(
            *put(command[1:], "rad", "rotary"),
            *(["--json", "-"] if command[1] == "diagnose" else []),
        )


@pytest.mark.study
def test_what_inspect_says_diagnose_does_without_options(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.chdir(tmp_path)
    write(HEADS["Zaber oscilloscope"], tmp_path / "log.csv")
    (tmp_path / "axis.yaml").write_text("kind: servo_axis\nname: mine\nmotion: linear\n")
    options = inspect(tmp_path / "log.csv").options
    plain = json.loads(run("diagnose", "log.csv", "--robot", "axis.yaml", "--json", "-"))
    said = json.loads(run("diagnose", "log.csv", "--robot", "axis.yaml", "--json", "-", *options))
    assert plain["findings"] == said["findings"]


@pytest.mark.study
def test_a_delta_without_commands_is_calibrated(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Its encoders and a tracker find an arm that is longer than its robot file says."""
    monkeypatch.chdir(tmp_path)
    write(HEADS["a delta's encoders and a tracker in mm"], tmp_path / "log.csv")
    geometry = GEOMETRY.model_dump(include={"base_radius_m", "platform_radius_m", "forearm_m"})
    robot = {"kind": "delta", "name": "mine", "geometry": geometry | {"upper_arm_m": 0.198}}
    (tmp_path / "delta.yaml").write_text(yaml.safe_dump(json.loads(json.dumps(robot))))
    answer = json.loads(run("diagnose", "log.csv", "--robot", "delta.yaml", "--json", "-"))
    assert any("upper_arm" in json.dumps(one) for one in answer["findings"])
